#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/patch.h"
#include "remaps/sphere/sphere_point.h"

namespace remaps::sphere {

struct SphericalOptions {
  double growth = 1.2;    ///< between sweeps over all vertices the number of these grows by that
  unsigned sweeps = 100;  ///< each of these times, at most
  unsigned last_sweeps = 500;  ///< when all are there, at most
  double least_gain = 1e-5;    ///< of the energy: a sweep that gains less is the last
  /// Of the mean area of a triangle, added to each: keeps those without area in shape.
  double regularization = 0.01;
};

/// Maps a closed surface of genus 0 to the unit sphere, one to one: each triangle becomes a
/// spherical one, and all of them turn counter-clockwise, by a test in integers. Coarse to fine,
/// from a tetrahedron on: a vertex is inserted in sight of all of its ring, and it and the ring are
/// moved to where the surface is stretched least.
///
/// @param position  (n) n >= 4
/// @param triangle  (2 n - 4) one closed, oriented, manifold component of genus 0, all vertices
/// used
/// @return          (n) where the vertices are on the sphere
/// @throws GeometryError  it is none, or has parts so thin that the grid of the sphere is too
/// coarse
///                        for them
/// Cost: O(n log n), about 20 s CPU for 10^5. Memory: about 600 bytes a vertex, reserved.
/// Deterministic.
/// Source: Praun, Hoppe, Spherical Parametrization and Remeshing (SIGGRAPH 2003), section 3.
/// Differs: vertices are removed by half-edge collapses, whose holes are always in sight of one of
/// their corners, so that insertion cannot fail; Newton's method instead of random line searches,
/// with the flat triangle's area replaced by the volume below it, which makes the energy a sum of
/// quotients of linear functions that has its barrier where a triangle turns over.
std::vector<SpherePoint> parameterize_sphere(std::span<const Vec3> position,
                                             std::span<const LocalTriangle> triangle,
                                             const SphericalOptions& options, MemoryBudget& budget,
                                             Progress& progress);

}  // namespace remaps::sphere
