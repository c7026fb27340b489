#include "remaps/generate/patch_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 62;
constexpr VertexId kUnnumbered = std::numeric_limits<VertexId>::max();

/// The largest r with r * r <= value.
std::uint64_t integer_sqrt(std::uint64_t value) {
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(value)));
  while (root * root > value) --root;
  while ((root + 1) * (root + 1) <= value) ++root;
  return root;
}

std::uint64_t count_edges(std::span<const Triangle> base) {
  std::vector<std::pair<VertexId, VertexId>> edges;
  edges.reserve(3 * base.size());
  for (const Triangle& t : base)
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::minmax(t[k], t[(k + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  return static_cast<std::uint64_t>(std::unique(edges.begin(), edges.end()) - edges.begin());
}

/// Vertices of the divided mesh; n small enough that nothing overflows.
std::uint64_t count_vertices(std::uint64_t vertices, std::uint64_t edges, std::uint64_t faces,
                             std::uint64_t n) {
  return vertices + edges * (n - 1) + faces * ((n - 1) * (n - 2) / 2);
}

std::uint64_t largest_n(std::uint64_t faces) {
  return integer_sqrt(kMaxCount / std::max<std::uint64_t>(faces, 1));
}

}  // namespace

PatchGrid::PatchGrid(std::span<const Triangle> base, std::uint64_t base_vertices, std::uint64_t n)
    : n_(n), blocks_(base.size()) {
  if (base.empty()) throw GeometryError("base mesh has no faces");
  if (n < 1 || n > largest_n(base.size()))
    throw GeometryError("a base face cannot be divided " + std::to_string(n) + " times");
  for (std::size_t f = 0; f < base.size(); ++f) {
    const Triangle& t = base[f];
    if (std::max({t[0], t[1], t[2]}) >= base_vertices)
      throw GeometryError("base face " + std::to_string(f) + " has an index out of range");
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      throw GeometryError("base face " + std::to_string(f) + " has a corner twice");
  }
  find_edge_owners(base);
  number_vertices(base, base_vertices);
}

std::uint64_t PatchGrid::nearest_n(std::span<const Triangle> base, std::uint64_t base_vertices,
                                   std::uint64_t target) {
  const std::uint64_t edges = count_edges(base);
  const auto count = [&](std::uint64_t n) {
    return count_vertices(base_vertices, edges, base.size(), n);
  };
  std::uint64_t low = 1;
  std::uint64_t high = largest_n(base.size());
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (count(middle) < target)
      low = middle + 1;
    else
      high = middle;
  }
  const bool below_is_nearer =
      low > 1 && count(low) > target && target - count(low - 1) <= count(low) - target;
  return below_is_nearer ? low - 1 : low;
}

void PatchGrid::find_edge_owners(std::span<const Triangle> base) {
  std::map<std::pair<VertexId, VertexId>, EdgeOwner> half_edges;
  for (std::size_t f = 0; f < base.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId a = base[f][k];
      const VertexId b = base[f][(k + 1) % 3];
      const EdgeOwner self{f, static_cast<int>(k)};
      if (!half_edges.try_emplace({a, b}, self).second) {
        throw GeometryError("base edge " + std::to_string(a) + "-" + std::to_string(b) +
                            " is not manifold or its faces are not oriented alike");
      }
      const auto opposite = half_edges.find({b, a});
      blocks_[f].owns_edge[k] = opposite == half_edges.end();
      blocks_[f].edge_owner[k] = opposite == half_edges.end() ? self : opposite->second;
    }
  }
}

void PatchGrid::number_vertices(std::span<const Triangle> base, std::uint64_t base_vertices) {
  std::vector<VertexId> numbers(base_vertices, kUnnumbered);
  for (std::size_t f = 0; f < base.size(); ++f) {
    Block& block = blocks_[f];
    block.first = vertices_;
    for (std::size_t k = 0; k < 3; ++k) block.owns_corner[k] = numbers[base[f][k]] == kUnnumbered;
    const std::array<PatchPoint, 3> corners{{{f, 0, 0}, {f, n_, 0}, {f, n_, n_}}};
    for (std::size_t k = 0; k < 3; ++k) {
      if (block.owns_corner[k]) numbers[base[f][k]] = owned_vertex(corners[k]);
      block.corner[k] = numbers[base[f][k]];
    }
    vertices_ += (n_ - 1) * (n_ - 2) / 2;
    for (std::size_t k = 0; k < 3; ++k)
      vertices_ += (block.owns_corner[k] ? 1 : 0) + (block.owns_edge[k] ? n_ - 1 : 0);
  }
  const auto unused = std::find(numbers.begin(), numbers.end(), kUnnumbered);
  if (unused != numbers.end()) {
    throw GeometryError("base vertex " + std::to_string(unused - numbers.begin()) +
                        " belongs to no face");
  }
}

/// Number of the first vertex that block owns in a row >= 1.
VertexId PatchGrid::row_start(const Block& block, std::uint64_t row) const {
  const std::uint64_t sides = (block.owns_edge[0] ? 1u : 0u) + (block.owns_edge[2] ? 1u : 0u);
  const std::uint64_t above = row - 1;
  const std::uint64_t interior = above < 2 ? 0 : above * (above - 1) / 2;
  return block.first + (block.owns_corner[0] ? 1 : 0) + interior + above * sides;
}

/// Number of a vertex at a point of the face that owns it.
VertexId PatchGrid::owned_vertex(const PatchPoint& p) const {
  const Block& block = blocks_[p.face];
  if (p.row == 0) return block.first;
  const VertexId start = row_start(block, p.row);
  if (p.column == 0) return start;
  if (p.row < n_) return start + (block.owns_edge[0] ? 1 : 0) + p.column - 1;
  const VertexId edge_start = start + (block.owns_corner[1] ? 1 : 0);
  if (p.column < n_) return edge_start + p.column - 1;
  return edge_start + (block.owns_edge[1] ? n_ - 1 : 0);
}

PatchPoint PatchGrid::edge_point(std::uint64_t face, int edge, std::uint64_t steps) const {
  if (edge == 0) return {face, steps, 0};
  if (edge == 1) return {face, n_, steps};
  return {face, n_ - steps, n_ - steps};
}

/// Number of the vertex some steps along an edge of a face; 0 < steps < n.
VertexId PatchGrid::edge_vertex(std::uint64_t face, int edge, std::uint64_t steps) const {
  const auto k = static_cast<std::size_t>(edge);
  const Block& block = blocks_[face];
  if (block.owns_edge[k]) return owned_vertex(edge_point(face, edge, steps));
  const EdgeOwner& owner = block.edge_owner[k];
  return owned_vertex(edge_point(owner.face, owner.edge, n_ - steps));
}

VertexId PatchGrid::vertex(const PatchPoint& p) const {
  const Block& block = blocks_[p.face];
  if (p.row == 0) return block.corner[0];
  if (p.row == n_) {
    if (p.column == 0) return block.corner[1];
    if (p.column == n_) return block.corner[2];
    return edge_vertex(p.face, 1, p.column);
  }
  if (p.column == 0) return edge_vertex(p.face, 0, p.row);
  if (p.column == p.row) return edge_vertex(p.face, 2, n_ - p.row);
  return owned_vertex(p);
}

PatchPoint PatchGrid::point(VertexId v) const {
  const auto after = std::upper_bound(blocks_.begin(), blocks_.end(), v,
                                      [](VertexId id, const Block& b) { return id < b.first; });
  const Block& block = *std::prev(after);
  const auto face = static_cast<std::uint64_t>(std::prev(after) - blocks_.begin());
  if (v == block.first && block.owns_corner[0]) return {face, 0, 0};

  // The last row that starts at or before v: the root of a quadratic, made exact by stepping.
  const double sides = (block.owns_edge[0] ? 1 : 0) + (block.owns_edge[2] ? 1 : 0) - 0.5;
  const auto rest = static_cast<double>(v - row_start(block, 1));
  const double root = std::sqrt(sides * sides + 2 * rest) - sides;
  std::uint64_t row = std::clamp<std::uint64_t>(static_cast<std::uint64_t>(root) + 1, 1, n_);
  while (row > 1 && row_start(block, row) > v) --row;
  while (row < n_ && row_start(block, row + 1) <= v) ++row;

  std::uint64_t column = v - row_start(block, row);
  if (row < n_) return {face, row, column + (block.owns_edge[0] ? 0 : 1)};
  if (block.owns_corner[1]) {
    if (column == 0) return {face, row, 0};
    --column;
  }
  return {face, row, block.owns_edge[1] ? column + 1 : n_};
}

GridTriangle PatchGrid::triangle(FaceId f) const {
  const std::uint64_t rest = f % (n_ * n_);
  const std::uint64_t strip = integer_sqrt(rest);
  const std::uint64_t place = rest - strip * strip;
  return {f / (n_ * n_), strip, place / 2, place % 2 == 1};
}

FaceId PatchGrid::face(const GridTriangle& t) const {
  return t.face * n_ * n_ + t.strip * t.strip + 2 * t.column + (t.down ? 1 : 0);
}

}  // namespace remaps
