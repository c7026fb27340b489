#include "remaps/simplify/flatten.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace remaps::simplify {
namespace {

constexpr double kPi = std::numbers::pi;

/// A star of some shape: a cone or saddle with uneven spokes.
std::vector<Vec3> random_star(std::mt19937_64& random, bool boundary, unsigned n) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double span = boundary ? kPi * (0.5 + unit(random)) : 2 * kPi;
  const double uneven = unit(random);
  const double height = 2 * unit(random) - 1;
  std::vector<Vec3> offsets;
  for (unsigned i = 0; i < n; ++i) {
    const double steps = boundary ? n - 1 : n;
    const double angle = span * (i + 0.4 * unit(random)) / steps;
    const double r = 1 - 0.6 * uneven * unit(random);
    offsets.push_back(
        {r * std::cos(angle), r * std::sin(angle), height * r * (0.5 + unit(random))});
  }
  return offsets;
}

double angle_of(GridPoint p) {
  const double angle = std::atan2(double(p.y), double(p.x));
  return angle < -1e-9 ? angle + 2 * kPi : angle;
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(dot(a, b) / (norm(a) * norm(b)), -1.0, 1.0));
}

class FlattenStar : public testing::TestWithParam<bool> {
 protected:
  bool boundary() const { return GetParam(); }
  unsigned wedges(std::size_t n) const { return static_cast<unsigned>(n) - (boundary() ? 1 : 0); }
};

TEST_P(FlattenStar, GivesPositiveWedgesOnTheGrid) {
  std::mt19937_64 random(1);
  constexpr double kFloor = 0.0005;
  int flattened = 0;
  for (int round = 0; round < 3000; ++round) {
    const auto n = static_cast<unsigned>(3 + random() % 11);
    const std::vector<Vec3> offsets = random_star(random, boundary(), n);
    FlatStar star;
    if (!flatten_star(offsets, boundary(), kFloor, star)) continue;
    ++flattened;
    ASSERT_EQ(star.ring_size(), n);
    ASSERT_EQ(star.wedges, wedges(n));
    ASSERT_EQ(star.boundary, boundary());
    double largest = 0;
    for (unsigned i = 0; i < n; ++i) {
      largest = std::max(largest, std::hypot(double(star.ring[i].x), double(star.ring[i].y)));
    }
    ASSERT_NEAR(largest, kGridRadius, 1.5);
    for (unsigned i = 0; i < star.wedges; ++i) {
      ASSERT_GT(orientation(star.ring[i], star.ring[(i + 1) % n]), 0) << "round " << round;
      ASSERT_GE(planar_shape({}, star.ring[i], star.ring[(i + 1) % n]), kFloor);
    }
  }
  EXPECT_GT(flattened, 2000);
}

TEST_P(FlattenStar, ScalesAnglesAndPowersRadii) {
  std::mt19937_64 random(2);
  for (int round = 0; round < 500; ++round) {
    const auto n = static_cast<unsigned>(4 + random() % 8);
    const std::vector<Vec3> offsets = random_star(random, boundary(), n);
    FlatStar star;
    if (!flatten_star(offsets, boundary(), 0.01, star)) continue;
    double total = 0;
    for (unsigned i = 0; i < star.wedges; ++i) {
      total += angle_between(offsets[i], offsets[(i + 1) % n]);
    }
    const double power = (boundary() ? 1 : 2) * kPi / total;
    double angle = 0;
    for (unsigned i = 0; i < n; ++i) {
      const double r = std::hypot(double(star.ring[i].x), double(star.ring[i].y));
      const double r0 = std::hypot(double(star.ring[0].x), double(star.ring[0].y));
      const double off = std::remainder(angle_of(star.ring[i]) - power * angle, 2 * kPi);
      EXPECT_NEAR(off, 0, 2 / r) << "round " << round;
      const double expected = std::pow(norm(offsets[i]) / norm(offsets[0]), power);
      EXPECT_NEAR(r / r0, expected, 2 * (1 + expected) / r0) << "round " << round;
      if (i < star.wedges) angle += angle_between(offsets[i], offsets[(i + 1) % n]);
    }
  }
}

TEST_P(FlattenStar, DoesNotDependOnTheUnit) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 500; ++round) {
    const auto n = static_cast<unsigned>(4 + random() % 8);
    const std::vector<Vec3> offsets = random_star(random, boundary(), n);
    FlatStar star;
    if (!flatten_star(offsets, boundary(), 0.01, star)) continue;
    for (const double scale : {1e-20, 1e-3, 7.0, 1e20}) {
      std::vector<Vec3> scaled;
      for (const Vec3& p : offsets) scaled.push_back(scale * p);
      FlatStar other;
      ASSERT_TRUE(flatten_star(scaled, boundary(), 0.009, other));
      for (unsigned i = 0; i < n; ++i) {
        EXPECT_LE(std::abs(star.ring[i].x - other.ring[i].x), 1);
        EXPECT_LE(std::abs(star.ring[i].y - other.ring[i].y), 1);
      }
    }
  }
}

TEST_P(FlattenStar, RefusesDegenerateStars) {
  std::mt19937_64 random(4);
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FlatStar star;
  const std::vector<Vec3> good = random_star(random, boundary(), 6);
  ASSERT_TRUE(flatten_star(good, boundary(), 0.0005, star));
  for (const Vec3& bad :
       {Vec3{0, 0, 0}, Vec3{infinity, 0, 0}, Vec3{0, nan, 0}, Vec3{1e200, 0, 0}}) {
    for (std::size_t i = 0; i < good.size(); ++i) {
      std::vector<Vec3> offsets = good;
      offsets[i] = bad;
      EXPECT_FALSE(flatten_star(offsets, boundary(), 0.0005, star)) << i;
    }
  }
  std::vector<Vec3> twice = good;
  twice[2] = 0.5 * twice[1];  // a wedge without an angle
  EXPECT_FALSE(flatten_star(twice, boundary(), 0.0005, star));
  const std::vector<Vec3> needle(5, Vec3{1, 0, 0});
  EXPECT_FALSE(flatten_star(needle, boundary(), 0, star));
}

INSTANTIATE_TEST_SUITE_P(Places, FlattenStar, testing::Bool(),
                         [](const auto& test) { return test.param ? "Boundary" : "Interior"; });

TEST(FlattenStar, PutsBoundaryEdgesOnOneLine) {
  std::mt19937_64 random(5);
  for (int round = 0; round < 1000; ++round) {
    const auto n = static_cast<unsigned>(3 + random() % 11);
    FlatStar star;
    if (!flatten_star(random_star(random, true, n), true, 0.0005, star)) continue;
    ASSERT_EQ(star.ring[0].y, 0);
    ASSERT_EQ(star.ring[n - 1].y, 0);
    ASSERT_GT(star.ring[0].x, 0);
    ASSERT_LT(star.ring[n - 1].x, 0);
    for (unsigned i = 1; i + 1 < n; ++i) ASSERT_GT(star.ring[i].y, 0);
  }
}

TEST(FlattenStar, PutsACreaseOnOneLineWithHalfATurnOnEachSide) {
  std::mt19937_64 random(7);
  int flattened = 0;
  for (int round = 0; round < 3000; ++round) {
    const auto n = static_cast<unsigned>(4 + random() % 10);
    const std::vector<Vec3> offsets = random_star(random, false, n);
    const auto from = static_cast<unsigned>(random() % (n - 2));
    const auto to = static_cast<unsigned>(from + 2 + random() % (n - from - 2));
    if (from == 0 && to == n - 1) continue;  // one wedge cannot take half a turn
    FlatStar star;
    if (!flatten_star(offsets, false, 0.0005, star, {from, to})) continue;
    ++flattened;
    ASSERT_EQ(star.ring_size(), n);
    ASSERT_FALSE(star.boundary);
    ASSERT_EQ(star.ring[from].y, 0);
    ASSERT_EQ(star.ring[to].y, 0);
    ASSERT_GT(star.ring[from].x, 0);
    ASSERT_LT(star.ring[to].x, 0);
    double side[2] = {0, 0};
    for (unsigned i = 0; i < n; ++i) {
      ASSERT_GT(orientation(star.ring[i], star.ring[(i + 1) % n]), 0);
      const bool first = i >= from && i < to;
      side[first ? 0 : 1] += angle_between(offsets[i], offsets[(i + 1) % n]);
      if (i != from && i != to) {
        ASSERT_EQ(star.ring[i].y > 0, first);
      }
    }
    double angle = 0;
    for (unsigned step = 0; step < n; ++step) {
      const unsigned i = (from + step) % n;
      const double r = std::hypot(double(star.ring[i].x), double(star.ring[i].y));
      EXPECT_NEAR(std::remainder(angle_of(star.ring[i]) - angle, 2 * kPi), 0, 2 / r);
      const double wedge = angle_between(offsets[i], offsets[(i + 1) % n]);
      angle += kPi * wedge / side[i >= from && i < to ? 0 : 1];
    }
  }
  EXPECT_GT(flattened, 1000);
  FlatStar star;
  EXPECT_FALSE(flatten_star(random_star(random, false, 6), false, 0.0005, star, {2, 3}));
}

TEST(FlattenStar, KeepsAPlanarHexagon) {
  std::vector<Vec3> offsets;
  for (int i = 0; i < 6; ++i) offsets.push_back({std::cos(i * kPi / 3), std::sin(i * kPi / 3), 0});
  FlatStar star;
  ASSERT_TRUE(flatten_star(offsets, false, 0.5, star));
  for (unsigned i = 0; i < 6; ++i) {
    EXPECT_NEAR(star.ring[i].x, kGridRadius * std::cos(i * kPi / 3), 0.6);
    EXPECT_NEAR(star.ring[i].y, kGridRadius * std::sin(i * kPi / 3), 0.6);
  }
}

TEST(PlanarShape, MeasuresAreaAgainstTheLongestEdge) {
  EXPECT_NEAR(planar_shape({0, 0}, {16000, 0}, {8000, 13856}), 0.866, 0.001);
  EXPECT_EQ(planar_shape({0, 0}, {100, 0}, {100, 100}), 0.5);
  EXPECT_EQ(planar_shape({0, 0}, {100, 100}, {100, 0}), -0.5);
  EXPECT_EQ(planar_shape({0, 0}, {100, 0}, {200, 0}), 0);
  EXPECT_EQ(planar_shape({5, 5}, {5, 5}, {5, 5}), 0);
}

TEST(FanIsValid, AcceptsExactlyTheFansOfPositiveTriangles) {
  std::mt19937_64 random(6);
  for (int round = 0; round < 2000; ++round) {
    const auto n = static_cast<unsigned>(4 + random() % 6);
    FlatStar star;
    const bool boundary = random() % 2 == 0;
    if (!flatten_star(random_star(random, boundary, n), boundary, 0.0005, star)) continue;
    for (unsigned apex = 0; apex < n; ++apex) {
      double least = 1;
      for (unsigned j = 1; j + 1 < n; ++j) {
        least = std::min(least, planar_shape(star.ring[apex], star.ring[(apex + j) % n],
                                             star.ring[(apex + j + 1) % n]));
      }
      for (const double floor : {0.002, 0.05}) {
        ASSERT_EQ(fan_is_valid(star, apex, floor), least >= floor);
      }
    }
  }
}

}  // namespace
}  // namespace remaps::simplify
