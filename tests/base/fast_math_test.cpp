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

TEST(FastMath, PowersOfTwoAreGoodToAMillionth) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> exponent(-600, 100);
  for (int i = 0; i < 100'000; ++i) {
    const double x = exponent(random);
    ASSERT_NEAR(fast_exp2(x) / std::exp2(x), 1, 1e-6) << x;
  }
  EXPECT_EQ(fast_exp2(0), 1);
}

TEST(FastMath, AnglesAreGoodToATenMillionth) {
  for (int i = 0; i <= 100'000; ++i) {
    const double angle = M_PI * i / 100'000;
    const double y = std::max(0.0, 3 * std::sin(angle));
    ASSERT_NEAR(fast_angle(3 * std::cos(angle), y), angle, 1e-7);
  }
  EXPECT_EQ(fast_angle(0, 0), 0);
}

TEST(FastMath, SinesAndCosinesAreGoodToAMillionth) {
  for (int i = -50'000; i <= 50'000; ++i) {
    const double angle = 1e-3 * i;
    const SineCosine value = fast_sine_cosine(angle);
    ASSERT_NEAR(value.sine, std::sin(angle), 1e-6) << angle;
    ASSERT_NEAR(value.cosine, std::cos(angle), 1e-6) << angle;
  }
}

}  // namespace
}  // namespace remaps
