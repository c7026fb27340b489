#include "remaps/mesh/point_triangle.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace remaps {
namespace {

/// Below this squared sine of the angle at corner 0 the barycentrics of a projection may be
/// rounding noise.
constexpr double kSliverSine2 = 1e-12;

/// Keeps in best the closest point of the edge from corner i to its successor, if that is closer.
void try_edge(const Vec3& p, const TrianglePositions& triangle, std::size_t i,
              TrianglePoint& best) {
  const std::size_t j = i == 2 ? 0 : i + 1;
  const Vec3 edge = triangle[j] - triangle[i];
  const Vec3 to_p = p - triangle[i];
  const double length2 = norm2(edge);
  const double along = dot(edge, to_p);
  const double t = along <= 0 ? 0.0 : along >= length2 ? 1.0 : along / length2;
  // From the nearer end, so that a point at the far end is met exactly.
  const double distance2 = t == 1.0 ? norm2(p - triangle[j]) : norm2(to_p - t * edge);
  if (!(distance2 < best.distance2)) return;
  best.distance2 = distance2;
  best.weights = {};
  best.weights[i] = 1 - t;
  best.weights[j] = t;
}

}  // namespace

TrianglePoint closest_point_on_triangle(const Vec3& p, const TrianglePositions& triangle) {
  const Vec3 ab = triangle[1] - triangle[0];
  const Vec3 ac = triangle[2] - triangle[0];
  const Vec3 ap = p - triangle[0];
  const Vec3 normal = cross(ab, ac);
  const double area2 = norm2(normal);
  const bool sliver = !(area2 > kSliverSine2 * norm2(ab) * norm2(ac));

  // Barycentrics of the projection times area2.
  const double b = dot(normal, cross(ap, ac));
  const double c = dot(normal, cross(ab, ap));
  const double a = area2 - b - c;

  TrianglePoint best{.weights = {}, .distance2 = std::numeric_limits<double>::infinity()};
  if (a >= 0 && b >= 0 && c >= 0 && area2 > 0) {
    const double v = b / area2;
    const double w = c / area2;
    best = {.weights = {std::max(0.0, 1 - v - w), v, w}, .distance2 = norm2(ap - v * ab - w * ac)};
    if (!sliver) return best;
  }
  // Of a convex figure the closest point lies on an edge that p sees. A sliver's signs say nothing:
  // try all.
  if (c < 0 || sliver) try_edge(p, triangle, 0, best);
  if (a < 0 || sliver) try_edge(p, triangle, 1, best);
  if (b < 0 || sliver) try_edge(p, triangle, 2, best);
  return best;
}

double box_distance2(const Vec3& p, const Box3& box) {
  const auto outside = [](double low, double x, double high) {
    return std::max({low - x, x - high, 0.0});
  };
  return norm2({outside(box.low.x, p.x, box.high.x), outside(box.low.y, p.y, box.high.y),
                outside(box.low.z, p.z, box.high.z)});
}

}  // namespace remaps
