#pragma once

#include <algorithm>
#include <utility>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace remaps {

/// Four floats at a time: the instructions of every 64-bit x86, plain loops elsewhere, where
/// results are the same bit for bit.
#if defined(__SSE2__)
struct Float4 {
  __m128 value;

  static Float4 all(float x) { return {_mm_set1_ps(x)}; }
  /// @param from  aligned to 16 bytes
  static Float4 load(const float* from) { return {_mm_load_ps(from)}; }
  void store(float* to) const { _mm_store_ps(to, value); }

  friend Float4 operator+(Float4 a, Float4 b) { return {_mm_add_ps(a.value, b.value)}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {_mm_sub_ps(a.value, b.value)}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {_mm_mul_ps(a.value, b.value)}; }
  friend Float4 max(Float4 a, Float4 b) { return {_mm_max_ps(a.value, b.value)}; }
  friend Float4 min(Float4 a, Float4 b) { return {_mm_min_ps(a.value, b.value)}; }
  /// Bit i: a[i] <= b[i].
  friend unsigned at_most(Float4 a, Float4 b) {
    return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(a.value, b.value)));
  }
};
#else
struct Float4 {
  float value[4];

  static Float4 all(float x) { return {{x, x, x, x}}; }
  static Float4 load(const float* from) { return {{from[0], from[1], from[2], from[3]}}; }
  void store(float* to) const { std::copy(value, value + 4, to); }

  template <class Operation>
  static Float4 combine(Float4 a, Float4 b, Operation operation) {
    Float4 result;
    for (int i = 0; i < 4; ++i) result.value[i] = operation(a.value[i], b.value[i]);
    return result;
  }
  friend Float4 operator+(Float4 a, Float4 b) {
    return combine(a, b, [](float x, float y) { return x + y; });
  }
  friend Float4 operator-(Float4 a, Float4 b) {
    return combine(a, b, [](float x, float y) { return x - y; });
  }
  friend Float4 operator*(Float4 a, Float4 b) {
    return combine(a, b, [](float x, float y) { return x * y; });
  }
  friend Float4 max(Float4 a, Float4 b) {
    return combine(a, b, [](float x, float y) { return x > y ? x : y; });
  }
  friend Float4 min(Float4 a, Float4 b) {
    return combine(a, b, [](float x, float y) { return x < y ? x : y; });
  }
  friend unsigned at_most(Float4 a, Float4 b) {
    unsigned bits = 0;
    for (unsigned i = 0; i < 4; ++i) bits |= (a.value[i] <= b.value[i] ? 1u : 0u) << i;
    return bits;
  }
};
#endif

/// Makes rows of columns.
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
#if defined(__SSE2__)
  _MM_TRANSPOSE4_PS(a.value, b.value, c.value, d.value);
#else
  std::swap(a.value[1], b.value[0]);
  std::swap(a.value[2], c.value[0]);
  std::swap(a.value[3], d.value[0]);
  std::swap(b.value[2], c.value[1]);
  std::swap(b.value[3], d.value[1]);
  std::swap(c.value[3], d.value[2]);
#endif
}

}  // namespace remaps
