#pragma once

#include <array>
#include <cstdint>

#include "remaps/base/geometry.h"

namespace remaps {

/// Four floats that the compiler adds and multiplies at once, on every machine.
using Float4 [[gnu::vector_size(16)]] = float;

/// Fractal gradient noise in space: a sum of octaves, each of twice the frequency of the one
/// before. The first octave has wavelength 1; the value is in [-1, 1], mostly within a third of it.
/// A pure function of the point and the seed; value and slope are continuous up to the rounding of
/// floats. Source: Perlin, Improving Noise, SIGGRAPH 2002.
class FractalNoise {
 public:
  /// @param octaves    at least 1
  /// @param roughness  amplitude of an octave over that of the one before; 1/2 gives a 1/f spectrum
  FractalNoise(std::uint64_t seed, int octaves, double roughness);

  double operator()(const Vec3& p) const;

 private:
  Float4 octave(const Vec3& p) const;

  std::array<Float4, 256> gradients_;
  Vec3 origin_;
  int octaves_;
  double roughness_;
  double scale_;
};

}  // namespace remaps
