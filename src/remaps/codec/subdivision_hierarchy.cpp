#include "remaps/codec/subdivision_hierarchy.h"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>

namespace remaps::codec {
namespace {

constexpr std::uint64_t kMostVertices = std::uint64_t{1} << 31;

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{a} << 32 | b;
}

void check_corners(const Face& face, std::size_t number, std::uint32_t vertices) {
  const auto [a, b, c] = face;
  if (a >= vertices || b >= vertices || c >= vertices || a == b || b == c || c == a) {
    throw GeometryError("base face " + std::to_string(number) +
                        " does not have three different corners among the " +
                        std::to_string(vertices) + " base vertices");
  }
}

}  // namespace

SubdivisionHierarchy::SubdivisionHierarchy(std::uint32_t base_vertices, std::span<const Face> base,
                                           unsigned levels, MemoryBudget& budget)
    : base_(base.begin(), base.end()), level_(levels), finest_vertices_(base_vertices) {
  if (levels > kMostLevels || (std::uint64_t{base.size()} << (2 * levels)) >= kMostVertices / 2) {
    throw GeometryError(std::to_string(base.size()) + " base faces at level " +
                        std::to_string(levels) + " are more than the codec can number");
  }
  memory_ = budget.reserve(faces() * kBytesPerFace, "the connectivity of all levels");
  SubdivisionLevel zero;
  SubdivisionLevel& first = levels > 0 ? level_[0] : zero;
  build_base(first, base_vertices);
  for (unsigned j = 0; j < levels; ++j) {
    if (j + 1 < levels) split(level_[j], level_[j + 1]);
    finest_vertices_ = level_[j].vertices + level_[j].edges();
  }
  mark_boundary(first);
  for (unsigned j = 1; j < levels && !boundary_.empty(); ++j) mark_boundary(level_[j]);
}

void SubdivisionHierarchy::build_base(SubdivisionLevel& level, std::uint32_t vertices) {
  level.vertices = vertices;
  level.vertex = base_;
  level.twin.resize(base_.size());
  level.edge.resize(base_.size());
  valence_.assign(vertices, 0);
  std::unordered_map<std::uint64_t, Side> side_of;
  side_of.reserve(3 * base_.size());
  for (std::uint32_t f = 0; f < level.faces(); ++f) {
    check_corners(base_[f], f, vertices);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Side s(f, k);
      if (!side_of.emplace(edge_key(level.from(s), level.to(s)), s).second) {
        throw GeometryError("base face " + std::to_string(f) + " has the edge from vertex " +
                            std::to_string(level.from(s)) + " to " + std::to_string(level.to(s)) +
                            " in common with another of the same direction");
      }
    }
  }
  for (std::uint32_t f = 0; f < level.faces(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Side s(f, k);
      const auto twin = side_of.find(edge_key(level.to(s), level.from(s)));
      const bool boundary = twin == side_of.end();
      if (!boundary) level.twin[f][k] = twin->second;
      if (boundary || twin->second.face() > f) {
        level.edge[f][k] = level.edges();
        level.side.push_back(s);
        ++valence_[level.from(s)];
        ++valence_[level.to(s)];
      } else {
        level.edge[f][k] = level.edge[twin->second.face()][twin->second.corner()];
      }
    }
  }
  check_fans(level);
}

void SubdivisionHierarchy::check_fans(const SubdivisionLevel& level) const {
  // A walk around a vertex from any of its faces meets all of its edges, or there are two fans.
  std::vector<std::uint8_t> walked(level.vertices, 0);
  for (std::uint32_t f = 0; f < level.faces(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = level.vertex[f][k];
      if (std::exchange(walked[v], std::uint8_t{1}) != 0) continue;
      std::uint32_t edges = 1;
      const Side first(f, k);
      Side s = first.previous();
      for (; !level.twin_of(s).none() && level.twin_of(s) != first; ++edges) {
        s = level.twin_of(s).previous();
      }
      if (level.twin_of(s).none()) {
        ++edges;
        for (s = first; !level.twin_of(s).none(); ++edges) s = level.twin_of(s).next();
      }
      if (edges != valence_[v]) {
        throw GeometryError("the faces at base vertex " + std::to_string(v) +
                            " are not one fan or disc");
      }
    }
  }
  const auto lonely = std::find(walked.begin(), walked.end(), 0);
  if (lonely != walked.end()) {
    throw GeometryError("base vertex " + std::to_string(lonely - walked.begin()) + " has no face");
  }
}

void SubdivisionHierarchy::split(const SubdivisionLevel& coarse, SubdivisionLevel& fine) {
  const std::uint32_t faces = coarse.faces(), edges = coarse.edges();
  fine.vertices = coarse.vertices + edges;
  fine.vertex.resize(4 * std::size_t{faces});
  fine.twin.resize(fine.vertex.size());
  fine.edge.resize(fine.vertex.size());
  fine.side.resize(2 * std::size_t{edges} + 3 * std::size_t{faces});
  for (std::uint32_t f = 0; f < faces; ++f) {
    const Face& v = coarse.vertex[f];
    Face middle;
    for (std::uint32_t k = 0; k < 3; ++k) middle[k] = coarse.vertices + coarse.edge[f][k];
    const std::uint32_t child = 4 * f;
    fine.vertex[child] = {v[0], middle[0], middle[2]};
    fine.vertex[child + 1] = {middle[0], v[1], middle[1]};
    fine.vertex[child + 2] = {middle[2], middle[1], v[2]};
    fine.vertex[child + 3] = {middle[1], middle[2], middle[0]};
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t after = Side::next_corner(k), e = coarse.edge[f][k];
      // The inner edge parallel to edge k cuts off corner k + 2, where it is side k + 1... of that
      // child: sides 1, 2, 0 of children 0, 1, 2.
      const std::uint32_t cut = Side::previous_corner(k), cut_side = Side::next_corner(cut);
      const Side inner(child + cut, cut_side), middle_side(child + 3, k);
      const std::uint32_t inner_edge = 2 * edges + 3 * f + k;
      fine.twin[child + cut][cut_side] = middle_side;
      fine.twin[child + 3][k] = inner;
      fine.edge[child + cut][cut_side] = fine.edge[child + 3][k] = inner_edge;
      fine.side[inner_edge] = middle_side;
      // The halves of edge k: side k of children k and k + 1.
      const Side first(child + k, k), second(child + after, k);
      const Side across = coarse.twin[f][k];
      if (!across.none()) {
        const std::uint32_t there = 4 * across.face(), l = across.corner();
        fine.twin[child + k][k] = {there + Side::next_corner(l), l};
        fine.twin[child + after][k] = {there + l, l};
      }
      const bool own = coarse.side[e] == Side(f, k);
      fine.edge[child + k][k] = own ? 2 * e : 2 * e + 1;
      fine.edge[child + after][k] = own ? 2 * e + 1 : 2 * e;
      if (own) {
        fine.side[2 * e] = first;
        fine.side[2 * e + 1] = second;
      }
    }
  }
}

void SubdivisionHierarchy::mark_boundary(const SubdivisionLevel& level) {
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const Side side = level.side[e];
    if (!level.twin_of(side).none()) continue;
    if (boundary_.empty()) boundary_.assign(finest_vertices_, 0);
    boundary_[level.from(side)] = 1;
    boundary_[level.to(side)] = 1;
    if (levels() > 0) boundary_[level.vertices + e] = 1;
  }
}

Face SubdivisionHierarchy::finest_face(std::uint64_t number) const {
  if (levels() == 0) return base_[number];
  const SubdivisionLevel& level = level_.back();
  const auto f = static_cast<std::uint32_t>(number >> 2);
  const Face &v = level.vertex[f], &e = level.edge[f];
  const std::uint32_t first = level.vertices;
  switch (number & 3) {
    case 0:
      return {v[0], first + e[0], first + e[2]};
    case 1:
      return {first + e[0], v[1], first + e[1]};
    case 2:
      return {first + e[2], first + e[1], v[2]};
    default:
      return {first + e[1], first + e[2], first + e[0]};
  }
}

}  // namespace remaps::codec
