#include "remaps/generate/index_permutation.h"

#include <gtest/gtest.h>

#include <vector>

namespace remaps {
namespace {

TEST(IndexPermutation, TakesEveryIndexOnce) {
  for (const std::uint64_t size : {1u, 2u, 3u, 4u, 5u, 7u, 8u, 9u, 63u, 64u, 65u, 1000u, 4097u}) {
    const IndexPermutation permutation(size, 7);
    std::vector<bool> seen(size);
    for (std::uint64_t i = 0; i < size; ++i) {
      const std::uint64_t image = permutation.forward(i);
      ASSERT_LT(image, size);
      ASSERT_FALSE(seen[image]) << size << " " << i;
      seen[image] = true;
      ASSERT_EQ(permutation.inverse(image), i);
    }
  }
}

TEST(IndexPermutation, InvertsBeyond32Bits) {
  const std::uint64_t size = 5'000'000'000'000u;
  const IndexPermutation permutation(size, 99);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const std::uint64_t index = i * (size / 1000);
    ASSERT_LT(permutation.forward(index), size);
    ASSERT_EQ(permutation.inverse(permutation.forward(index)), index);
  }
}

TEST(IndexPermutation, LeavesNeighboursApart) {
  const std::uint64_t size = 1'000'000;
  const IndexPermutation permutation(size, 3);
  double sum = 0;
  for (std::uint64_t i = 0; i + 1 < 1000; ++i) {
    const auto a = static_cast<double>(permutation.forward(i));
    const auto b = static_cast<double>(permutation.forward(i + 1));
    sum += std::abs(a - b) / static_cast<double>(size);
  }
  EXPECT_NEAR(sum / 999, 1.0 / 3, 0.03);
}

}  // namespace
}  // namespace remaps
