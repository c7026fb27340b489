#pragma once

#include <cmath>
#include <limits>

#include "remaps/base/geometry.h"

namespace remaps {

/// What readers deliver for a vertex without a position, whatever its coordinates are in the file:
/// one of them is NaN, infinite or beyond the range of floats.
inline constexpr Vec3 kNotFinite{std::numeric_limits<double>::quiet_NaN(),
                                 std::numeric_limits<double>::quiet_NaN(),
                                 std::numeric_limits<double>::quiet_NaN()};

/// True when storing the value as a float loses nothing.
inline bool is_float(double value) {
  return std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max()) &&
         static_cast<double>(static_cast<float>(value)) == value;
}
inline bool is_float(const Vec3& p) {
  return is_float(p.x) && is_float(p.y) && is_float(p.z);
}

/// The least value that no float is near: a float's largest and half a step.
inline constexpr double kBeyondFloat = 0x1.ffffffp127;

/// True when a float can be near it: not NaN, not infinite, not beyond the floats.
inline bool has_position(const Vec3& p) {
  return std::fabs(p.x) < kBeyondFloat && std::fabs(p.y) < kBeyondFloat &&
         std::fabs(p.z) < kBeyondFloat;
}

}  // namespace remaps
