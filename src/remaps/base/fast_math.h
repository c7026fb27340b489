#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

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

/// 2^x for |x| < 1000. Relative error below 1e-6.
inline double fast_exp2(double x) {
  constexpr double kMagic = 0x1.8p52;
  const double whole = (x + kMagic) - kMagic;
  const double f = (x - whole) * std::numbers::ln2;
  const double p =
      1 + f * (1 + f * (0.5 + f * (1.0 / 6 + f * (1.0 / 24 + f * (1.0 / 120 + f * (1.0 / 720))))));
  const auto scale = static_cast<std::uint64_t>(static_cast<std::int64_t>(whole) + 1023) << 52;
  return p * std::bit_cast<double>(scale);
}

/// Angle of (x, y) with y >= 0, in [0, pi]. Absolute error below 1e-7.
/// Source: Abramowitz, Stegun, Handbook of Mathematical Functions, 4.4.49.
inline double fast_angle(double x, double y) {
  constexpr std::array<double, 8> kCoefficient{-0.3333314528, 0.1999355085,  -0.1420889944,
                                               0.1065626393,  -0.0752896400, 0.0429096138,
                                               -0.0161657367, 0.0028662257};
  const double ax = std::fabs(x);
  const bool steep = y > ax;
  const double t = steep ? ax / y : (ax > 0 ? y / ax : 0);
  const double t2 = t * t;
  double sum = 0;
  for (std::size_t i = kCoefficient.size(); i-- > 0;) sum = t2 * (kCoefficient[i] + sum);
  double angle = t * (1 + sum);
  if (steep) angle = std::numbers::pi / 2 - angle;
  return x < 0 ? std::numbers::pi - angle : angle;
}

struct SineCosine {
  double sine, cosine;
};

/// Sine and cosine for |angle| < 1e6 rad. Absolute error below 1e-6.
inline SineCosine fast_sine_cosine(double angle_rad) {
  constexpr double kMagic = 0x1.8p52;
  const double quarter = (angle_rad * (2 / std::numbers::pi) + kMagic) - kMagic;
  const double r = angle_rad - quarter * (std::numbers::pi / 2);
  const double r2 = r * r;
  const double s = r * (1 + r2 * (-1.0 / 6 + r2 * (1.0 / 120 + r2 * (-1.0 / 5040))));
  const double c = 1 + r2 * (-0.5 + r2 * (1.0 / 24 + r2 * (-1.0 / 720 + r2 * (1.0 / 40320))));
  switch (static_cast<std::int64_t>(quarter) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace remaps
