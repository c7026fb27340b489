#include "remaps/base/simd.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace remaps {
namespace {

TEST(Simd, WorksLaneByLane) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> unit(-10, 10);
  for (int round = 0; round < 1000; ++round) {
    Float4 a, b;
    for (unsigned i = 0; i < kLanes; ++i) {
      a[i] = unit(random);
      b[i] = random() % 4 == 0 ? a[i] : unit(random);
    }
    const unsigned bits = at_most4(a, b);
    for (unsigned i = 0; i < kLanes; ++i) {
      EXPECT_EQ(min4(a, b)[i], std::min(a[i], b[i]));
      EXPECT_EQ(max4(a, b)[i], std::max(a[i], b[i]));
      EXPECT_EQ(abs4(a)[i], std::fabs(a[i]));
      EXPECT_EQ(round4(a)[i], std::nearbyint(a[i]));
      EXPECT_EQ(select4(a < b, a, b)[i], a[i] < b[i] ? a[i] : b[i]);
      EXPECT_EQ(bits >> i & 1, unsigned{a[i] <= b[i]});
    }
    EXPECT_EQ(least_lane(a), std::min({a[0], a[1], a[2], a[3]}));
    EXPECT_EQ(largest_lane(a), std::max({a[0], a[1], a[2], a[3]}));
  }
}

TEST(Simd, TransposesRowsAndColumns) {
  std::array<Float4, 4> row;
  for (unsigned i = 0; i < 4; ++i) {
    for (unsigned j = 0; j < 4; ++j) row[i][j] = static_cast<float>(4 * i + j);
  }
  transpose4(row[0], row[1], row[2], row[3]);
  for (unsigned i = 0; i < 4; ++i) {
    for (unsigned j = 0; j < 4; ++j) EXPECT_EQ(row[i][j], static_cast<float>(4 * j + i));
  }
}

TEST(Simd, TellsSidesOfPointsInHalvesOfWords) {
  std::mt19937_64 random(2);
  std::uniform_int_distribution<int> grid(-16383, 16383);
  std::uniform_real_distribution<double> real(-16383, 16383);
  for (int round = 0; round < 1000; ++round) {
    const double ax = grid(random) / 2, ay = grid(random) / 2, dx = real(random), dy = real(random);
    std::array<std::uint32_t, 4> words;
    std::array<int, 4> x, y;
    for (unsigned i = 0; i < kLanes; ++i) {
      x[i] = i == 0 ? static_cast<int>(ax) : grid(random);  // the first lies on the line
      y[i] = i == 0 ? static_cast<int>(ay) : grid(random);
      words[i] = static_cast<std::uint16_t>(x[i]) | std::uint32_t{static_cast<std::uint16_t>(y[i])}
                                                        << 16;
    }
    const double least = 1e6;
    const double error = 512;
    const SignMasks masks =
        signs_of_cross(load4(words.data()), static_cast<float>(ax), static_cast<float>(ay),
                       static_cast<float>(dx), static_cast<float>(dy), static_cast<float>(least));
    for (unsigned i = 0; i < kLanes; ++i) {
      const double value = (x[i] - ax) * dy - (y[i] - ay) * dx;
      if (std::fabs(value - least) > error) {
        EXPECT_EQ(masks.positive >> i & 1, unsigned{value > least});
      }
      if (std::fabs(std::fabs(value) - least) > error) {
        EXPECT_EQ(masks.near >> i & 1, unsigned{std::fabs(value) <= least});
      }
    }
    EXPECT_EQ(masks.near & 1, 1u);
  }
}

}  // namespace
}  // namespace remaps
