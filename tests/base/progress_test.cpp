#include "remaps/base/progress.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace remaps {
namespace {

TEST(Progress, ReportsThePhaseWithEachFraction) {
  std::vector<std::pair<std::string, double>> heard;
  Progress progress(
      [&](std::string_view phase, double fraction) { heard.emplace_back(phase, fraction); });
  progress.begin("read");
  progress.advance(0.5);
  progress.begin("write");
  const std::vector<std::pair<std::string, double>> expected{
      {"read", 0}, {"read", 0.5}, {"write", 0}};
  EXPECT_EQ(heard, expected);
}

TEST(Progress, ThrowsFromEveryCheckOnceCancelled) {
  int heard = 0;
  Progress progress([&](std::string_view, double) { ++heard; });
  EXPECT_NO_THROW(progress.check());
  EXPECT_FALSE(progress.cancelled());
  progress.cancel();
  EXPECT_TRUE(progress.cancelled());
  EXPECT_THROW(progress.check(), Cancelled);
  EXPECT_THROW(progress.begin("read"), Cancelled);
  EXPECT_THROW(progress.advance(0.5), Cancelled);
  EXPECT_EQ(heard, 0);
}

TEST(Progress, ReportsPartsAsTheirShareOfThePhase) {
  std::vector<double> heard;
  Progress progress([&](std::string_view, double fraction) { heard.push_back(fraction); });
  progress.begin("read");
  {
    const ProgressPart first(&progress, 0, 0.5);
    progress.advance(0.5);
    progress.advance(1);
  }
  {
    const ProgressPart second(&progress, 0.5, 1);
    progress.advance(0.5);
    const ProgressPart inner(&progress, 0.5, 0.75);
    progress.advance(0);
    progress.advance(1);
  }
  progress.advance(1);
  EXPECT_EQ(heard, (std::vector<double>{0, 0.25, 0.5, 0.75, 0.75, 0.875, 1}));
  const ProgressPart of_none(nullptr, 0, 0.5);
}

void expect_shares(const Progress& progress, double done, double present, double later) {
  const std::optional<RunShares> shares = progress.run();
  ASSERT_TRUE(shares);
  EXPECT_DOUBLE_EQ(shares->done, done);
  EXPECT_DOUBLE_EQ(shares->present, present);
  EXPECT_DOUBLE_EQ(shares->later, later);
}

TEST(Progress, KnowsHowFarARunIsByItsPlan) {
  Progress progress;
  EXPECT_FALSE(progress.run());
  progress.plan({{"read", 1}, {"sweep 1", 10}, {"sweep 2", 5}, {"map", 3}, {"write", 2}});
  expect_shares(progress, 0, 0, 21);
  progress.begin("read");
  expect_shares(progress, 0, 1, 20);
  progress.begin("sweep 1");
  progress.advance(0.5);
  progress.begin("sweep 1");  // again: it is the same phase
  expect_shares(progress, 1, 10, 10);
  progress.begin("map");  // there was no second sweep
  expect_shares(progress, 11, 3, 2);
  progress.begin("rest");  // nobody planned this one
  expect_shares(progress, 14, 0, 2);
  progress.begin("write");
  expect_shares(progress, 14, 2, 0);
}

TEST(Progress, TakesAPlanForPartOfWhatIsToCome) {
  Progress progress;
  progress.plan({{"write", 2}, {"measure", 4}});
  progress.plan({{"sweep 1", 10}, {"map", 3}});  // knows neither: they come before
  progress.plan({{"read", 1}});
  expect_shares(progress, 0, 0, 20);
  progress.begin("read");
  progress.plan({{"sweep 1", 20}, {"sweep 2", 2}, {"map", 6}});  // what is behind "map" stays
  expect_shares(progress, 0, 1, 34);
  progress.plan({});
  expect_shares(progress, 0, 1, 34);
  progress.begin("measure");
  expect_shares(progress, 1, 4, 0);
}

TEST(Progress, NeedsNoListener) {
  Progress progress;
  EXPECT_NO_THROW(progress.begin("quiet"));
  EXPECT_NO_THROW(progress.advance(1));
}

}  // namespace
}  // namespace remaps
