#include "remaps/resample/dyadic_grid.h"

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps::resample {
namespace {

std::uint64_t interior_points(unsigned level) {
  const std::uint64_t n = std::uint64_t{1} << level;
  return level == 0 ? 0 : (n - 1) * (n - 2) / 2;
}

}  // namespace

DyadicGrid::DyadicGrid(std::uint32_t base_vertices, std::span<const BaseTriangle> base,
                       unsigned level)
    : level_(level),
      n_(1u << level),
      base_vertices_(base_vertices),
      base_(base.begin(), base.end()),
      use_(base.size()),
      first_at_corner_(base.size()) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edge;
  std::vector<bool> seen(base_vertices, false);
  for (std::size_t f = 0; f < base_.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = base_[f][k];
      const std::uint32_t b = base_[f][(k + 1) % 3];
      const auto [at, fresh] = edge.try_emplace({std::min(a, b), std::max(a, b)}, edges_);
      if (fresh) ++edges_;
      use_[f][k] = {at->second, a > b, fresh};
      first_at_corner_[f][k] = !seen[a];
      seen[a] = true;
    }
  }
  row_start_.resize(level + 1);
  for (unsigned l = 1; l <= level; ++l) {
    const std::uint64_t n = std::uint64_t{1} << l;
    std::uint64_t before = 0;
    row_start_[l].push_back(0);
    for (std::uint64_t j = 1; j < n; ++j) {
      row_start_[l].push_back(before);
      before += j % 2 == 1 ? n - j - 1 : (n - j) / 2;
    }
  }
}

std::uint64_t DyadicGrid::vertices() const {
  return base_vertices_ + edges_ * std::uint64_t{n_ - 1} + base_.size() * interior_points(level_);
}

std::uint64_t DyadicGrid::edge_point(const EdgeUse& use, std::uint32_t m) const {
  if (use.reversed) m = n_ - m;
  const auto zeros = static_cast<unsigned>(std::countr_zero(m));
  const unsigned l = level_ - zeros;
  const std::uint64_t within = ((std::uint64_t{1} << (l - 1)) - 1) + (m >> zeros >> 1);
  return base_vertices_ + use.edge * std::uint64_t{n_ - 1} + within;
}

std::uint64_t DyadicGrid::interior_point(std::uint32_t i, std::uint32_t j) const {
  const auto zeros = static_cast<unsigned>(std::min(std::countr_zero(i), std::countr_zero(j)));
  const unsigned l = level_ - zeros;
  i >>= zeros;
  j >>= zeros;
  const std::uint64_t in_row = j % 2 == 1 ? i - 1 : i / 2;
  return interior_points(l - 1) + row_start_[l][j] + in_row;
}

std::uint64_t DyadicGrid::vertex(std::uint32_t face, std::uint32_t i, std::uint32_t j) const {
  const std::uint32_t k = n_ - i - j;
  if (k == n_) return base_[face][0];
  if (i == n_) return base_[face][1];
  if (j == n_) return base_[face][2];
  if (j == 0) return edge_point(use_[face][0], i);
  if (k == 0) return edge_point(use_[face][1], j);
  if (i == 0) return edge_point(use_[face][2], k);
  return base_vertices_ + edges_ * std::uint64_t{n_ - 1} + face * interior_points(level_) +
         interior_point(i, j);
}

Triangle DyadicGrid::triangle(std::uint64_t index) const {
  struct Point {
    std::uint32_t i, j;
  };
  const auto face = static_cast<std::uint32_t>(index >> (2 * level_));
  std::array<Point, 3> corner{Point{0, 0}, Point{n_, 0}, Point{0, n_}};
  const auto middle = [](Point a, Point b) { return Point{(a.i + b.i) / 2, (a.j + b.j) / 2}; };
  for (unsigned l = level_; l-- > 0;) {
    const Point m01 = middle(corner[0], corner[1]);
    const Point m12 = middle(corner[1], corner[2]);
    const Point m20 = middle(corner[2], corner[0]);
    switch ((index >> (2 * l)) & 3) {
      case 0:
        corner = {corner[0], m01, m20};
        break;
      case 1:
        corner = {m01, corner[1], m12};
        break;
      case 2:
        corner = {m20, m12, corner[2]};
        break;
      default:
        corner = {m12, m20, m01};
        break;
    }
  }
  return {vertex(face, corner[0].i, corner[0].j), vertex(face, corner[1].i, corner[1].j),
          vertex(face, corner[2].i, corner[2].j)};
}

void DyadicGrid::for_each_sample(
    const std::function<void(std::uint64_t, std::uint32_t, double, double)>& sample) const {
  for (std::uint32_t f = 0; f < base_.size(); ++f) {
    for (std::uint32_t j = 0; j <= n_; ++j) {
      for (std::uint32_t i = 0; i + j <= n_; ++i) {
        const std::uint32_t k = n_ - i - j;
        bool mine = true;
        if (k == n_ || i == n_ || j == n_) {
          mine = first_at_corner_[f][k == n_ ? 0 : i == n_ ? 1 : 2];
        } else if (i == 0 || j == 0 || k == 0) {
          mine = use_[f][j == 0 ? 0 : k == 0 ? 1 : 2].first;
        }
        if (mine) sample(vertex(f, i, j), f, double(i) / n_, double(j) / n_);
      }
    }
  }
}

}  // namespace remaps::resample
