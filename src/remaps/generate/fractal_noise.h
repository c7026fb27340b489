#pragma once

#include <array>
#include <cstdint>

#include "remaps/base/geometry.h"

namespace remaps {

/// Fractal gradient noise in space: a sum of octaves, each of twice the frequency of the one
/// before. The first octave has wavelength 1; the value lies within [-1, 1], mostly within a third
/// of it. Pure function of the point and the seed, with continuous first and second derivatives.
/// Source: Perlin, Improving Noise, SIGGRAPH 2002.
class FractalNoise {
 public:
  /// @param octaves    at least 1
  /// @param roughness  amplitude of an octave over that of the one before; 1/2 gives a 1/f spectrum
  FractalNoise(std::uint64_t seed, int octaves, double roughness);

  double operator()(const Vec3& p) const;

 private:
  static constexpr int kGradientBits = 8;
  /// Padded to a power of two so that an index is a shift.
  struct alignas(32) Gradient {
    double x, y, z, unused;
  };

  double octave(const Vec3& p) const;

  std::array<Gradient, 1 << kGradientBits> gradients_;
  Vec3 origin_;
  int octaves_;
  double roughness_;
  double scale_;
};

}  // namespace remaps
