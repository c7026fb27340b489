#include "remaps/base/time_left.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace remaps {
namespace {

TEST(TimeLeft, SaysNothingBeforeThereIsASpeed) {
  EXPECT_FALSE(time_left(0.5, 0.9, 0.9, std::nullopt).phase);
  EXPECT_FALSE(time_left(0.001, 10, 10, std::nullopt).phase);
  EXPECT_FALSE(time_left(0, 10, 10, RunShares{0, 1, 1}).run);
  EXPECT_FALSE(time_left(0.5, 5, 10, std::nullopt).run);
}

TEST(TimeLeft, GoesOnAsFastAsThePhaseHasBeen) {
  const TimeLeft left = time_left(0.25, 10, 10, std::nullopt);
  ASSERT_TRUE(left.phase);
  EXPECT_DOUBLE_EQ(*left.phase, 30);
}

TEST(TimeLeft, ScalesWeightsByTheTimeOfWhatIsDone) {
  // Weights 10, 20 and 30; the first took 5 s, the second is half over after another 5.
  const TimeLeft left = time_left(0.5, 5, 10, RunShares{10, 20, 30});
  ASSERT_TRUE(left.phase && left.run);
  EXPECT_DOUBLE_EQ(*left.phase, 5);
  EXPECT_DOUBLE_EQ(*left.run, 5 + 30 * 10 / 20.0);
}

TEST(TimeLeft, TrustsTheWeightOfAPhaseThatReportsNothing) {
  const TimeLeft left = time_left(0, 3, 13, RunShares{10, 5, 20});
  ASSERT_TRUE(left.phase && left.run);
  EXPECT_DOUBLE_EQ(*left.phase, 2);
  EXPECT_DOUBLE_EQ(*left.run, 22);
  EXPECT_DOUBLE_EQ(*time_left(0, 9, 19, RunShares{10, 5, 20}).phase, 0);
}

/// A run whose phases take what their weights say, in another unit: the time left is right all the
/// way.
TEST(TimeLeft, IsExactWhereWeightsAre) {
  const std::vector<double> weights = {3, 40, 8, 20};
  constexpr double kSecondsPerWeight = 1.7;
  double done = 0;
  double all = 0;
  for (const double w : weights) all += w;
  for (const double w : weights) {
    for (double fraction = 0; fraction < 1; fraction += 0.03) {
      const RunShares shares{done, w, all - done - w};
      const double phase = fraction * w * kSecondsPerWeight;
      const double total = done * kSecondsPerWeight + phase;
      const TimeLeft left = time_left(fraction, phase, total, shares);
      if (total < 2) continue;
      ASSERT_TRUE(left.run) << done << ' ' << fraction;
      EXPECT_NEAR(*left.run, all * kSecondsPerWeight - total, 1e-9);
    }
    done += w;
  }
}

}  // namespace
}  // namespace remaps
