#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/patch.h"

namespace remaps::sphere {

/// A closed surface of genus 0 as a tetrahedron and the vertices that make the surface of it, one
/// after the other.
struct TetrahedronHierarchy {
  std::array<LocalIndex, 4> corner{};  ///< (corner[0], corner[1], corner[2]) is a face
  std::vector<LocalIndex> vertex;      ///< (n - 4) in the order of insertion
  /// (n - 4 + 1) Where the ring of each begins in `ring`: counter-clockwise. Before the insertion
  /// ring[0] is joined to all others of it, so that the hole is in sight of that one.
  std::vector<std::uint32_t> start;
  std::vector<LocalIndex> ring;

  std::span<const LocalIndex> ring_of(std::size_t insertion) const {
    return std::span(ring).subspan(start[insertion], start[insertion + 1] - start[insertion]);
  }
};

/// Simplifies a surface to a tetrahedron, by half-edge collapses, cheapest first, and returns what
/// undoes that. The cost is the quadric error (Garland, Heckbert 1997) and some more for triangles
/// that are long and vertices of large valence, as Praun, Hoppe 2003 (section 3.1) advise: flat
/// parts go first and limbs last.
///
/// @param position  (n) n >= 4
/// @param triangle  (2 n - 4) one closed, oriented, manifold component of genus 0, all vertices
/// used
/// @throws GeometryError  it is none
/// Cost: O(n log n). Memory: about 300 bytes a vertex.
TetrahedronHierarchy simplify_to_tetrahedron(std::span<const Vec3> position,
                                             std::span<const LocalTriangle> triangle,
                                             const Progress& progress);

}  // namespace remaps::sphere
