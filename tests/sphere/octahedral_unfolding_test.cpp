#include "remaps/sphere/octahedral_unfolding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

namespace remaps::sphere {
namespace {

TEST(OctahedralUnfolding, HasItsCornersWhereTheyBelong) {
  const auto expect = [](double x, double y, const Vec3& d) {
    EXPECT_LT(norm(octahedral_direction(x, y) - d), 1e-12) << x << ' ' << y;
  };
  expect(0, 0, {0, 0, 1});
  expect(1, 0, {1, 0, 0});
  expect(0, 1, {0, 1, 0});
  expect(-1, 0, {-1, 0, 0});
  expect(0, -1, {0, -1, 0});
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) expect(x, y, {0, 0, -1});
  }
}

TEST(OctahedralUnfolding, KeepsAreasAndOrientation) {
  // Each cell of a grid, but its sides are curves on the sphere.
  const int n = 64;
  const double area = 4 * std::numbers::pi / (n * n);
  const auto at = [&](int i, int j) {
    return octahedral_direction(2.0 * i / n - 1, 2.0 * j / n - 1);
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const Vec3 a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      const double volume = dot(a, cross(b, c)) + dot(a, cross(c, d));
      EXPECT_GT(volume, 0) << i << ' ' << j;
      EXPECT_NEAR(volume / 2, area, 0.12 * area) << i << ' ' << j;
      EXPECT_NEAR(norm(a), 1, 1e-14);
    }
  }
}

TEST(OctahedralUnfolding, SidesFoldAtTheirMiddles) {
  for (const double t : {0.0, 0.125, 0.3, 0.77, 1.0}) {
    EXPECT_LT(norm(octahedral_direction(t, 1) - octahedral_direction(-t, 1)), 1e-15);
    EXPECT_LT(norm(octahedral_direction(t, -1) - octahedral_direction(-t, -1)), 1e-15);
    EXPECT_LT(norm(octahedral_direction(1, t) - octahedral_direction(1, -t)), 1e-15);
    EXPECT_LT(norm(octahedral_direction(-1, t) - octahedral_direction(-1, -t)), 1e-15);
  }
}

TEST(OctahedralGrid, SamplesThatAreOnePointHaveOneNumber) {
  for (const std::uint32_t size : {3u, 5u, 17u}) {
    const OctahedralGrid grid(size);
    std::set<std::uint64_t> numbers;
    for (std::uint32_t row = 0; row < size; ++row) {
      for (std::uint32_t column = 0; column < size; ++column) {
        const std::uint64_t first = grid.first_same(row, column);
        EXPECT_LE(first, std::uint64_t{row} * size + column);
        const auto r = static_cast<std::uint32_t>(first / size),
                   c = static_cast<std::uint32_t>(first % size);
        EXPECT_EQ(grid.first_same(r, c), first);
        EXPECT_LT(norm(grid.direction(r, c) - grid.direction(row, column)), 1e-12);
        numbers.insert(first);
      }
    }
    // A closed surface of 2 (size - 1)^2 triangles.
    EXPECT_EQ(numbers.size(), std::size_t{size - 1} * (size - 1) + 2);
  }
}

}  // namespace
}  // namespace remaps::sphere
