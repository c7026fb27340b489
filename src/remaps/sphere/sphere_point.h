#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "remaps/base/geometry.h"

namespace remaps::sphere {

/// A direction, as integers: on the unit sphere times 2^40, rounded. What is decided about such
/// points is decided in 128-bit integers, without any rounding.
using SpherePoint = std::array<std::int64_t, 3>;

__extension__ using Int128 = __int128;

inline constexpr double kSphereGrid = 0x1p40;

/// @param p  of length 1
inline SpherePoint to_sphere_point(const Vec3& p) {
  return {std::llround(p.x * kSphereGrid), std::llround(p.y * kSphereGrid),
          std::llround(p.z * kSphereGrid)};
}
/// Of length 1, but for 1e-12.
inline Vec3 to_vector(const SpherePoint& p) {
  return {static_cast<double>(p[0]) / kSphereGrid, static_cast<double>(p[1]) / kSphereGrid,
          static_cast<double>(p[2]) / kSphereGrid};
}

/// Six times the volume of (centre, a, b, c), exactly: positive if they turn counter-clockwise seen
/// from outside. Coordinates are of 41 bits, so minors are of 83 and the result of 126.
inline Int128 orientation(const SpherePoint& a, const SpherePoint& b, const SpherePoint& c) {
  const auto minor = [&](std::size_t i, std::size_t j) {
    return Int128{b[i]} * c[j] - Int128{b[j]} * c[i];
  };
  return a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1);
}

}  // namespace remaps::sphere
