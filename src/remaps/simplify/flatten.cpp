#include "remaps/simplify/flatten.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "remaps/base/fast_math.h"

namespace remaps::simplify {
namespace {

constexpr double kLeastSquare = 1e-300;  // normal numbers only

double squared_distance(GridPoint a, GridPoint b) {
  const double x = b.x - a.x;
  const double y = b.y - a.y;
  return x * x + y * y;
}

std::int16_t to_grid(double value) {
  return static_cast<std::int16_t>(std::lrint(value));
}

}  // namespace

double planar_shape(GridPoint a, GridPoint b, GridPoint c) {
  const double longest =
      std::max({squared_distance(a, b), squared_distance(b, c), squared_distance(c, a)});
  return longest > 0 ? orientation(a, b, c) / longest : 0;
}

bool flatten_star(std::span<const Vec3> offsets, bool boundary, double floor, FlatStar& out) {
  const auto n = static_cast<unsigned>(offsets.size());
  out.wedges = boundary ? n - 1 : n;
  out.boundary = boundary;
  std::array<double, kMaxRing> log_radius{};
  std::array<double, kMaxRing> angle{};
  double log_mean = 0;
  for (unsigned i = 0; i < n; ++i) {
    const double squared = norm2(offsets[i]);
    if (!(squared > kLeastSquare) || !std::isfinite(squared)) return false;
    log_radius[i] = 0.5 * fast_log2(squared);
    log_mean += log_radius[i] / n;
  }
  double total = 0;
  for (unsigned i = 0; i < out.wedges; ++i) {
    const Vec3& a = offsets[i];
    const Vec3& b = offsets[i + 1 == n ? 0 : i + 1];
    angle[i] = total;
    total += fast_angle(dot(a, b), norm(cross(a, b)));
  }
  if (boundary) angle[n - 1] = total;
  if (!(total > 0)) return false;

  const double power = (boundary ? 1.0 : 2.0) * std::numbers::pi / total;
  double largest = 0;
  for (unsigned i = 0; i < n; ++i) largest = std::max(largest, power * (log_radius[i] - log_mean));
  for (unsigned i = 0; i < n; ++i) {
    const double exponent = std::max(power * (log_radius[i] - log_mean) - largest, -500.0);
    const double radius = kGridRadius * fast_exp2(exponent);
    const SineCosine turn = fast_sine_cosine(power * angle[i]);
    out.ring[i] = {to_grid(radius * turn.cosine), to_grid(radius * turn.sine)};
  }
  if (boundary) {
    // The two boundary edges lie on one line through the origin, exactly.
    out.ring[0].y = 0;
    out.ring[n - 1].y = 0;
  }
  for (unsigned i = 0; i < out.wedges; ++i) {
    if (!(planar_shape({}, out.ring[i], out.ring[i + 1 == n ? 0 : i + 1]) >= floor)) return false;
  }
  return true;
}

bool fan_is_valid(const FlatStar& star, unsigned apex, double floor) {
  const unsigned n = star.ring_size();
  unsigned a = apex + 1 == n ? 0 : apex + 1;
  for (unsigned j = 0; j + 2 < n; ++j) {
    const unsigned b = a + 1 == n ? 0 : a + 1;
    if (!(planar_shape(star.ring[apex], star.ring[a], star.ring[b]) >= floor)) return false;
    a = b;
  }
  return true;
}

}  // namespace remaps::simplify
