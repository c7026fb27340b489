#include "remaps/mesh/polygon_cutter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace remaps {
namespace {

using Polygon = std::vector<Vec3>;

Vec3 triangle_area(const Polygon& p, const PolygonCorners& t) {
  return 0.5 * cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
}

Vec3 area(const Polygon& p) {
  Vec3 sum;
  for (std::uint32_t i = 2; i < p.size(); ++i) sum = sum + triangle_area(p, {0, i - 1, i});
  return sum;
}

std::vector<PolygonCorners> cut(const Polygon& p) {
  PolygonTriangulation triangulation;
  const auto triangles = triangulation.cut(p);
  return {triangles.begin(), triangles.end()};
}

bool is_fan(const std::vector<PolygonCorners>& triangles) {
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (triangles[i] != PolygonCorners{0, i + 1, i + 2}) return false;
  }
  return true;
}

/// All triangles are turned as the polygon, and cover it once: their areas add up to its own.
void expect_cover(const Polygon& p, double tolerance = 0) {
  const auto triangles = cut(p);
  ASSERT_EQ(triangles.size(), p.size() - 2);
  const Vec3 whole = area(p);
  double sum = 0;
  for (const PolygonCorners& t : triangles) {
    const Vec3 part = triangle_area(p, t);
    EXPECT_GE(dot(part, whole), -tolerance * dot(whole, whole));
    sum += norm(part);
  }
  EXPECT_NEAR(sum, norm(whole), 1e-9 * norm(whole));
}

/// A star about the origin, in a plane through it.
Polygon star(std::mt19937_64& random, std::size_t n, double least_radius) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::uniform_real_distribution<double> radius(least_radius, 1);
  const Vec3 u{unit(random), unit(random), unit(random)};
  const Vec3 v = cross(u, {unit(random), unit(random), unit(random)});
  Polygon p;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * double(i) / double(n);
    const double r = radius(random);
    p.push_back((r * std::cos(angle) / norm(u)) * u + (r * std::sin(angle) / norm(v)) * v);
  }
  return p;
}

TEST(PolygonTriangulation, MakesFansOfConvexPolygons) {
  std::mt19937_64 random(8);
  for (std::size_t n = 3; n < 40; ++n) EXPECT_TRUE(is_fan(cut(star(random, n, 1)))) << n;
  EXPECT_TRUE(is_fan(cut({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.2}, {0, 1, 0}})));
}

TEST(PolygonTriangulation, CoversConcavePolygonsOnce) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    expect_cover(star(random, 4 + static_cast<std::size_t>(i) % 37, 0.1), 1e-12);
  }
  // A comb, in both directions.
  Polygon comb = {{0, 0, 0}, {20, 0, 0}};
  for (int x = 20; x > 0; x -= 2) {
    comb.push_back({double(x), 5, 0});
    comb.push_back({x - 1.0, 1, 0});
  }
  expect_cover(comb);
  std::reverse(comb.begin(), comb.end());
  expect_cover(comb);
}

TEST(PolygonTriangulation, CutsDartsAlongTheirInnerDiagonal) {
  const Polygon dart = {{0, 0, 0}, {4, 0, 1}, {1, 1, 0.5}, {0, 4, 1}};
  for (std::size_t turn = 0; turn < 4; ++turn) {
    Polygon p = dart;
    std::rotate(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(turn), p.end());
    for (const PolygonCorners& t : cut(p)) {
      bool has_inner = false;
      for (const std::uint32_t c : t) has_inner = has_inner || p[c] == dart[2];
      EXPECT_TRUE(has_inner);
    }
  }
}

TEST(PolygonTriangulation, AvoidsFlatTrianglesWhereCornersAreOnASide) {
  for (std::size_t turn = 0; turn < 6; ++turn) {
    Polygon p = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}};
    std::rotate(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(turn), p.end());
    expect_cover(p);
    for (const PolygonCorners& t : cut(p)) EXPECT_GT(norm(triangle_area(p, t)), 0);
  }
}

/// Of the first triangle, differences of products in doubles would say that it is flat.
TEST(PolygonTriangulation, TellsSignsExactly) {
  const double a = 1 + std::ldexp(1.0, -27);
  const double b = 1 - std::ldexp(1.0, -27);
  // a * b = 1 - 2^-54.
  EXPECT_TRUE(is_fan(cut({{0, 0, 0}, {1, b, 0}, {a, 1, 0}, {-4, 4, 0}})));
  EXPECT_FALSE(is_fan(cut({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {-4, 4, 0}})));
}

TEST(PolygonTriangulation, CutsWhatIsNoPolygonSomehow) {
  std::mt19937_64 random(10);
  std::uniform_real_distribution<double> unit(-1, 1);
  EXPECT_EQ(cut(Polygon(7, Vec3{1, 2, 3})).size(), 5U);
  EXPECT_EQ(cut({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 2U);
  for (int i = 0; i < 300; ++i) {
    Polygon p;
    for (int k = 0; k < 3 + i % 20; ++k)
      p.push_back({std::round(2 * unit(random)), std::round(2 * unit(random)), unit(random)});
    const auto triangles = cut(p);
    ASSERT_EQ(triangles.size(), p.size() - 2);
    for (const PolygonCorners& t : triangles)
      for (const std::uint32_t c : t) ASSERT_LT(c, p.size());
  }
}

}  // namespace
}  // namespace remaps
