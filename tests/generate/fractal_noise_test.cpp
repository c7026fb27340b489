#include "remaps/generate/fractal_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace remaps {
namespace {

TEST(FractalNoise, StaysWithinOneAndHasMeanZero) {
  const FractalNoise noise(5, 8, 0.5);
  constexpr int kSamples = 200'000;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double value = noise({0.37 * i, -0.11 * i, std::sin(i)});
    ASSERT_LE(std::abs(value), 1);
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / kSamples, 0, 0.01);
  EXPECT_GT(std::sqrt(squares / kSamples), 0.1);
}

TEST(FractalNoise, IsContinuousAcrossLatticeCells) {
  const FractalNoise noise(6, 3, 0.5);
  for (int i = -2000; i < 2000; ++i) {
    const Vec3 p{i / 512.0, i / 256.0, -i / 128.0};
    EXPECT_NEAR(noise(p), noise(p + Vec3{1e-9, -1e-9, 1e-9}), 1e-7);
  }
}

TEST(FractalNoise, DependsOnTheSeed) {
  const Vec3 p{0.3, 0.4, 0.5};
  EXPECT_NE(FractalNoise(1, 4, 0.5)(p), FractalNoise(2, 4, 0.5)(p));
  EXPECT_EQ(FractalNoise(1, 4, 0.5)(p), FractalNoise(1, 4, 0.5)(p));
}

}  // namespace
}  // namespace remaps
