#pragma once

#include <array>

#include "remaps/base/geometry.h"

namespace remaps {

/// The point of a triangle that is closest to some point.
struct TrianglePoint {
  std::array<double, 3> weights{};  // barycentric: none negative, sum 1 within rounding
  double distance2 = 0;             // squared distance to it
};

/// Finds the point of a triangle closest to p, in double.
///
/// `distance2` is measured to the point that `weights` name, so it is never less than the true
/// squared distance, beyond rounding. Holds for triangles of any shape, also those that are a
/// segment or a point.
TrianglePoint closest_point_on_triangle(const Vec3& p, const TrianglePositions& triangle);

/// Squared distance from p to a triangle, for four fifths of the time of closest_point_on_triangle.
/// The distance is the same within 1e-13 of the size of triangle and p.
double triangle_distance2(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Squared distance from p to a box that is not empty; 0 inside.
double box_distance2(const Vec3& p, const Box3& box);

}  // namespace remaps
