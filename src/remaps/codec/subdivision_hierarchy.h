#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"

namespace remaps::codec {

using Face = std::array<std::uint32_t, 3>;

/// An edge of a face: from one corner to the next. Or none.
class Side {
 public:
  Side() = default;
  Side(std::uint32_t face, std::uint32_t corner) : packed_(face << 2 | corner) {}

  std::uint32_t face() const { return packed_ >> 2; }
  std::uint32_t corner() const { return packed_ & 3; }
  bool none() const { return packed_ == kNoIndex; }
  Side next() const { return {face(), next_corner(corner())}; }
  Side previous() const { return {face(), previous_corner(corner())}; }
  friend bool operator==(const Side&, const Side&) = default;

  static std::uint32_t next_corner(std::uint32_t k) { return k == 2 ? 0 : k + 1; }
  static std::uint32_t previous_corner(std::uint32_t k) { return k == 0 ? 2 : k - 1; }

 private:
  std::uint32_t packed_ = kNoIndex;
};

/// The connectivity of one level.
///
/// Faces 4 f ... 4 f + 3 of the next level are the children of face f: children 0, 1, 2 at its
/// corners, child 3 in the middle with corner k opposite to corner k of child k... in the numbering
/// of docs/formats/semi-regular.md. Edge e has a vertex of the next level, number vertices + e; its
/// halves are edges 2 e and 2 e + 1 there, and the inner edge of face f that is parallel to its
/// edge k is 2 edges + 3 f + k.
struct SubdivisionLevel {
  std::uint32_t vertices = 0;
  std::vector<Face> vertex;               ///< (faces) corners, counter-clockwise
  std::vector<std::array<Side, 3>> twin;  ///< (faces) the other side of each edge, or none
  std::vector<Face> edge;                 ///< (faces) edge k runs from corner k to corner k + 1
  /// (edges) One of the sides of each: at level 0 that of the lower face; of a half that along its
  /// parent's; of an inner edge that of the middle child.
  std::vector<Side> side;

  std::uint32_t faces() const { return static_cast<std::uint32_t>(vertex.size()); }
  std::uint32_t edges() const { return static_cast<std::uint32_t>(side.size()); }

  std::uint32_t from(Side s) const { return vertex[s.face()][s.corner()]; }
  std::uint32_t to(Side s) const { return vertex[s.face()][Side::next_corner(s.corner())]; }
  std::uint32_t opposite(Side s) const {
    return vertex[s.face()][Side::previous_corner(s.corner())];
  }
  Side twin_of(Side s) const { return twin[s.face()][s.corner()]; }
};

/// A base mesh and what it becomes by 1-to-4 subdivision, level by level. Vertices keep their
/// numbers: those of level j are the first of level j + 1, whose further ones lie on the edges of
/// level j, in their order. So a number says all about the place of a vertex.
class SubdivisionHierarchy {
 public:
  /// @param base_vertices  their number
  /// @param base           (f) an oriented manifold, with or without boundary: at most one face at
  ///                       each directed edge, one fan of faces at each vertex
  /// @param levels         number of subdivisions, 0 to kMostLevels
  /// @throws GeometryError  base is not of that kind, or the finest level has 2^31 vertices or more
  /// @throws BudgetError    it does not fit
  SubdivisionHierarchy(std::uint32_t base_vertices, std::span<const Face> base, unsigned levels,
                       MemoryBudget& budget);

  static constexpr unsigned kMostLevels = 14;
  /// What the connectivity takes for a face of the finest level.
  static constexpr std::uint64_t kBytesPerFace = 15;

  unsigned levels() const { return static_cast<unsigned>(level_.size()); }
  /// Vertices of a level, from 0 to levels().
  std::uint32_t vertices(unsigned level) const {
    return level == levels() ? finest_vertices_ : level_[level].vertices;
  }
  std::uint32_t vertices() const { return finest_vertices_; }
  std::uint64_t faces() const { return std::uint64_t{base_.size()} << (2 * levels()); }
  /// Below levels(): the faces of the finest level are arithmetic.
  const SubdivisionLevel& level(unsigned level) const { return level_[level]; }
  std::span<const Face> base() const { return base_; }

  /// Number of edges, and boundary edges, at a base vertex. All others have 6 or, on the boundary,
  /// 4 and 2.
  std::uint32_t valence(std::uint32_t base_vertex) const { return valence_[base_vertex]; }
  /// Whether a vertex of any level lies on the boundary.
  bool on_boundary(std::uint32_t vertex) const {
    return !boundary_.empty() && boundary_[vertex] != 0;
  }

  /// A face of the finest level.
  Face finest_face(std::uint64_t number) const;

 private:
  void build_base(SubdivisionLevel& level, std::uint32_t vertices);
  void check_fans(const SubdivisionLevel& level) const;
  void split(const SubdivisionLevel& coarse, SubdivisionLevel& fine);
  void mark_boundary(const SubdivisionLevel& level);

  std::vector<Face> base_;
  std::vector<SubdivisionLevel> level_;
  std::vector<std::uint32_t> valence_;
  std::vector<std::uint8_t> boundary_;  // (vertices) empty if there is none
  std::uint32_t finest_vertices_ = 0;
  Reservation memory_;
};

}  // namespace remaps::codec
