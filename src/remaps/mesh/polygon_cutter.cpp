#include "remaps/mesh/polygon_cutter.h"

#include <algorithm>
#include <cmath>

namespace remaps {
namespace {

int sign_between(double a, double b) {
  return int{a > b} - int{a < b};
}

/// The sign of a * b - c * d. Rounding keeps order, so only equal products need their errors.
int sign_of_determinant(double a, double b, double c, double d) {
  const double ab = a * b;
  const double cd = c * d;
  if (ab != cd) return sign_between(ab, cd);
  return sign_between(std::fma(a, b, -ab), std::fma(c, d, -cd));
}

/// Twice the area, as a vector [Newell].
Vec3 area_vector(std::span<const Vec3> corner) {
  Vec3 sum;
  for (std::size_t i = 2; i < corner.size(); ++i)
    sum = sum + cross(corner[i - 1] - corner[0], corner[i] - corner[0]);
  return sum;
}

}  // namespace

/// False if the polygon has no normal.
bool PolygonTriangulation::project(std::span<const Vec3> corner) {
  const Vec3 normal = area_vector(corner);
  const double x = std::fabs(normal.x);
  const double y = std::fabs(normal.y);
  const double z = std::fabs(normal.z);
  point_.clear();
  for (const Vec3& p : corner) {
    // The two other axes, in the order that makes the polygon turn left.
    Point q{p.x, p.y};
    double along = normal.z;
    if (x >= y && x >= z) {
      q = {p.y, p.z};
      along = normal.x;
    } else if (y >= z) {
      q = {p.z, p.x};
      along = normal.y;
    }
    point_.push_back(along >= 0 ? q : Point{q.y, q.x});
  }
  return x + y + z > 0;
}

/// 1 for a left turn, -1 for a right one, 0 for none.
int PolygonTriangulation::turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Point& p = point_[a];
  const Point& q = point_[b];
  const Point& r = point_[c];
  return sign_of_determinant(q.x - p.x, r.y - p.y, q.y - p.y, r.x - p.x);
}

bool PolygonTriangulation::fan_is_sound() const {
  for (std::uint32_t i = 2; i < point_.size(); ++i) {
    if (turn(0, i - 1, i) <= 0) return false;
  }
  return true;
}

bool PolygonTriangulation::is_ear(std::uint32_t b) const {
  const std::uint32_t a = before_[b];
  const std::uint32_t c = after_[b];
  if (turn(a, b, c) <= 0) return false;
  for (std::uint32_t v = after_[c]; v != a; v = after_[v]) {
    // On a side counts as inside, but for another corner at the place of an end.
    if (turn(a, b, v) < 0 || turn(b, c, v) < 0 || turn(c, a, v) < 0) continue;
    const auto same = [&](std::uint32_t w) {
      return point_[v].x == point_[w].x && point_[v].y == point_[w].y;
    };
    if (!same(a) && !same(c)) return false;
  }
  return true;
}

void PolygonTriangulation::find_ears(std::uint32_t first) {
  std::uint32_t v = first;
  do {
    is_ear_[v] = is_ear(v) ? 1 : 0;
    v = after_[v];
  } while (v != first);
}

void PolygonTriangulation::clip_ears() {
  const auto n = static_cast<std::uint32_t>(point_.size());
  before_.resize(n);
  after_.resize(n);
  is_ear_.resize(n);
  for (std::uint32_t v = 0; v < n; ++v) {
    before_[v] = (v + n - 1) % n;
    after_[v] = (v + 1) % n;
  }
  find_ears(0);
  // Clipping changes its neighbours alone. Where corners touch sides it may change others: they are
  // looked at again, but not for ever.
  int looks = 3;
  std::uint32_t v = 0;
  std::uint32_t left = n;
  for (std::uint32_t passed = 0; left > 3 && passed < left;) {
    if (is_ear_[v] == 0) {
      v = after_[v];
      if (++passed == left && looks-- > 0) {
        find_ears(v);
        passed = 0;
      }
      continue;
    }
    const std::uint32_t a = before_[v];
    const std::uint32_t c = after_[v];
    triangle_.push_back({a, v, c});
    after_[a] = c;
    before_[c] = a;
    --left;
    is_ear_[a] = is_ear(a) ? 1 : 0;
    is_ear_[c] = is_ear(c) ? 1 : 0;
    v = c;
    passed = 0;
  }
  for (std::uint32_t b = after_[v]; after_[b] != v; b = after_[b])
    triangle_.push_back({v, b, after_[b]});
}

std::span<const PolygonCorners> PolygonTriangulation::cut(std::span<const Vec3> corner) {
  triangle_.clear();
  if (project(corner) && !fan_is_sound()) {
    clip_ears();
  } else {
    for (std::uint32_t i = 2; i < corner.size(); ++i) triangle_.push_back({0, i - 1, i});
  }
  return triangle_;
}

void PolygonCutter::cut(std::span<const VertexId> corners,
                        FunctionRef<void(const Triangle&)> sink) {
  position_.clear();
  for (const VertexId v : corners) position_.push_back(position(v));
  const auto wild = std::find_if(position_.begin(), position_.end(), [](const Vec3& p) {
    return !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z);
  });
  if (wild != position_.end()) {
    const auto n = corners.size();
    const auto apex = static_cast<std::size_t>(wild - position_.begin());
    for (std::size_t i = 2; i < n; ++i)
      sink({corners[apex], corners[(apex + i - 1) % n], corners[(apex + i) % n]});
    return;
  }
  for (const PolygonCorners& t : triangulation_.cut(position_))
    sink({corners[t[0]], corners[t[1]], corners[t[2]]});
}

}  // namespace remaps
