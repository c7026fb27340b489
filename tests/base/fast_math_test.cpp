#include "remaps/base/fast_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace remaps {
namespace {

TEST(FastMath, LogarithmsAreGoodToAMillionth) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-900, 900);
  for (int i = 0; i < 100'000; ++i) {
    const double x = std::exp2(exponent(random));
    ASSERT_NEAR(fast_log2(x), std::log2(x), 1e-6) << x;
  }
  EXPECT_EQ(fast_log2(1), 0);
}

TEST(FastMath, FourLogarithmsAreGoodToAMillionth) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> exponent(-8, 8);
  for (int i = 0; i < 100'000; ++i) {
    const float x = std::exp2(exponent(random));
    const Float4 value = fast_log2(Float4{x, 1 / x, 2 * x, 1});
    ASSERT_NEAR(value[0], std::log2(double(x)), 1.5e-6) << x;
    ASSERT_NEAR(value[1], std::log2(double(1 / x)), 1.5e-6) << x;
    ASSERT_NEAR(value[2], std::log2(2 * double(x)), 1.5e-6) << x;
    ASSERT_EQ(value[3], 0);
    ASSERT_NEAR(rough_log2(x), std::log2(x), 0.09) << x;
  }
}

TEST(FastMath, FourPowersOfTwoAreGoodToFiveMillionths) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<float> exponent(-100, 100);
  for (int i = 0; i < 100'000; ++i) {
    const float x = exponent(random);
    const Float4 value = fast_exp2(Float4{x, -x, 0, 1});
    ASSERT_NEAR(value[0] / std::exp2(double(x)), 1, 5e-6) << x;
    ASSERT_NEAR(value[1] / std::exp2(-double(x)), 1, 5e-6) << x;
    ASSERT_EQ(value[2], 1);
    ASSERT_EQ(value[3], 2);
  }
}

TEST(FastMath, FourAnglesAreGoodToAMillionth) {
  for (int i = 0; i <= 100'000; ++i) {
    const double angle = M_PI * i / 100'000;
    const auto x = static_cast<float>(3 * std::cos(angle));
    const auto y = static_cast<float>(std::max(0.0, 3 * std::sin(angle)));
    const Float4 value = fast_angle(Float4{x, 0, -1, 1}, Float4{y, 0, 0, 0});
    ASSERT_NEAR(value[0], angle, 1e-6);
    ASSERT_EQ(value[1], 0);
    ASSERT_NEAR(value[2], M_PI, 1e-6);
    ASSERT_EQ(value[3], 0);
  }
}

TEST(FastMath, FourSinesAndCosinesAreGoodToTwoMillionths) {
  for (int i = -50'000; i <= 50'000; ++i) {
    const float angle = 1e-3f * static_cast<float>(i);
    const SineCosine4 value = fast_sine_cosine(Float4{0, angle, 0, -angle});
    ASSERT_NEAR(value.sine[1], std::sin(double(angle)), 2e-6) << angle;
    ASSERT_NEAR(value.cosine[1], std::cos(double(angle)), 2e-6) << angle;
    ASSERT_EQ(value.sine[3], -value.sine[1]);
    ASSERT_EQ(value.cosine[3], value.cosine[1]);
  }
}

}  // namespace
}  // namespace remaps
