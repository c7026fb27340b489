#include "remaps/generate/index_permutation.h"

#include <algorithm>
#include <bit>

#include "remaps/generate/hash_mix.h"

namespace remaps {
namespace {

constexpr std::uint64_t kRounds = 4;

}  // namespace

IndexPermutation::IndexPermutation(std::uint64_t size, std::uint64_t seed)
    : size_(size), seed_(seed) {
  const int bits = std::max(2, static_cast<int>(std::bit_width(size == 0 ? 0 : size - 1)));
  low_bits_ = bits / 2;
  low_mask_ = (std::uint64_t{1} << low_bits_) - 1;
  high_mask_ = (std::uint64_t{1} << (bits - low_bits_)) - 1;
}

std::uint64_t IndexPermutation::forward(std::uint64_t index) const {
  do index = encrypt(index);
  while (index >= size_);
  return index;
}

std::uint64_t IndexPermutation::inverse(std::uint64_t index) const {
  do index = decrypt(index);
  while (index >= size_);
  return index;
}

std::uint64_t IndexPermutation::encrypt(std::uint64_t value) const {
  std::uint64_t low = value & low_mask_;
  std::uint64_t high = value >> low_bits_;
  for (std::uint64_t round = 0; round < kRounds; ++round) {
    low ^= mix_bits(seed_ + 2 * round + (high << 8)) & low_mask_;
    high ^= mix_bits(seed_ + 2 * round + 1 + (low << 8)) & high_mask_;
  }
  return low | (high << low_bits_);
}

std::uint64_t IndexPermutation::decrypt(std::uint64_t value) const {
  std::uint64_t low = value & low_mask_;
  std::uint64_t high = value >> low_bits_;
  for (std::uint64_t round = kRounds; round-- > 0;) {
    high ^= mix_bits(seed_ + 2 * round + 1 + (low << 8)) & high_mask_;
    low ^= mix_bits(seed_ + 2 * round + (high << 8)) & low_mask_;
  }
  return low | (high << low_bits_);
}

}  // namespace remaps
