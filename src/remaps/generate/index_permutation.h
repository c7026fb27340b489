#pragma once

#include <cstdint>

namespace remaps {

/// A pseudo-random permutation of [0, size) that is computed, not stored.
///
/// A Feistel network permutes the smallest power of two that holds the range, and a value that
/// falls outside is permuted again until it is inside ("cycle walking"): less than two rounds on
/// average. Source: Black, Rogaway, Ciphers with Arbitrary Finite Domains, CT-RSA 2002.
class IndexPermutation {
 public:
  IndexPermutation(std::uint64_t size, std::uint64_t seed);

  /// Where index goes. index < size.
  std::uint64_t forward(std::uint64_t index) const;
  /// Where index came from: inverse(forward(i)) == i. index < size.
  std::uint64_t inverse(std::uint64_t index) const;

 private:
  std::uint64_t encrypt(std::uint64_t value) const;
  std::uint64_t decrypt(std::uint64_t value) const;

  std::uint64_t size_;
  std::uint64_t seed_;
  int low_bits_;
  std::uint64_t low_mask_;
  std::uint64_t high_mask_;
};

}  // namespace remaps
