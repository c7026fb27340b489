#pragma once

#include <array>
#include <span>

#include "remaps/base/geometry.h"
#include "remaps/base/simd.h"
#include "remaps/mesh/retriangulation.h"

namespace remaps::simplify {

/// Coordinates of a ring's points, four at a time: room for a whole number of blocks of 4, and one
/// more block, so that a point and the one after it can be loaded anywhere.
using RingFloats = std::array<float, kMaxRing + 1 + kLanes>;

/// Positions of a ring relative to its vertex, counter-clockwise. After the last comes the first
/// again, and so on to the end of the block after the last (`close`).
struct RingOffsets {
  unsigned size = 0;
  alignas(16) RingFloats x, y, z;

  void close() {
    const unsigned end = (size + kLanes) / kLanes * kLanes + 1;
    for (unsigned i = size; i < end; ++i) {
      x[i] = x[i - size];
      y[i] = y[i - size];
      z[i] = z[i - size];
    }
  }
  Vec3 operator[](unsigned i) const { return {x[i], y[i], z[i]}; }
};

/// The 1-ring of a vertex in the plane, on the integer grid, the vertex at the origin.
struct FlatStar {
  unsigned wedges = 0;
  bool boundary = false;
  std::array<GridPoint, kMaxRing> ring{};

  unsigned ring_size() const { return wedges + (boundary ? 1u : 0u); }
};

/// A feature that runs through a vertex, from one ring point to another: their places in the ring.
struct Crease {
  unsigned from = kMaxRing;  ///< kMaxRing: there is none
  unsigned to = kMaxRing;

  bool exists() const { return from != kMaxRing; }
};

/// Shape of a planar triangle: twice its area over its longest squared edge; 0.87 for equilateral,
/// 0 for degenerate. Negative or 0 when it is not counter-clockwise.
double planar_shape(GridPoint a, GridPoint b, GridPoint c);

/// Flattens a star by the discrete conformal map z^a, a = 2 pi / (sum of angles), pi / (sum of
/// angles) at a boundary; radii are divided by their geometric mean before the power, then the ring
/// is scaled to the grid and rounded. The ring is computed in floats: what is decided afterwards is
/// decided on the rounded points.
///
/// With a crease its two sides get half a turn each: its two ring points lie on the x axis, on
/// different sides of the origin, exactly.
///
/// @param ring   closed; n = wedges points, + 1 at a boundary
/// @param floor  least planar_shape of every wedge; at least 1e-6
/// @return  false when a wedge misses the floor after rounding, or a length is zero or not finite
/// Source: [MAPS98] section 3.1; Floater's shape-preserving weights and others give the same star
/// to first order.
bool flatten_star(const RingOffsets& ring, bool boundary, double floor, FlatStar& out,
                  const Crease& crease = {});
/// The same for offsets of any unit.
bool flatten_star(std::span<const Vec3> offsets, bool boundary, double floor, FlatStar& out,
                  const Crease& crease = {});

/// True when every triangle of the fan about ring[apex] has at least the shape `floor`.
bool fan_is_valid(const FlatStar& star, unsigned apex, double floor);

}  // namespace remaps::simplify
