#include "remaps/sphere/star_stretch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace remaps::sphere {
namespace {

Vec3 unit(const Vec3& p) {
  return 1 / norm(p) * p;
}

/// A ring about the z axis, somewhat irregular, and a surface over it that is not like it.
struct Star {
  std::vector<Vec3> ring, surface;
  Vec3 centre{0.1, -0.05, 0.3};

  Star() {
    for (int i = 0; i < 7; ++i) {
      const double a = 2 * std::numbers::pi * i / 7 + 0.1 * std::sin(3.0 * i);
      const double r = 0.3 + 0.05 * std::cos(5.0 * i);
      ring.push_back(unit({r * std::cos(a), r * std::sin(a), 1}));
      surface.push_back({2 * std::cos(a), 0.7 * std::sin(a), 0.2 * std::cos(2 * a)});
    }
  }
  StarStretch stretch(double area = 0) const {
    StarStretch result;
    result.set_surface(centre, surface, area);
    result.set_ring(ring);
    return result;
  }
};

TEST(StarStretch, IsOneForAnIsometry) {
  // The flat triangles of an octahedron, mapped to themselves: D is then the area times the
  // distance of the plane from the centre, 1 / sqrt(3), for each.
  StarStretch star;
  const std::vector<Vec3> ring{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  star.set_surface({0, 0, 1}, ring, 0);
  star.set_ring(ring);
  const double area = 4 * std::sqrt(3.0) / 2;
  EXPECT_NEAR(star.energy({0, 0, 1}), area * 3, 1e-12);
}

TEST(StarStretch, HasABarrierWhereATriangleTurnsOver) {
  const Star given;
  const StarStretch star = given.stretch();
  EXPECT_TRUE(star.is_oriented({0, 0, 1}));
  // Towards the edge between the first two neighbours and beyond.
  const Vec3 edge = unit(given.ring[0] + given.ring[1]);
  double before = star.energy(unit(0.2 * edge + 0.8 * Vec3{0, 0, 1}));
  for (const double left : {1e-2, 1e-4, 1e-6}) {
    const double now = star.energy(unit((1 - left) * edge + left * Vec3{0, 0, 1}));
    EXPECT_GT(now, 10 * before);
    before = now;
  }
  const Vec3 beyond = unit(1.1 * edge - 0.1 * Vec3{0, 0, 1});
  EXPECT_EQ(star.energy(beyond), std::numeric_limits<double>::infinity());
  EXPECT_FALSE(star.is_oriented(beyond));
  EXPECT_FALSE(star.is_oriented(unit((1 - 1e-12) * edge + 1e-12 * Vec3{0, 0, 1})));
}

TEST(StarStretch, NewtonFindsTheMinimum) {
  const StarStretch star = Star().stretch(0.01);
  const Vec3 start = unit({0.15, -0.1, 1});
  ASSERT_TRUE(star.is_oriented(start));
  Vec3 x = start;
  for (int i = 0; i < 5; ++i) {
    const Vec3 next = star.improve(x, 1);
    EXPECT_LE(star.energy(next), star.energy(x));
    EXPECT_TRUE(star.is_oriented(next));
    x = next;
  }
  x = star.improve(start, 30);
  EXPECT_LT(star.energy(x), 0.99 * star.energy(start));
  EXPECT_NEAR(norm(x), 1, 1e-14);
  // Wherever one goes from there it is worse.
  const Vec3 u = unit(cross(x, {1, 0, 0})), v = cross(x, u);
  for (int i = 0; i < 16; ++i) {
    const double a = 2 * std::numbers::pi * i / 16;
    const Vec3 aside = unit(x + 1e-3 * std::cos(a) * u + 1e-3 * std::sin(a) * v);
    EXPECT_GT(star.energy(aside), star.energy(x)) << i;
  }
}

TEST(StarStretch, NewtonConvergesQuadratically) {
  // Which it does only if slopes and curvatures are those of the energy.
  const StarStretch star = Star().stretch(0.01);
  const Vec3 goal = star.improve(unit({0.05, 0, 1}), 60);
  Vec3 x = unit(goal + Vec3{0.01, -0.005, 0});
  const double first = norm(x - goal);
  x = star.improve(x, 1);
  const double second = norm(x - goal);
  x = star.improve(x, 1);
  EXPECT_LT(second, 10 * first * first);
  EXPECT_LT(norm(x - goal), 10 * second * second + 1e-7);
}

TEST(StarStretch, StaysWhereThereIsNoSurface) {
  StarStretch star;
  const Star given;
  const std::vector<Vec3> nothing(given.ring.size());
  star.set_surface({}, nothing, 0);
  star.set_ring(given.ring);
  const Vec3 x = unit({0.1, 0, 1});
  EXPECT_EQ(star.improve(x, 5), x);
  // With an area added it goes to the middle.
  star.set_surface({}, nothing, 0.1);
  EXPECT_LT(star.energy(star.improve(x, 20)), star.energy(x));
}

}  // namespace
}  // namespace remaps::sphere
