#include "remaps/resample/dyadic_grid.h"

#include <algorithm>
#include <bit>
#include <map>
#include <string>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps::resample {
namespace {

std::uint64_t inner_points(unsigned level) {
  const std::uint64_t n = std::uint64_t{1} << level;
  return level == 0 ? 0 : (n - 1) * (n - 2) / 2;
}

/// Descends from a face to its part `index`, of those that `levels` splits make.
template <class Point>
std::array<Point, 3> descend(std::array<Point, 3> corner, std::uint64_t index, unsigned levels) {
  const auto middle = [](Point a, Point b) { return Point{(a.i + b.i) / 2, (a.j + b.j) / 2}; };
  while (levels-- > 0) {
    const Point m01 = middle(corner[0], corner[1]);
    const Point m12 = middle(corner[1], corner[2]);
    const Point m20 = middle(corner[2], corner[0]);
    switch ((index >> (2 * levels)) & 3) {
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
  return corner;
}

/// Takes up to n elements off the front.
template <class T>
std::span<T> take_front(std::span<T>& all, std::uint64_t n) {
  const auto part = all.first(static_cast<std::size_t>(std::min<std::uint64_t>(n, all.size())));
  all = all.subspan(part.size());
  return part;
}

}  // namespace

DyadicGrid::DyadicGrid(std::uint32_t base_vertices, std::span<const BaseTriangle> base,
                       unsigned level)
    : level_(level),
      n_(1u << level),
      base_vertices_(base_vertices),
      base_(base.begin(), base.end()),
      use_(base.size()),
      corner_of_(base_vertices) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edge;
  for (std::uint32_t f = 0; f < base_.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = base_[f][k];
      const std::uint32_t b = base_[f][(k + 1) % 3];
      const auto [at, fresh] = edge.try_emplace({std::min(a, b), std::max(a, b)},
                                                static_cast<std::uint32_t>(edge_of_.size()));
      if (fresh) edge_of_.push_back({f, k});
      use_[f][k] = {at->second, a > b};
      if (corner_of_[a].face == kNoIndex) corner_of_[a] = {f, k};
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
  build_block();
}

void DyadicGrid::build_block() {
  block_level_ = std::min(level_, kBlockLevels);
  const std::uint32_t n = 1u << block_level_;
  std::vector<std::vector<std::uint16_t>> number(n + 1);
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i + j <= n; ++i) {
      number[j].push_back(static_cast<std::uint16_t>(block_point_.size()));
      block_point_.push_back({i, j});
    }
  }
  const std::array<GridPoint, 3> whole{GridPoint{0, 0}, GridPoint{n, 0}, GridPoint{0, n}};
  for (std::uint64_t f = 0; f < std::uint64_t{1} << (2 * block_level_); ++f) {
    const std::array<GridPoint, 3> corner = descend(whole, f, block_level_);
    block_face_.push_back({number[corner[0].j][corner[0].i], number[corner[1].j][corner[1].i],
                           number[corner[2].j][corner[2].i]});
  }
}

std::uint64_t DyadicGrid::first_inner_point() const {
  return base_vertices_ + edge_of_.size() * std::uint64_t{n_ - 1};
}

std::uint64_t DyadicGrid::vertices() const {
  return first_inner_point() + base_.size() * inner_points(level_);
}

std::uint64_t DyadicGrid::edge_point(const EdgeUse& use, std::uint32_t m) const {
  if (use.reversed) m = n_ - m;
  const auto zeros = static_cast<unsigned>(std::countr_zero(m));
  const unsigned l = level_ - zeros;
  const std::uint64_t within = ((std::uint64_t{1} << (l - 1)) - 1) + (m >> zeros >> 1);
  return base_vertices_ + use.edge * std::uint64_t{n_ - 1} + within;
}

std::uint64_t DyadicGrid::inner_point(std::uint32_t i, std::uint32_t j) const {
  const auto zeros = static_cast<unsigned>(std::countr_zero(i | j));
  const unsigned l = level_ - zeros;
  i >>= zeros;
  j >>= zeros;
  const std::uint64_t in_row = j % 2 == 1 ? i - 1 : i / 2;
  return inner_points(l - 1) + row_start_[l][j] + in_row;
}

std::uint64_t DyadicGrid::vertex(std::uint32_t face, std::uint32_t i, std::uint32_t j) const {
  const std::uint32_t k = n_ - i - j;
  if (i != 0 && j != 0 && k != 0) {
    return first_inner_point() + face * inner_points(level_) + inner_point(i, j);
  }
  if (k == n_) return base_[face][0];
  if (i == n_) return base_[face][1];
  if (j == n_) return base_[face][2];
  if (j == 0) return edge_point(use_[face][0], i);
  if (k == 0) return edge_point(use_[face][1], j);
  return edge_point(use_[face][2], k);
}

std::array<std::array<std::uint32_t, 2>, 3> DyadicGrid::corners(std::uint64_t index) const {
  const std::array<GridPoint, 3> corner =
      descend<GridPoint>({GridPoint{0, 0}, GridPoint{n_, 0}, GridPoint{0, n_}}, index, level_);
  return {{{corner[0].i, corner[0].j}, {corner[1].i, corner[1].j}, {corner[2].i, corner[2].j}}};
}

Triangle DyadicGrid::triangle(std::uint64_t index) const {
  const auto face = static_cast<std::uint32_t>(index >> (2 * level_));
  const std::array<GridPoint, 3> corner =
      descend<GridPoint>({GridPoint{0, 0}, GridPoint{n_, 0}, GridPoint{0, n_}}, index, level_);
  return {vertex(face, corner[0].i, corner[0].j), vertex(face, corner[1].i, corner[1].j),
          vertex(face, corner[2].i, corner[2].j)};
}

void DyadicGrid::triangles(std::uint64_t first, std::span<Triangle> out) const {
  const std::uint64_t block_faces = block_face_.size();
  std::vector<std::uint64_t> number(block_point_.size());
  while (!out.empty()) {
    if (first % block_faces != 0 || out.size() < block_faces) {
      take_front(out, 1)[0] = triangle(first++);
      continue;
    }
    const auto face = static_cast<std::uint32_t>(first >> (2 * level_));
    const std::array<GridPoint, 3> corner =
        descend<GridPoint>({GridPoint{0, 0}, GridPoint{n_, 0}, GridPoint{0, n_}},
                           first >> (2 * block_level_), level_ - block_level_);
    // Unsigned numbers that wrap round: the sums are right again.
    const auto step = [&](std::uint32_t from, std::uint32_t to) {
      return static_cast<std::uint32_t>((std::int64_t{to} - std::int64_t{from}) >> block_level_);
    };
    const GridPoint a{step(corner[0].i, corner[1].i), step(corner[0].j, corner[1].j)};
    const GridPoint b{step(corner[0].i, corner[2].i), step(corner[0].j, corner[2].j)};
    for (std::size_t p = 0; p < number.size(); ++p) {
      const GridPoint& at = block_point_[p];
      number[p] = vertex(face, corner[0].i + at.i * a.i + at.j * b.i,
                         corner[0].j + at.i * a.j + at.j * b.j);
    }
    const std::span<Triangle> block = take_front(out, block_faces);
    for (std::size_t f = 0; f < block.size(); ++f) {
      const std::array<std::uint16_t, 3>& c = block_face_[f];
      block[f] = {number[c[0]], number[c[1]], number[c[2]]};
    }
    first += block_faces;
  }
}

/// Within an edge or a face coarse levels come first, so what a coarser mesh has is at its start.
void DyadicGrid::coarse_vertices(
    unsigned level, FunctionRef<void(std::uint64_t first, std::uint64_t count)> run) const {
  run(0, base_vertices_);
  const std::uint64_t on_edge = (std::uint64_t{1} << level) - 1;
  for (std::uint64_t e = 0; e < edge_of_.size() && on_edge > 0; ++e) {
    run(base_vertices_ + e * (n_ - 1), on_edge);
  }
  const std::uint64_t inside = inner_points(level);
  for (std::uint64_t f = 0; f < base_.size() && inside > 0; ++f) {
    run(first_inner_point() + f * inner_points(level_), inside);
  }
}

map::TaggedPoint DyadicGrid::corner_sample(std::uint64_t vertex) const {
  const Corner& corner = corner_of_[static_cast<std::size_t>(vertex)];
  if (corner.face == kNoIndex) {
    throw CorruptionError("base vertex " + std::to_string(vertex) + " has no face");
  }
  return {vertex, {corner.face, corner.number == 1 ? 1.0 : 0.0, corner.number == 2 ? 1.0 : 0.0}};
}

/// Along each edge in the direction of the first face that has it.
map::TaggedPoint DyadicGrid::edge_sample(std::uint64_t index) const {
  const auto [face, k] = edge_of_[static_cast<std::size_t>(index / (n_ - 1))];
  const auto m = static_cast<std::uint32_t>(index % (n_ - 1)) + 1;
  const std::uint64_t number = edge_point(use_[face][k], m);
  const double t = double(m) / n_;
  if (k == 0) return {number, {face, t, 0}};
  if (k == 1) return {number, {face, 1 - t, t}};
  return {number, {face, 0, 1 - t}};
}

/// From a point of a face at most to the last one.
void DyadicGrid::inner_samples(std::uint64_t index, std::span<map::TaggedPoint> out) const {
  const std::uint64_t each = inner_points(level_);
  const auto face = static_cast<std::uint32_t>(index / each);
  const std::uint64_t before = first_inner_point() + face * each;
  const double scale = 1.0 / n_;
  std::uint64_t skip = index % each;
  for (std::uint32_t low_j = 0; !out.empty(); low_j += kSampleBlock) {
    const std::uint32_t first_j = std::max(low_j, 1u);
    const std::uint32_t end_j = std::min(low_j + kSampleBlock, n_ - 1);
    // Row j has n - 1 - j inner points.
    const std::uint64_t in_rows =
        std::uint64_t{end_j - first_j} * (2 * n_ - 1 - first_j - end_j) / 2;
    if (skip >= in_rows) {
      skip -= in_rows;
      continue;
    }
    for (std::uint32_t low_i = 0; low_i + first_j < n_ && !out.empty(); low_i += kSampleBlock) {
      for (std::uint32_t j = first_j; j < end_j; ++j) {
        std::uint32_t i = std::max(low_i, 1u);
        const std::uint32_t end_i = std::min(low_i + kSampleBlock, n_ - j);
        if (i >= end_i) break;
        if (skip >= end_i - i) {
          skip -= end_i - i;
          continue;
        }
        i += static_cast<std::uint32_t>(std::exchange(skip, 0));
        for (map::TaggedPoint& point : take_front(out, end_i - i)) {
          point = {before + inner_point(i, j), {face, i * scale, j * scale}};
          ++i;
        }
      }
    }
  }
}

void DyadicGrid::samples(std::uint64_t first, std::span<map::TaggedPoint> out) const {
  for (; first < base_vertices_ && !out.empty(); ++first) {
    take_front(out, 1)[0] = corner_sample(first);
  }
  for (; first < first_inner_point() && !out.empty(); ++first) {
    take_front(out, 1)[0] = edge_sample(first - base_vertices_);
  }
  while (!out.empty()) {
    const std::uint64_t index = first - first_inner_point();
    const std::uint64_t each = inner_points(level_);
    const std::span<map::TaggedPoint> part = take_front(out, each - index % each);
    inner_samples(index, part);
    first += part.size();
  }
}

}  // namespace remaps::resample
