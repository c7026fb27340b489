#pragma once

#include <array>
#include <span>

#include "remaps/mesh/patch.h"
#include "remaps/mesh/segment.h"
#include "remaps/simplify/flatten.h"

/// The prediction of the sampling error that decides the order of removal.
///
/// Every base face gets the same number of samples. With rho the input area per unit of parameter
/// (one unit a triangle of the current mesh) and kappa^2 the squared curvature of the input, a
/// triangle carries the load S = integral of kappa^2 rho^2 dA over what is mapped onto it
/// (length^4). At the start S = kappa^2 A^3. The cost of a removal is the growth of the sum of S.
/// See docs/design/removal-order.md.
namespace remaps::simplify {

/// Sets quadric (own vertices) and load (all faces) of a first-level segment from its triangles.
/// Features that the patch has are like boundaries: the surface is curved along them, not across.
///
/// @param diagonal  of the input's bounding box; a curvature below 1 / diagonal counts as that
void initialize_loads(const Patch& patch, double diagonal, Segment& segment);

/// The loads of the fan about ring[apex], given the loads of the star's wedges: the part of wedge i
/// that falls on new triangle j takes along load_i * share * (planar area of j / planar area of
/// i)^2.
///
/// @param wedge_load  (wedges)
/// @param fan_load    (ring_size - 2) result
/// @return  sum of fan_load
double carry_loads(const FlatStar& star, unsigned apex, std::span<const float> wedge_load,
                   std::span<double> fan_load);

}  // namespace remaps::simplify
