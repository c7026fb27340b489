#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

/// Four numbers at a time, for the small loops around a star: compiler vectors, which every machine
/// has, not intrinsics. Lane by lane the same arithmetic as plain code, so results are the same
/// everywhere.
namespace remaps {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline constexpr unsigned kLanes = 4;

inline Float4 load4(const float* from) {
  Float4 value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
inline Int4 load4(const std::uint32_t* from) {
  Int4 value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
inline void store4(float* to, Float4 value) {
  std::memcpy(to, &value, sizeof value);
}
inline Float4 all4(float value) {
  return Float4{value, value, value, value};
}
inline Int4 all4(std::int32_t value) {
  return Int4{value, value, value, value};
}
/// Lanes of a where the mask is set (-1), of b where it is not (0).
inline Float4 select4(Int4 mask, Float4 a, Float4 b) {
  return std::bit_cast<Float4>((mask & std::bit_cast<Int4>(a)) | (~mask & std::bit_cast<Int4>(b)));
}
inline Float4 min4(Float4 a, Float4 b) {
  return select4(a < b, a, b);
}
inline Float4 max4(Float4 a, Float4 b) {
  return select4(a > b, a, b);
}
inline Float4 abs4(Float4 a) {
  return std::bit_cast<Float4>(std::bit_cast<Int4>(a) & all4(0x7FFFFFFF));
}
inline float least_lane(Float4 a) {
  const float x = a[0] < a[1] ? a[0] : a[1];
  const float y = a[2] < a[3] ? a[2] : a[3];
  return x < y ? x : y;
}
inline float largest_lane(Float4 a) {
  const float x = a[0] > a[1] ? a[0] : a[1];
  const float y = a[2] > a[3] ? a[2] : a[3];
  return x > y ? x : y;
}
inline Int4 lanes_from(unsigned first) {
  const auto i = static_cast<std::int32_t>(first);
  return Int4{i, i + 1, i + 2, i + 3};
}
/// To the nearest whole number, for |x| < 2^22.
inline Float4 round4(Float4 x) {
  const Float4 magic = all4(0x1.8p23f);
  return (x + magic) - magic;
}

}  // namespace remaps
