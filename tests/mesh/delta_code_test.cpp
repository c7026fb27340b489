#include "remaps/mesh/delta_code.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace remaps {
namespace {

constexpr std::uint64_t kIds = std::uint64_t{1} << 39;

TEST(DeltaCode, TurnsStepsOfBothSignsIntoSmallNumbersAndBack) {
  EXPECT_EQ(delta_code(5, 5), 0u);
  EXPECT_EQ(delta_code(4, 5), 1u);
  EXPECT_EQ(delta_code(6, 5), 2u);
  for (const std::uint64_t from : {std::uint64_t{0}, std::uint64_t{77}, kIds / 2, kIds - 1}) {
    for (const std::uint64_t to : {std::uint64_t{0}, std::uint64_t{78}, kIds / 2, kIds - 1}) {
      EXPECT_LT(delta_code(to, from), 2 * kIds);
      EXPECT_EQ(apply_delta(delta_code(to, from), from), to);
    }
  }
}

TEST(DeltaCode, DecodesWhatItEncodesAtEveryLength) {
  constexpr unsigned kSeed = 9;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::vector<std::array<std::uint64_t, 4>> codes(5000);
  std::vector<std::byte> bytes(codes.size() * 35 + 16);
  std::byte* end = bytes.data();
  for (auto& four : codes) {
    for (std::uint64_t& value : four) value = random() >> (16 + random() % 48);
    end = put_codes(end, four);
    end = put_varint(end, four[0]);
  }
  const std::byte* at = bytes.data();
  for (const auto& four : codes) {
    std::array<std::uint64_t, 4> back{};
    std::uint64_t first = 0;
    at = get_codes(at, back);
    at = get_varint(at, first);
    ASSERT_EQ(back, four);
    ASSERT_EQ(first, four[0]);
  }
  EXPECT_EQ(at, end);
}

}  // namespace
}  // namespace remaps
