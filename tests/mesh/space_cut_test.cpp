#include "remaps/mesh/space_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace remaps {
namespace {

std::vector<Vec3f> random_points(std::size_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> coordinate(0, 1);
  std::vector<Vec3f> points(n);
  for (Vec3f& p : points) p = {3 * coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

TEST(SpaceCut, BalancesItsSample) {
  for (const unsigned level : {0u, 1u, 2u, 7u}) {
    for (const std::size_t segments : {1u, 2u, 3u, 17u, 100u}) {
      SCOPED_TRACE("level " + std::to_string(level) + ", segments " + std::to_string(segments));
      const std::vector<Vec3f> points = random_points(20'000, level + 1);
      std::vector<Vec3f> sample = points;
      const SpaceCut cut(sample, segments, level);
      ASSERT_EQ(cut.segments(), segments);
      std::vector<std::size_t> count(segments, 0);
      for (const Vec3f& p : points) {
        const std::uint32_t segment = cut.segment_of(p);
        ASSERT_LT(segment, segments);
        ++count[segment];
      }
      const double share = double(points.size()) / double(segments);
      for (const std::size_t c : count) EXPECT_NEAR(double(c), share, 10);
    }
  }
}

TEST(SpaceCut, DependsOnNothingButThePosition) {
  const std::vector<Vec3f> points = random_points(3000, 4);
  std::vector<Vec3f> a = points;
  std::vector<Vec3f> b = points;
  std::shuffle(b.begin(), b.end(), std::mt19937_64(5));
  const SpaceCut first(a, 11, 3);
  const SpaceCut second(b, 11, 3);
  for (const Vec3f& p : random_points(5000, 6)) {
    ASSERT_EQ(first.segment_of(p), second.segment_of(p));
    ASSERT_EQ(first.segment_of(p), SpaceCut(first).segment_of(p));
  }
}

TEST(SpaceCut, CutsLevelsDifferently) {
  // Two points on either side of a border should not be on either side of one in the next level.
  const std::vector<Vec3f> points = random_points(20'000, 7);
  std::vector<Vec3f> sample = points;
  const SpaceCut here(sample, 8, 2);
  sample = points;
  const SpaceCut next(sample, 8, 3);
  std::size_t cut_here = 0;
  std::size_t cut_twice = 0;
  for (const Vec3f& p : points) {
    const Vec3f q{p.x + 0.02f, p.y + 0.02f, p.z + 0.02f};
    if (here.segment_of(p) == here.segment_of(q)) continue;
    ++cut_here;
    cut_twice += next.segment_of(p) != next.segment_of(q);
  }
  EXPECT_GT(cut_here, 100u);
  EXPECT_LT(cut_twice, cut_here / 5);
}

TEST(SpaceCut, CoversAllSpaceWithTooSmallASample) {
  for (const std::size_t size : {0u, 1u, 3u}) {
    std::vector<Vec3f> sample = random_points(size, 8);
    const SpaceCut cut(sample, 9, 0);
    EXPECT_EQ(cut.segments(), 9u);
    for (const Vec3f& p : random_points(500, 9)) EXPECT_LT(cut.segment_of(p), 9u);
    EXPECT_LT(cut.segment_of({1e30f, -1e30f, 0}), 9u);
  }
}

TEST(SpaceCut, TakesPointsThatAreAllAlike) {
  std::vector<Vec3f> sample(1000, Vec3f{1, 2, 3});
  const SpaceCut cut(sample, 5, 1);
  EXPECT_LT(cut.segment_of({1, 2, 3}), 5u);
}

TEST(SpaceCut, IsOneSegmentUnlessToldOtherwise) {
  std::vector<Vec3f> sample = random_points(10, 1);
  EXPECT_EQ(SpaceCut().segments(), 1u);
  EXPECT_EQ(SpaceCut().segment_of({5, 6, 7}), 0u);
  EXPECT_EQ(SpaceCut(sample, 0, 0).segments(), 1u);
}

TEST(PositionSample, KeepsEveryKthOfTheStream) {
  for (const std::size_t capacity : {1u, 2u, 7u, 64u}) {
    for (const std::size_t n : {0u, 1u, 6u, 7u, 8u, 63u, 64u, 65u, 1000u}) {
      SCOPED_TRACE("capacity " + std::to_string(capacity) + ", n = " + std::to_string(n));
      PositionSample sample(capacity);
      for (std::size_t i = 0; i < n; ++i) sample.add({static_cast<float>(i), 0, 0});
      EXPECT_EQ(sample.seen(), n);
      const auto kept = sample.kept();
      if (n == 0) {
        EXPECT_TRUE(kept.empty());
        continue;
      }
      EXPECT_LE(kept.size(), capacity);
      if (n >= capacity) {
        EXPECT_GE(2 * kept.size() + 1, capacity);
      }
      const float stride = kept.size() > 1 ? kept[1].x : 1;
      EXPECT_EQ(std::exp2(std::round(std::log2(stride))), stride);
      for (std::size_t i = 0; i < kept.size(); ++i) {
        EXPECT_EQ(kept[i].x, stride * static_cast<float>(i));
      }
      if (kept.size() > 1) {
        EXPECT_GE(stride * static_cast<float>(kept.size()), static_cast<float>(n));
      }
    }
  }
}

}  // namespace
}  // namespace remaps
