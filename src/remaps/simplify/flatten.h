#pragma once

#include <array>
#include <span>

#include "remaps/base/geometry.h"
#include "remaps/mesh/retriangulation.h"

namespace remaps::simplify {

/// The 1-ring of a vertex in the plane, on the integer grid, the vertex at the origin.
struct FlatStar {
  unsigned wedges = 0;
  bool boundary = false;
  std::array<GridPoint, kMaxRing> ring{};

  unsigned ring_size() const { return wedges + (boundary ? 1u : 0u); }
};

/// Shape of a planar triangle: twice its area over its longest squared edge; 0.87 for equilateral,
/// 0 for degenerate. Negative or 0 when it is not counter-clockwise.
double planar_shape(GridPoint a, GridPoint b, GridPoint c);

/// Flattens a star by the discrete conformal map z^a, a = 2 pi / (sum of angles), pi / (sum of
/// angles) at a boundary; radii are divided by their geometric mean before the power, then the ring
/// is scaled to the grid and rounded.
///
/// @param offsets  (n) ring positions relative to the vertex, counter-clockwise; n = wedges, + 1 at
/// a boundary
/// @param floor    least planar_shape of every wedge
/// @return  false when a wedge misses the floor after rounding, or a length is zero or not finite
/// Source: [MAPS98] section 3.1; Floater's shape-preserving weights and others give the same star
/// to first order.
bool flatten_star(std::span<const Vec3> offsets, bool boundary, double floor, FlatStar& out);

/// True when every triangle of the fan about ring[apex] has at least the shape `floor`.
bool fan_is_valid(const FlatStar& star, unsigned apex, double floor);

}  // namespace remaps::simplify
