#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>

#include "remaps/base/simd.h"

/// Elementary functions to about 1e-6, for places where the result is rounded to a grid or only
/// ranks things. Plain arithmetic: the same bits on every machine and with every C library.
/// Errors are checked by a test.
namespace remaps {

/// log2(x) for finite x > 0, normal. Absolute error below 1e-6.
inline double fast_log2(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  constexpr std::uint64_t kHalfRoot = 0x3FE6A09E667F3BCDu;  // sqrt(1/2)
  const auto exponent = static_cast<std::int64_t>(bits - kHalfRoot) >> 52;
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(exponent) << 52));
  const double s = (m - 1) / (m + 1);
  const double s2 = s * s;
  return double(exponent) +
         2 * std::numbers::log2e * s * (1 + s2 * (1.0 / 3 + s2 * (1.0 / 5 + s2 * (1.0 / 7))));
}

// The same for four floats at a time: what is rounded to the grid of a star needs no more.

/// log2 of normal numbers above 0. Absolute error below 1e-6 for results below 8.
inline Float4 fast_log2(Float4 x) {
  const Int4 bits = std::bit_cast<Int4>(x);
  constexpr std::int32_t kHalfRoot = 0x3F3504F3;  // sqrt(1/2)
  const Int4 exponent = (bits - kHalfRoot) >> 23;
  const Float4 m = std::bit_cast<Float4>(bits - (exponent << 23));
  const Float4 s = (m - 1) / (m + 1);
  const Float4 s2 = s * s;
  return __builtin_convertvector(exponent, Float4) +
         s * (2.885390082f + s2 * (0.961796694f + s2 * (0.577078016f + s2 * 0.412198583f)));
}

/// 2^x for |x| < 120. Relative error below 5e-6.
inline Float4 fast_exp2(Float4 x) {
  const Float4 whole = round4(x);
  const Float4 f = (x - whole) * 0.693147181f;
  const Float4 p =
      1 + f * (1 + f * (0.5f + f * (0.166666667f + f * (0.0416666667f + f * 0.00833333333f))));
  const Int4 scale = (__builtin_convertvector(whole, Int4) + 127) << 23;
  return p * std::bit_cast<Float4>(scale);
}

/// Square root of numbers that are not negative.
inline Float4 sqrt4(Float4 x) {
  return Float4{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
}

/// Angle of (x, y) with y >= 0, in [0, pi]. Absolute error below 1e-6.
/// Source: Abramowitz, Stegun, Handbook of Mathematical Functions, 4.4.49.
inline Float4 fast_angle(Float4 x, Float4 y) {
  const Float4 ax = abs4(x);
  const Int4 steep = y > ax;
  const Float4 high = select4(steep, y, ax);
  const Float4 t = select4(high > 0, select4(steep, ax, y) / high, all4(0.0f));
  const Float4 t2 = t * t;
  Float4 sum = all4(0.0028662257f);
  for (const float c : {-0.0161657367f, 0.0429096138f, -0.0752896400f, 0.1065626393f,
                        -0.1420889944f, 0.1999355085f, -0.3333314528f}) {
    sum = c + t2 * sum;
  }
  Float4 angle = t * (1 + t2 * sum);
  angle = select4(steep, 1.57079633f - angle, angle);
  return select4(x < 0, 3.14159265f - angle, angle);
}

struct SineCosine4 {
  Float4 sine, cosine;
};

/// Sine and cosine for |angle| < 100 rad. Absolute error below 2e-6.
inline SineCosine4 fast_sine_cosine(Float4 angle_rad) {
  const Float4 quarter = round4(angle_rad * 0.636619772f);
  const Float4 r = (angle_rad - quarter * 1.5703125f) - quarter * 0.000483826794f;
  const Float4 r2 = r * r;
  const Float4 s = r * (1 + r2 * (-0.166666667f + r2 * (0.00833333333f + r2 * -0.000198412698f)));
  const Float4 c =
      1 + r2 * (-0.5f + r2 * (0.0416666667f + r2 * (-0.00138888889f + r2 * 2.48015873e-5f)));
  const Int4 turn = __builtin_convertvector(quarter, Int4) & 3;
  const Int4 odd = (turn & 1) != 0;
  const Int4 sine_sign = (turn & 2) << 30;
  const Int4 cosine_sign = ((turn + 1) & 2) << 30;
  const Float4 sine = select4(odd, c, s);
  const Float4 cosine = select4(odd, s, c);
  return {std::bit_cast<Float4>(std::bit_cast<Int4>(sine) ^ sine_sign),
          std::bit_cast<Float4>(std::bit_cast<Int4>(cosine) ^ cosine_sign)};
}

/// log2 to 0.09: ranks things. For normal numbers above 0.
inline float rough_log2(float x) {
  return static_cast<float>(std::bit_cast<std::int32_t>(x)) * 0x1p-23f - 126.942695f;
}

}  // namespace remaps
