#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace remaps {

/// Codes for ids that differ little from the one before. Encoders need 8 bytes of room behind what
/// they write, decoders 8 readable bytes behind what they read; both have no loop over bytes where
/// it counts.

/// The step between two ids of 39 bits, small for either sign; at most 40 bits.
constexpr std::uint64_t delta_code(std::uint64_t id, std::uint64_t before) {
  const std::uint64_t step = id - before;
  return step << 1 ^ (0 - (step >> 63));
}
constexpr std::uint64_t apply_delta(std::uint64_t code, std::uint64_t before) {
  return before + (code >> 1 ^ (0 - (code & 1)));
}

/// Unsigned LEB128.
inline std::byte* put_varint(std::byte* at, std::uint64_t value) {
  for (; value >= 128; value >>= 7) *at++ = static_cast<std::byte>(value | 128);
  *at++ = static_cast<std::byte>(value);
  return at;
}
/// Reads 10 bytes at most.
inline const std::byte* get_varint(const std::byte* at, std::uint64_t& value) {
  value = 0;
  for (unsigned shift = 0; shift < 70; shift += 7) {
    const auto byte = static_cast<std::uint64_t>(*at++);
    value |= (byte & 127) << (shift & 63);
    if (byte < 128) break;
  }
  return at;
}

/// Four values below 2^48 in 5 to 25 bytes: two bits of a first byte give the length of each, 1, 2,
/// 4 or 6.
inline std::byte* put_codes(std::byte* at, const std::array<std::uint64_t, 4>& values) {
  std::byte* const lengths = at++;
  unsigned all = 0;
  for (unsigned i = 0; i < 4; ++i) {
    const std::uint64_t value = values[i];
    const unsigned kind =
        unsigned{value >> 8 != 0} + unsigned{value >> 16 != 0} + unsigned{value >> 32 != 0};
    std::memcpy(at, &value, sizeof value);
    at += kind == 0 ? 1 : 2 * kind;
    all |= kind << 2 * i;
  }
  *lengths = static_cast<std::byte>(all);
  return at;
}
inline const std::byte* get_codes(const std::byte* at, std::array<std::uint64_t, 4>& values) {
  const auto all = static_cast<unsigned>(*at++);
  for (unsigned i = 0; i < 4; ++i) {
    const unsigned kind = all >> 2 * i & 3;
    const unsigned length = kind == 0 ? 1 : 2 * kind;
    std::memcpy(&values[i], at, sizeof values[i]);
    values[i] &= ~std::uint64_t{0} >> (64 - 8 * length);
    at += length;
  }
  return at;
}

}  // namespace remaps
