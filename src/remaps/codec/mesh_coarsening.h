#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/codec/subdivision_hierarchy.h"

namespace remaps::codec {

/// Faces and who is beside whom. Sides are joined by `twin` alone, so that a mesh in which two
/// edges have the same ends can be held too.
struct JoinedFaces {
  std::uint32_t vertices = 0;
  std::vector<Face> vertex;               ///< (faces) corners, counter-clockwise
  std::vector<std::array<Side, 3>> twin;  ///< (faces) the other side of each edge, or none

  std::uint32_t faces() const { return static_cast<std::uint32_t>(vertex.size()); }
  std::uint32_t from(Side s) const { return vertex[s.face()][s.corner()]; }
  std::uint32_t to(Side s) const { return vertex[s.face()][Side::next_corner(s.corner())]; }
  Side twin_of(Side s) const { return twin[s.face()][s.corner()]; }
};

/// Two sides that cannot be the two of an edge though they have the same ends.
using SideClash = std::pair<Side, Side>;

/// Joins the sides with the same ends.
///
/// @param faces  (f) corners below `vertices`, three different ones each
/// @param twin   (f) what is found
/// @return       the first clash: more than two sides, or two of the same direction
/// Cost: linear, by counting; 28 bytes a face and 4 a vertex on the way.
std::optional<SideClash> join_sides(std::uint32_t vertices, std::span<const Face> faces,
                                    std::vector<std::array<Side, 3>>& twin);

/// The four faces that a coarse face was split into: at 0, 1, 2 the child at that corner, with the
/// corner of the child that is the coarse one; at 3 the middle child, with the corner of it that is
/// opposite to coarse corner 0.
using Children = std::array<Side, 4>;

struct Coarsening {
  std::vector<Children> child;  ///< (coarse faces)
  JoinedFaces coarse;
};

/// Undoes one 1-to-4 split of a connected mesh, supposing the part of face 0 in it.
///
/// Coarse faces are in the order of their first child, which is the one at corner 0, or the middle
/// one with its corner 0 opposite to corner 0. Coarse vertices are in the order in which the coarse
/// faces have them.
///
/// @param part  0, 1, 2: face 0 is a child at a corner, which is its own corner 0, 1, 2; 3: it is
///              in the middle
/// @return      nothing if that fits not everywhere
/// Cost: linear.
std::optional<Coarsening> coarsen(const JoinedFaces& fine, unsigned part);

/// Whether joining sides with the same ends gives the same mesh: no loops, no double edges.
bool is_simple(const JoinedFaces& mesh);

}  // namespace remaps::codec
