#include "remaps/base/progress.h"

#include <gtest/gtest.h>

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

TEST(Progress, NeedsNoListener) {
  Progress progress;
  EXPECT_NO_THROW(progress.begin("quiet"));
  EXPECT_NO_THROW(progress.advance(1));
}

}  // namespace
}  // namespace remaps
