#pragma once

#include <cstdint>

namespace remaps {

/// A bijective mix of 64 bits: neighbouring keys give unrelated values.
/// Source: the finalizer of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), Stafford's constants.
constexpr std::uint64_t mix_bits(std::uint64_t key) {
  key += 0x9E3779B97F4A7C15u;
  key = (key ^ (key >> 30)) * 0xBF58476D1CE4E5B9u;
  key = (key ^ (key >> 27)) * 0x94D049BB133111EBu;
  return key ^ (key >> 31);
}

/// A hash of a key under a seed; different seeds give unrelated functions.
constexpr std::uint64_t hash_key(std::uint64_t seed, std::uint64_t key) {
  return mix_bits(seed ^ mix_bits(key));
}

/// The upper 53 bits of a hash as a number in [0, 1).
constexpr double unit_interval(std::uint64_t hash) {
  return static_cast<double>(hash >> 11) * 0x1p-53;
}

}  // namespace remaps
