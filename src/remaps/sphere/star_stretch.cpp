#include "remaps/sphere/star_stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "remaps/sphere/sphere_point.h"

namespace remaps::sphere {
namespace {

/// Rounding moves each corner by less than a grid unit, and so a triangle's D by less than this
/// times its edges.
constexpr double kMargin = 4 / kSphereGrid;
constexpr double kEnough = 1e-4;    // of the decrease that the slope promises
constexpr unsigned kHalvings = 12;  // of a step

Vec3 normalized(const Vec3& a) {
  return 1 / norm(a) * a;
}

}  // namespace

void StarStretch::set_surface(const Vec3& centre, std::span<const Vec3> ring, double area) {
  const double added = 4 / std::sqrt(3.0) * area;  // squared edge of the equilateral one
  triangle_.resize(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec3 p = ring[i] - centre, q = ring[i + 1 == ring.size() ? 0 : i + 1] - centre;
    triangle_[i] = {0.5 * norm(cross(p, q)) + area, norm2(q - p) + added, norm2(p) + added,
                    norm2(q) + added};
  }
}

bool StarStretch::is_oriented(const Vec3& x) const {
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    const Vec3 p = ring_[i] - x, q = ring_[after(i)] - x;
    const double least = kMargin * (std::sqrt(norm2(p) + norm2(q)) + kMargin);
    if (!(dot(x, cross(p, q)) > least)) return false;
  }
  return true;
}

double StarStretch::energy(const Vec3& x) const {
  double sum = 0;
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    const Vec3 p = ring_[i] - x, q = ring_[after(i)] - x;
    const Triangle& t = triangle_[i];
    const double ep = norm2(q), eq = norm2(p), ev = norm2(p - q);
    const double d = dot(x, cross(p, q));
    if (!(d > 0)) return std::numeric_limits<double>::infinity();
    const double n =
        t.across * (ep + eq - ev) + t.to_second * (ev + eq - ep) + t.to_first * (ev + ep - eq);
    sum += t.area * n / (d * d);
  }
  return 0.25 * sum;
}

/// Energy, and its derivatives along unit tangents u and v of the sphere at x.
StarStretch::Slopes StarStretch::slopes(const Vec3& x, const Vec3& u, const Vec3& v) const {
  Slopes s;
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    const Triangle& t = triangle_[i];
    const Vec3 p = ring_[i] - x, q = ring_[after(i)] - x;
    // Squared edges of the spherical triangle, by the opposite corner; D, and its gradient.
    const double ep = norm2(q), eq = norm2(p), ev = norm2(p - q);
    const Vec3 pq = cross(p, q);
    const Vec3 dn = cross(x, q - p) + pq;
    const double d = dot(x, pq);
    if (!(d > 0)) {
      s.energy = std::numeric_limits<double>::infinity();
      return s;
    }
    // N is linear in ep and eq: weights of q's and p's edge. The surface edge opposite to p is the
    // one from the vertex to q.
    const double wq = t.across - t.to_second + t.to_first;
    const double wp = t.across + t.to_second - t.to_first;
    const double n = wq * ep + wp * eq + (t.to_first + t.to_second - t.across) * ev;
    const Vec3 dN = -2 * wq * q - 2 * wp * p;
    const double radial = dot(x, dN);
    const double f = 0.25 * t.area / (d * d);
    const double nu = dot(dN, u), nv = dot(dN, v), du = dot(dn, u) / d, dv = dot(dn, v) / d;
    s.energy += f * n;
    s.gu += f * (nu - 2 * n * du);
    s.gv += f * (nv - 2 * n * dv);
    // The Hessian of N, 2 (wp + wq), and what the sphere's curvature takes: the radial slope.
    const double straight = 2 * (wp + wq) - (radial - 2 * n);
    s.huu += f * (straight - 4 * nu * du + 6 * n * du * du);
    s.hvv += f * (straight - 4 * nv * dv + 6 * n * dv * dv);
    s.huv += f * (-2 * (nu * dv + nv * du) + 6 * n * du * dv);
  }
  return s;
}

Vec3 StarStretch::improve(const Vec3& start, unsigned steps) const {
  Vec3 x = start;
  for (unsigned k = 0; k < steps; ++k) {
    const Vec3 axis = std::fabs(x.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 u = normalized(cross(x, axis)), v = cross(x, u);
    const Slopes s = slopes(x, u, v);
    if (!std::isfinite(s.energy)) return x;
    // Newton's direction, with the Hessian's eigenvalues made positive.
    const double mean = 0.5 * (s.huu + s.hvv), spread = std::hypot(0.5 * (s.huu - s.hvv), s.huv);
    const double shift = mean - spread > 1e-3 * (std::fabs(mean) + spread)
                             ? 0
                             : spread - mean + 1e-3 * (std::fabs(mean) + spread);
    const double a = s.huu + shift, b = s.huv, c = s.hvv + shift, det = a * c - b * b;
    if (!(det > 0)) return x;
    double tu = (b * s.gv - c * s.gu) / det, tv = (b * s.gu - a * s.gv) / det;
    const double slope = tu * s.gu + tv * s.gv;
    if (!(slope < -1e-9 * s.energy)) return x;
    // No farther than the nearest neighbour is.
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& r : ring_) nearest = std::min(nearest, norm2(r - x));
    const double length = std::hypot(tu, tv), most = std::sqrt(nearest);
    if (length > most) {
      tu *= most / length;
      tv *= most / length;
    }
    double part = 1;
    unsigned halvings = 0;
    Vec3 next = x;
    for (; halvings < kHalvings; ++halvings, part *= 0.5) {
      next = normalized(x + part * tu * u + part * tv * v);
      if (is_oriented(next) && energy(next) <= s.energy + kEnough * part * slope) break;
    }
    if (halvings == kHalvings) return x;
    x = next;
  }
  return x;
}

}  // namespace remaps::sphere
