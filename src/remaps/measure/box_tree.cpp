#include "remaps/measure/box_tree.h"

#include <utility>

#include "remaps/measure/morton.h"

namespace remaps {
namespace {

/// Extents that could make a quotient overflow.
constexpr float kLeastExtent = 1e-30f;

/// The bits of the number of cells along a side of the cube that holds all items: so many that
/// those on a surface have some 16 items.
unsigned cell_bits(std::size_t items) {
  unsigned bits = 1;
  while (bits < 6 && (std::size_t{16} << 2 * (bits + 1)) <= items) ++bits;
  return bits;
}

}  // namespace

void BoxTree::Group::clear() {
  for (auto& axis : low) axis.fill(std::numeric_limits<float>::infinity());
  for (auto& axis : high) axis.fill(-std::numeric_limits<float>::infinity());
}

void BoxTree::Group::set(unsigned i, const FloatBox& box) {
  low[0][i] = box.low.x, low[1][i] = box.low.y, low[2][i] = box.low.z;
  high[0][i] = box.high.x, high[1][i] = box.high.y, high[2][i] = box.high.z;
}

BoxTree::Cells::Cells(const FloatBox& around, std::uint32_t items)
    : bits_(cell_bits(items)), low_(around.low.all() + around.low.all()) {
  const unsigned cells = 1u << bits_;
  for (unsigned i = 0; i < cells; ++i) spread_[i] = static_cast<std::uint32_t>(spread_bits(i));
  const float extent = around.extent();
  cells_ = all4(extent > kLeastExtent ? 0.5f * static_cast<float>(cells) / extent : 0.0f);
}

void BoxTree::begin_sort(std::uint32_t items, const Cells& cells) {
  past_.assign(cells.size(), 0);
  cell_.resize(items);
}

void BoxTree::end_sort() {
  std::uint32_t before = 0;
  for (std::uint32_t& past : past_) before += std::exchange(past, before);
  order_.resize(cell_.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) order_[past_[cell_[i]]++] = i;
  groups_.clear();
  first_.clear();
  count_.clear();
}

BoxTree::Group* BoxTree::begin_level(std::uint32_t boxes) {
  const std::uint32_t n = (boxes + kWidth - 1) / kWidth;
  first_.push_back(static_cast<std::uint32_t>(groups_.size()));
  count_.push_back(n);
  groups_.resize(groups_.size() + n);
  groups_.back().clear();
  level_box_.clear();
  return &groups_[first_.back()];
}

void BoxTree::add_upper_levels() {
  while (count_.back() > 1) {
    std::swap(level_box_, below_box_);
    add_level(count_.back(), [&](std::uint32_t at) { return below_box_[at]; });
  }
}

}  // namespace remaps
