#include "remaps/generate/fractal_noise.h"

#include "remaps/generate/hash_mix.h"

namespace remaps {
namespace {

// Odd constants that spread each lattice coordinate over 64 bits before they are combined.
constexpr std::uint64_t kSpreadX = 0x9E3779B97F4A7C15u;
constexpr std::uint64_t kSpreadY = 0xC2B2AE3D27D4EB4Fu;
constexpr std::uint64_t kSpreadZ = 0x165667B19E3779F9u;
constexpr std::uint64_t kCombine = 0xD6E8FEB86659FD93u;

/// A coordinate in its lattice cell: the hash factor of either end, the offset and its fade.
struct CellAxis {
  std::uint64_t low, high;
  double offset, fade;

  CellAxis(double value, std::uint64_t spread) {
    auto cell = static_cast<std::int64_t>(value);
    cell -= value < static_cast<double>(cell) ? 1 : 0;
    low = static_cast<std::uint64_t>(cell) * spread;
    high = low + spread;
    offset = value - static_cast<double>(cell);
    fade = offset * offset * offset * (offset * (offset * 6 - 15) + 10);
  }
};

double lerp(double a, double b, double t) {
  return a + t * (b - a);
}

Vec3 unit_vector(std::uint64_t key) {
  for (;; ++key) {
    const Vec3 p{2 * unit_interval(mix_bits(3 * key)) - 1,
                 2 * unit_interval(mix_bits(3 * key + 1)) - 1,
                 2 * unit_interval(mix_bits(3 * key + 2)) - 1};
    if (norm2(p) <= 1 && norm2(p) > 1e-4) return 1 / norm(p) * p;
  }
}

}  // namespace

FractalNoise::FractalNoise(std::uint64_t seed, int octaves, double roughness)
    : octaves_(octaves), roughness_(roughness) {
  for (std::uint64_t i = 0; i < gradients_.size(); ++i) {
    const Vec3 g = unit_vector(hash_key(seed, i));
    gradients_[i] = {g.x, g.y, g.z, 0};
  }
  const auto coordinate = [&](std::uint64_t key) {
    return 64 * unit_interval(hash_key(~seed, key));
  };
  origin_ = {coordinate(0), coordinate(1), coordinate(2)};

  // One octave of gradient noise stays within sqrt(3) / 2.
  double sum = 0;
  double amplitude = 1;
  for (int i = 0; i < octaves_; ++i, amplitude *= roughness_) sum += amplitude;
  scale_ = 1 / (sum * 0.8660254037844387);
}

double FractalNoise::operator()(const Vec3& p) const {
  double value = 0;
  double amplitude = scale_;
  Vec3 q = p + origin_;
  for (int i = 0; i < octaves_; ++i) {
    value += amplitude * octave(q);
    amplitude *= roughness_;
    // The shift keeps the zeros at lattice points of one octave off those of the next.
    q = 2 * q + Vec3{0.37, 0.53, 0.71};
  }
  return value;
}

double FractalNoise::octave(const Vec3& p) const {
  const CellAxis x(p.x, kSpreadX);
  const CellAxis y(p.y, kSpreadY);
  const CellAxis z(p.z, kSpreadZ);
  const auto corner = [&](std::uint64_t hash, double dx, double dy, double dz) {
    const Gradient& g = gradients_[(hash * kCombine) >> (64 - kGradientBits)];
    return g.x * dx + g.y * dy + g.z * dz;
  };
  const auto edge = [&](std::uint64_t yz, double dy, double dz) {
    return lerp(corner(x.low ^ yz, x.offset, dy, dz), corner(x.high ^ yz, x.offset - 1, dy, dz),
                x.fade);
  };
  const double low = lerp(edge(y.low ^ z.low, y.offset, z.offset),
                          edge(y.high ^ z.low, y.offset - 1, z.offset), y.fade);
  const double high = lerp(edge(y.low ^ z.high, y.offset, z.offset - 1),
                           edge(y.high ^ z.high, y.offset - 1, z.offset - 1), y.fade);
  return lerp(low, high, z.fade);
}

}  // namespace remaps
