#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace remaps {

/// Index of a vertex or a face in a stream or a file. 64 bits: a stream may be of any length.
/// Inside a patch indices are 32-bit (LocalIndex); `narrow` converts and the compiler warns of the
/// rest.
using VertexId = std::uint64_t;
using FaceId = std::uint64_t;
using LocalIndex = std::uint32_t;

inline constexpr LocalIndex kNoIndex = 0xFFFFFFFFu;

/// A point or vector, in the units of the input file.
struct Vec3 {
  double x = 0, y = 0, z = 0;

  friend bool operator==(const Vec3&, const Vec3&) = default;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(double s, const Vec3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm2(const Vec3& a) {
  return dot(a, a);
}
inline double norm(const Vec3& a) {
  return std::sqrt(norm2(a));
}

/// Position with float coordinates: what segments and tiles store.
struct Vec3f {
  float x = 0, y = 0, z = 0;

  friend bool operator==(const Vec3f&, const Vec3f&) = default;
};

inline Vec3 widen(const Vec3f& a) {
  return {a.x, a.y, a.z};
}
inline Vec3f to_float(const Vec3& a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

/// Axis-aligned box; empty until the first `add`.
struct Box3 {
  Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Vec3 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
            -std::numeric_limits<double>::infinity()};

  void add(const Vec3& p) {
    low = {std::fmin(low.x, p.x), std::fmin(low.y, p.y), std::fmin(low.z, p.z)};
    high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y), std::fmax(high.z, p.z)};
  }
  bool empty() const { return !(low.x <= high.x); }
  double diagonal() const { return empty() ? 0.0 : norm(high - low); }
};

/// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<VertexId, 3>;

/// Three corner positions, counter-clockwise seen from outside.
using TrianglePositions = std::array<Vec3, 3>;

}  // namespace remaps
