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

void BoxTree::Group::set4(unsigned i, const FloatBox& a, const FloatBox& b, const FloatBox& c,
                          const FloatBox& d, FloatBox& sum) {
  const auto rows = [i](Float4 x, Float4 y, Float4 z, Float4 unused, auto& to) {
    transpose(x, y, z, unused);
    x.store(&to[0][i]);
    y.store(&to[1][i]);
    z.store(&to[2][i]);
  };
  const Float4 la = a.low.all(), lb = b.low.all(), lc = c.low.all(), ld = d.low.all();
  const Float4 ha = a.high.all(), hb = b.high.all(), hc = c.high.all(), hd = d.high.all();
  sum.low = Float3::of(min(sum.low.all(), min(min(la, lb), min(lc, ld))));
  sum.high = Float3::of(max(sum.high.all(), max(max(ha, hb), max(hc, hd))));
  rows(la, lb, lc, ld, low);
  rows(ha, hb, hc, hd, high);
}

void BoxTree::build(std::span<const FloatBox> items) {
  items_ = static_cast<std::uint32_t>(items.size());
  box_ = {};
  for (const FloatBox& item : items) box_.add(item);
  sort(items);
  groups_.clear();
  first_.clear();
  count_.clear();
  add_level(items, false);
  while (count_.back() > 1) {
    std::swap(level_box_, below_box_);
    add_level(below_box_, true);
  }
}

/// Fills order_.
void BoxTree::sort(std::span<const FloatBox> items) {
  const unsigned bits = cell_bits(items.size());
  const unsigned last = (1u << bits) - 1;
  std::array<std::uint32_t, 64> spread;
  for (unsigned i = 0; i <= last; ++i) spread[i] = static_cast<std::uint32_t>(spread_bits(i));
  // The centre of a box is half the sum of its corners.
  const float low_x = 2 * box_.low.x, low_y = 2 * box_.low.y, low_z = 2 * box_.low.z;
  const float extent = box_.extent();
  const float cells = extent > kLeastExtent ? 0.5f * static_cast<float>(last + 1) / extent : 0.0f;
  const auto along = [&](float sum, float low) {
    return spread[std::min(static_cast<unsigned>((sum - low) * cells), last)];
  };
  past_.assign(std::size_t{1} << 3 * bits, 0);
  cell_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    const FloatBox& b = items[i];
    const std::uint32_t cell = along(b.low.x + b.high.x, low_x) |
                               along(b.low.y + b.high.y, low_y) << 1 |
                               along(b.low.z + b.high.z, low_z) << 2;
    cell_[i] = cell;
    ++past_[cell];
  }
  std::uint32_t before = 0;
  for (std::uint32_t& past : past_) before += std::exchange(past, before);
  order_.resize(items.size());
  for (std::uint32_t i = 0; i < items_; ++i) order_[past_[cell_[i]]++] = i;
}

/// Groups the boxes, and leaves those of the groups in level_box_.
void BoxTree::add_level(std::span<const FloatBox> boxes, bool sorted) {
  const std::size_t n = (boxes.size() + kWidth - 1) / kWidth;
  first_.push_back(static_cast<std::uint32_t>(groups_.size()));
  count_.push_back(static_cast<std::uint32_t>(n));
  groups_.resize(groups_.size() + n);
  groups_.back().clear();
  level_box_.clear();
  const auto box_at = [&](std::size_t at) -> const FloatBox& {
    return boxes[sorted ? at : order_[at]];
  };
  Group* group = &groups_[first_.back()];
  for (std::size_t at = 0; at < boxes.size(); ++group) {
    FloatBox sum;
    unsigned i = 0;
    for (; i < kWidth && at + 4 <= boxes.size(); i += 4, at += 4) {
      group->set4(i, box_at(at), box_at(at + 1), box_at(at + 2), box_at(at + 3), sum);
    }
    for (; i < kWidth && at < boxes.size(); ++i, ++at) {
      group->set(i, box_at(at));
      sum.add(box_at(at));
    }
    level_box_.push_back(sum);
  }
}

}  // namespace remaps
