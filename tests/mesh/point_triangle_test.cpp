#include "remaps/mesh/point_triangle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace remaps {
namespace {

Vec3 point_of(const TrianglePositions& t, const std::array<double, 3>& w) {
  return w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
}

/// The least squared distance to a fine grid of points of the triangle, the corners included.
double grid_distance2(const Vec3& p, const TrianglePositions& t, int n) {
  double least = norm2(p - t[0]);
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      const double v = double(i) / n, w = double(j) / n;
      least = std::min(least, norm2(p - point_of(t, {1 - v - w, v, w})));
    }
  }
  return least;
}

TEST(PointTriangle, AnswersInEveryRegion) {
  const TrianglePositions t{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}};
  const auto distance2 = [&](Vec3 p) { return closest_point_on_triangle(p, t).distance2; };
  EXPECT_DOUBLE_EQ(distance2({0.5, 0.5, 3}), 9);
  EXPECT_DOUBLE_EQ(distance2({-1, -1, 0}), 2);
  EXPECT_DOUBLE_EQ(distance2({3, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(distance2({0, 4, 1}), 5);
  EXPECT_DOUBLE_EQ(distance2({1, -2, 0}), 4);
  EXPECT_DOUBLE_EQ(distance2({-2, 1, 0}), 4);
  EXPECT_DOUBLE_EQ(distance2({2, 2, 0}), 2);
  EXPECT_EQ(closest_point_on_triangle({3, 0, 0}, t).weights, (std::array{0.0, 1.0, 0.0}));
}

TEST(PointTriangle, IsExactAtCorners) {
  const TrianglePositions t{{{0.1, 0.7, 0.3}, {2.3, -0.1, 0.9}, {0.4, 1.9, -5.1}}};
  for (const Vec3& corner : t) EXPECT_EQ(closest_point_on_triangle(corner, t).distance2, 0);
}

TEST(PointTriangle, IsNeverFurtherThanAFineGridOnTriangles) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto any = [&] { return Vec3{coordinate(random), coordinate(random), coordinate(random)}; };
  for (int round = 0; round < 300; ++round) {
    TrianglePositions t{any(), any(), any()};
    const double flat = std::pow(10.0, -round % 18);  // from round triangles to needles and caps
    if (round % 2 == 0) t[2] = t[0] + 0.4 * (t[1] - t[0]) + flat * (t[2] - t[0]);
    if (round % 3 == 0) t[1] = t[0] + flat * (t[1] - t[0]);
    const Vec3 p = any();
    const TrianglePoint found = closest_point_on_triangle(p, t);
    const double grid2 = grid_distance2(p, t, 60);
    EXPECT_LE(found.distance2, grid2 * (1 + 1e-9)) << round;
    EXPECT_GE(std::sqrt(found.distance2), std::sqrt(grid2) - 3.5 / 60) << round;
    EXPECT_NEAR(norm2(p - point_of(t, found.weights)), found.distance2, 1e-12) << round;
    for (const double weight : found.weights) EXPECT_GE(weight, 0) << round;
  }
}

TEST(PointTriangle, GivesTheDistanceAloneAsWell) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto any = [&] { return Vec3{coordinate(random), coordinate(random), coordinate(random)}; };
  for (int round = 0; round < 20'000; ++round) {
    TrianglePositions t{any(), any(), any()};
    const double flat = std::pow(10.0, -round % 18);
    if (round % 2 == 0) t[2] = t[0] + 0.4 * (t[1] - t[0]) + flat * (t[2] - t[0]);
    if (round % 3 == 0) t[1] = t[0] + flat * (t[1] - t[0]);
    if (round % 101 == 0) t[2] = t[1];
    const Vec3 p = round % 7 == 0 ? point_of(t, {0.2, 0.5, 0.3}) : 3 * any();
    EXPECT_NEAR(std::sqrt(triangle_distance2(p, t[0], t[1], t[2])),
                std::sqrt(closest_point_on_triangle(p, t).distance2), 1e-13)
        << round;
  }
  for (const double unit : {1e-70, 1e-30, 1e30, 1e70}) {
    const Vec3 a{0, 0, 0}, b{unit, 0, 0}, c{0, unit, 0};
    EXPECT_NEAR(triangle_distance2({0.2 * unit, 0.2 * unit, unit}, a, b, c) / (unit * unit), 1,
                1e-14);
  }
}

TEST(PointTriangle, TakesSegmentsAndPoints) {
  const Vec3 a{1, 2, 3}, b{4, 2, 3};
  const Vec3 p{2, 4, 3};
  EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, {{a, a, a}}).distance2, 5);
  EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, {{a, b, a}}).distance2, 4);
  EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, {{a, a, b}}).distance2, 4);
  EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, {{a, b, 0.5 * (a + b)}}).distance2, 4);
}

}  // namespace
}  // namespace remaps
