#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

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
/// a < b ? a : b, lane by lane.
inline Float4 min4(Float4 a, Float4 b) {
#ifdef __SSE2__
  return std::bit_cast<Float4>(_mm_min_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b)));
#else
  return select4(a < b, a, b);
#endif
}
/// a > b ? a : b, lane by lane.
inline Float4 max4(Float4 a, Float4 b) {
#ifdef __SSE2__
  return std::bit_cast<Float4>(_mm_max_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b)));
#else
  return select4(a > b, a, b);
#endif
}
/// Bit i: a[i] <= b[i].
inline unsigned at_most4(Float4 a, Float4 b) {
#ifdef __SSE2__
  const __m128 mask = _mm_cmple_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b));
  return static_cast<unsigned>(_mm_movemask_ps(mask));
#else
  unsigned bits = 0;
  for (unsigned i = 0; i < kLanes; ++i) bits |= (a[i] <= b[i] ? 1u : 0u) << i;
  return bits;
#endif
}
/// Makes rows of columns.
inline void transpose4(Float4& a, Float4& b, Float4& c, Float4& d) {
  const Float4 ra{a[0], b[0], c[0], d[0]};
  const Float4 rb{a[1], b[1], c[1], d[1]};
  const Float4 rc{a[2], b[2], c[2], d[2]};
  d = Float4{a[3], b[3], c[3], d[3]};
  a = ra, b = rb, c = rc;
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

struct SignMasks {
  unsigned positive = 0, near = 0;  // bit i for lane i
};

/// Signs of (x - ax) * dy - (y - ay) * dx for four points in halves of words, x in the low half, y
/// in the high one: above `least`, or within it. In floats: with x - ax and y - ay whole and below
/// 2^15 and dx and dy below 2^15, a value errs by less than 2^9.
inline SignMasks signs_of_cross(Int4 points, float ax, float ay, float dx, float dy, float least) {
  const Int4 px = (points << 16) >> 16;
  const Int4 py = points >> 16;
  const Float4 x = __builtin_convertvector(px, Float4) - all4(ax);
  const Float4 y = __builtin_convertvector(py, Float4) - all4(ay);
  const Float4 value = x * all4(dy) - y * all4(dx);
  return {~at_most4(value, all4(least)) & 15u, at_most4(abs4(value), all4(least))};
}

}  // namespace remaps
