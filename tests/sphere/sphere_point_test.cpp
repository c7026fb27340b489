#include "remaps/sphere/sphere_point.h"

#include <gtest/gtest.h>

#include <random>

namespace remaps::sphere {
namespace {

constexpr std::int64_t kOne = std::int64_t{1} << 40;

TEST(SpherePoint, OrientationTellsOneGridUnit) {
  // c lies on the plane of a and b, and then a unit off it: doubles would round that away.
  const SpherePoint a{kOne - 1, 12345678901, 3}, b{987654321098, kOne - 7, 5};
  SpherePoint c{a[0] + b[0], a[1] + b[1], a[2] + b[2]};
  EXPECT_TRUE(orientation(a, b, c) == 0);
  const auto minor = Int128{a[0]} * b[1] - Int128{a[1]} * b[0];
  ++c[2];
  EXPECT_TRUE(orientation(a, b, c) == minor);
  c[2] -= 2;
  EXPECT_TRUE(orientation(a, b, c) == -minor);
}

TEST(SpherePoint, OrientationIsAntisymmetric) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::int64_t> any(-kOne, kOne);
  for (int i = 0; i < 1000; ++i) {
    std::array<SpherePoint, 3> p;
    for (SpherePoint& q : p) q = {any(random), any(random), any(random)};
    const Int128 d = orientation(p[0], p[1], p[2]);
    EXPECT_TRUE(d == orientation(p[1], p[2], p[0]));
    EXPECT_TRUE(d == -orientation(p[1], p[0], p[2]));
  }
}

TEST(SpherePoint, OrientationDoesNotOverflow) {
  // The largest determinant of entries of this size: 4 kOne^3 = 2^122.
  const SpherePoint a{kOne, kOne, -kOne}, b{kOne, -kOne, kOne}, c{-kOne, kOne, kOne};
  EXPECT_TRUE(orientation(a, b, c) == -(Int128{4} << 120) || orientation(a, b, c) == Int128{4}
                                                                                         << 120);
  EXPECT_TRUE(orientation({kOne, 0, 0}, {0, kOne, 0}, {0, 0, kOne}) == Int128{1} << 120);
}

TEST(SpherePoint, RoundsToTheGrid) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    Vec3 p{normal(random), normal(random), normal(random)};
    p = 1 / norm(p) * p;
    EXPECT_LE(norm(to_vector(to_sphere_point(p)) - p), 0.87 / kSphereGrid);
  }
}

}  // namespace
}  // namespace remaps::sphere
