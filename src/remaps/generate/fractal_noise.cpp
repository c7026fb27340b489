#include "remaps/generate/fractal_noise.h"

#include <tuple>

#include "remaps/generate/hash_mix.h"

namespace remaps {
namespace {

// Odd constants that spread each lattice coordinate over 64 bits; its upper bits are its hash. The
// gradient at a lattice point is chosen by the exclusive or of three hashes.
constexpr std::uint64_t kSpreadX = 0x9E3779B97F4A7C15u;
constexpr std::uint64_t kSpreadY = 0xC2B2AE3D27D4EB4Fu;
constexpr std::uint64_t kSpreadZ = 0x165667B19E3779F9u;
constexpr int kHashBits = 8;

/// A coordinate in its lattice cell: the hashes of both ends, the offset from the lower one.
struct CellAxis {
  std::uint64_t low, high;
  float offset;

  CellAxis(double value, std::uint64_t spread) {
    auto cell = static_cast<std::int64_t>(value);
    cell -= value < static_cast<double>(cell) ? 1 : 0;
    const std::uint64_t product = static_cast<std::uint64_t>(cell) * spread;
    low = product >> (64 - kHashBits);
    high = (product + spread) >> (64 - kHashBits);
    offset = static_cast<float>(value - static_cast<double>(cell));
  }
};

Float4 splat(float value) {
  return Float4{value, value, value, value};
}

Float4 lerp(const Float4& a, const Float4& b, const Float4& t) {
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
  static_assert(std::tuple_size_v<decltype(gradients_)> == 1 << kHashBits);
  for (std::uint64_t i = 0; i < gradients_.size(); ++i) {
    const Vec3 g = unit_vector(hash_key(seed, i));
    const Vec3f f = to_float(g);
    gradients_[i] = Float4{f.x, f.y, f.z, 0};
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
  Float4 terms{};
  double amplitude = scale_;
  Vec3 q = p + origin_;
  for (int i = 0; i < octaves_; ++i) {
    terms += splat(static_cast<float>(amplitude)) * octave(q);
    amplitude *= roughness_;
    // The shift keeps the zeros at lattice points of one octave off those of the next.
    q = 2 * q + Vec3{0.37, 0.53, 0.71};
  }
  return double{terms[0]} + double{terms[1]} + double{terms[2]};
}

/// The three terms of the scalar products, interpolated: their sum is the value of one octave.
Float4 FractalNoise::octave(const Vec3& p) const {
  const CellAxis x(p.x, kSpreadX);
  const CellAxis y(p.y, kSpreadY);
  const CellAxis z(p.z, kSpreadZ);
  const Float4 t{x.offset, y.offset, z.offset, 0};
  const Float4 fade = t * t * t * (t * (t * splat(6) - splat(15)) + splat(10));
  const Float4 fade_x = splat(fade[0]);
  const Float4 fade_y = splat(fade[1]);
  const Float4 fade_z = splat(fade[2]);

  const auto corner = [&](std::uint64_t hash, const Float4& offset) {
    return gradients_[hash] * offset;
  };
  const auto edge = [&](std::uint64_t yz, const Float4& offset) {
    return lerp(corner(x.low ^ yz, offset), corner(x.high ^ yz, offset - Float4{1, 0, 0, 0}),
                fade_x);
  };
  const auto side = [&](std::uint64_t z_end, const Float4& offset) {
    return lerp(edge(y.low ^ z_end, offset), edge(y.high ^ z_end, offset - Float4{0, 1, 0, 0}),
                fade_y);
  };
  return lerp(side(z.low, t), side(z.high, t - Float4{0, 0, 1, 0}), fade_z);
}

}  // namespace remaps
