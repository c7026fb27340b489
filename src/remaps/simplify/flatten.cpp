#include "remaps/simplify/flatten.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "remaps/base/fast_math.h"

namespace remaps::simplify {
namespace {

/// Edges below this fraction of the ring's size count as zero: squared, 1e-24.
constexpr float kLeastSquare = 1e-24f;

double squared_distance(GridPoint a, GridPoint b) {
  const double x = b.x - a.x;
  const double y = b.y - a.y;
  return x * x + y * y;
}

/// Polar coordinates of the ring, before the power.
struct Polar {
  alignas(16) RingFloats log_radius, angle;
  float log_mean = 0;
  float total = 0;  // angle
};

/// The power of two that brings the largest coordinate to [1, 2), or 0 if there is none.
float unit_scale(const RingOffsets& ring) {
  Float4 largest = all4(0.0f);
  for (unsigned i = 0; i < ring.size; i += kLanes) {
    largest = max4(largest, max4(abs4(load4(&ring.x[i])),
                                 max4(abs4(load4(&ring.y[i])), abs4(load4(&ring.z[i])))));
  }
  const std::uint32_t exponent = std::bit_cast<std::uint32_t>(largest_lane(largest)) >> 23;
  if (exponent == 0 || exponent > 253) return 0;
  return std::bit_cast<float>((254 - exponent) << 23);
}

bool find_polar(const RingOffsets& ring, unsigned wedges, Polar& out) {
  const float scale = unit_scale(ring);
  if (scale == 0) return false;
  alignas(16) RingFloats wedge_angle;
  Float4 least = all4(1.0f);
  for (unsigned i = 0; i < ring.size; i += kLanes) {
    const Float4 ax = scale * load4(&ring.x[i]);
    const Float4 ay = scale * load4(&ring.y[i]);
    const Float4 az = scale * load4(&ring.z[i]);
    const Float4 bx = scale * load4(&ring.x[i + 1]);
    const Float4 by = scale * load4(&ring.y[i + 1]);
    const Float4 bz = scale * load4(&ring.z[i + 1]);
    const Float4 squared = ax * ax + ay * ay + az * az;
    least = min4(squared, least);
    store4(&out.log_radius[i], 0.5f * fast_log2(squared));
    const Float4 cx = ay * bz - az * by;
    const Float4 cy = az * bx - ax * bz;
    const Float4 cz = ax * by - ay * bx;
    store4(&wedge_angle[i],
           fast_angle(ax * bx + ay * by + az * bz, sqrt4(cx * cx + cy * cy + cz * cz)));
  }
  if (!(least_lane(least) > kLeastSquare)) return false;
  float sum = 0;
  for (unsigned i = 0; i < ring.size; ++i) {
    out.angle[i] = out.total;
    if (i < wedges) out.total += wedge_angle[i];
    sum += out.log_radius[i];
  }
  out.log_mean = sum / static_cast<float>(ring.size);
  for (unsigned i = ring.size; i % kLanes != 0; ++i) out.angle[i] = 0;
  return out.total > 0;
}

/// Turns the angles so that the crease starts at 0 and has half of the total on either side.
/// @return  false when a side has no angle
bool straighten(const Crease& crease, unsigned n, Polar& polar) {
  const float start = polar.angle[crease.from];
  const auto since_start = [&](unsigned i) {
    const float angle = polar.angle[i] - start;
    return i < crease.from ? angle + polar.total : angle;
  };
  const float first = since_start(crease.to);
  const float second = polar.total - first;
  if (!(first > 0 && second > 0)) return false;
  const float half = 0.5f * polar.total;
  alignas(16) RingFloats angle = polar.angle;
  for (unsigned i = 0; i < n; ++i) {
    const float at = since_start(i);
    angle[i] = at < first ? at * (half / first) : half + (at - first) * (half / second);
  }
  polar.angle = angle;
  return true;
}

bool wedges_have_shape(const FlatStar& star, double floor) {
  for (unsigned i = 0; i < star.wedges; ++i) {
    const GridPoint a = star.ring[i];
    const GridPoint b = star.ring[i + 1 == star.ring_size() ? 0 : i + 1];
    if (!(planar_shape({}, a, b) >= floor)) return false;
  }
  return true;
}

}  // namespace

double planar_shape(GridPoint a, GridPoint b, GridPoint c) {
  const double longest =
      std::max({squared_distance(a, b), squared_distance(b, c), squared_distance(c, a)});
  return longest > 0 ? orientation(a, b, c) / longest : 0;
}

bool flatten_star(const RingOffsets& ring, bool boundary, double floor, FlatStar& out,
                  const Crease& crease) {
  const unsigned n = ring.size;
  out.wedges = boundary ? n - 1 : n;
  out.boundary = boundary;
  Polar polar;
  if (!find_polar(ring, out.wedges, polar)) return false;
  if (crease.exists() && !straighten(crease, n, polar)) return false;
  const float power = static_cast<float>((boundary ? 1 : 2) * std::numbers::pi) / polar.total;
  const auto exponent = [&](unsigned i) {
    return power * (load4(&polar.log_radius[i]) - polar.log_mean);
  };
  Float4 largest = exponent(0);
  for (unsigned i = kLanes; i < n; i += kLanes) largest = max4(largest, exponent(i));
  const float longest = largest_lane(largest);
  for (unsigned i = 0; i < n; i += kLanes) {
    const Float4 radius =
        float(kGridRadius) * fast_exp2(max4(exponent(i) - longest, all4(-100.0f)));
    const SineCosine4 turn = fast_sine_cosine(power * load4(&polar.angle[i]));
    const Int4 x = __builtin_convertvector(round4(radius * turn.cosine), Int4);
    const Int4 y = __builtin_convertvector(round4(radius * turn.sine), Int4);
    for (unsigned k = 0; k < kLanes && i + k < n; ++k) {
      out.ring[i + k] = {static_cast<std::int16_t>(x[k]), static_cast<std::int16_t>(y[k])};
    }
  }
  if (boundary) {
    // The two boundary edges lie on one line through the origin, exactly.
    out.ring[0].y = 0;
    out.ring[n - 1].y = 0;
  } else if (crease.exists()) {
    out.ring[crease.from].y = 0;
    out.ring[crease.to].y = 0;
  }
  return wedges_have_shape(out, floor);
}

bool flatten_star(std::span<const Vec3> offsets, bool boundary, double floor, FlatStar& out,
                  const Crease& crease) {
  double largest = 0;
  for (const Vec3& p : offsets) {
    largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  }
  bool finite = largest > 0 && std::isfinite(largest);
  RingOffsets ring;
  ring.size = static_cast<unsigned>(offsets.size());
  const double scale = finite ? std::exp2(-std::ilogb(largest)) : 1;
  for (unsigned i = 0; i < ring.size; ++i) {
    const Vec3 p = scale * offsets[i];
    finite = finite && std::isfinite(norm2(p));
    ring.x[i] = static_cast<float>(p.x);
    ring.y[i] = static_cast<float>(p.y);
    ring.z[i] = static_cast<float>(p.z);
  }
  if (!finite) return false;
  ring.close();
  return flatten_star(ring, boundary, floor, out, crease);
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
