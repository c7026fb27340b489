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

/// Below this squared sine of the angle at corner 0 the differences of products in
/// triangle_distance2 lose too many digits.
constexpr double kNarrowSine2 = 1e-2;

/// Squared length of v less its part along an edge, but no more than the edge; both from one
/// corner.
double edge_distance2(const Vec3& v, const Vec3& edge, double along, double length2) {
  const double t = std::clamp(along / length2, 0.0, 1.0);
  return norm2(v - t * edge);
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

double triangle_distance2(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const double bb = norm2(ab), cc = norm2(ac), bc = dot(ab, ac);
  const double area2 = bb * cc - bc * bc;
  if (!(area2 > kNarrowSine2 * bb * cc)) {
    return closest_point_on_triangle(p, {a, b, c}).distance2;
  }
  const double pb = dot(ap, ab), pc = dot(ap, ac);
  // Barycentrics of the projection times area2.
  const double v = cc * pb - bc * pc;
  const double w = bb * pc - bc * pb;
  const double u = area2 - v - w;
  if (u >= 0 && v >= 0 && w >= 0) {
    return norm2(ap - (v / area2) * ab - (w / area2) * ac);
  }
  double least = std::numeric_limits<double>::infinity();
  if (w < 0) least = edge_distance2(ap, ab, pb, bb);
  if (v < 0) least = std::min(least, edge_distance2(ap, ac, pc, cc));
  if (u < 0) {
    const Vec3 edge = c - b;
    const Vec3 bp = p - b;
    least = std::min(least, edge_distance2(bp, edge, dot(bp, edge), norm2(edge)));
  }
  return least;
}

double box_distance2(const Vec3& p, const Box3& box) {
  const auto outside = [](double low, double x, double high) {
    return std::max({low - x, x - high, 0.0});
  };
  return norm2({outside(box.low.x, p.x, box.high.x), outside(box.low.y, p.y, box.high.y),
                outside(box.low.z, p.z, box.high.z)});
}

}  // namespace remaps
