#include "remaps/mesh/quadric.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace remaps {
namespace {

struct Plane {
  Vec3 normal;
  double distance, weight;
};

class QuadricTest : public testing::TestWithParam<std::uint64_t> {
 protected:
  Vec3 vector() { return {number_(random_), number_(random_), number_(random_)}; }
  std::vector<Plane> planes() {
    std::vector<Plane> result;
    for (int i = 0; i < 6; ++i) {
      const Vec3 n = vector();
      result.push_back({(1 / norm(n)) * n, number_(random_), 0.1 + norm2(vector())});
    }
    return result;
  }
  static Quadric sum(const std::vector<Plane>& planes) {
    Quadric q;
    for (const Plane& p : planes) q.add_plane(p.normal, p.distance, p.weight);
    return q;
  }
  static double directly(const std::vector<Plane>& planes, const Vec3& x) {
    double value = 0;
    for (const Plane& p : planes) {
      const double d = dot(p.normal, x) + p.distance;
      value += p.weight * d * d;
    }
    return value;
  }

  std::mt19937_64 random_{GetParam()};
  std::uniform_real_distribution<double> number_{-1, 1};
};

TEST_P(QuadricTest, IsTheWeightedSumOfSquaredDistances) {
  const std::vector<Plane> p = planes();
  const Quadric q = sum(p);
  for (int i = 0; i < 20; ++i) {
    const Vec3 x = vector();
    EXPECT_NEAR(q(x), directly(p, x), 1e-5 * (1 + directly(p, x)));
  }
}

TEST_P(QuadricTest, MovesWithItsVertex) {
  const std::vector<Plane> p = planes();
  const std::vector<Plane> r = planes();
  const Vec3 offset = vector();
  Quadric q = sum(p);
  q.add_translated(sum(r), offset);
  for (int i = 0; i < 20; ++i) {
    const Vec3 x = vector();
    const double expected = directly(p, x) + directly(r, x - offset);
    EXPECT_NEAR(q(x), expected, 1e-5 * (1 + expected));
  }
}

TEST_P(QuadricTest, IsNeverNegative) {
  std::vector<Plane> p = planes();
  p.resize(1);
  p[0].distance = 0;
  const Quadric q = sum(p);
  for (int i = 0; i < 200; ++i) {
    const Vec3 x = vector();
    EXPECT_GE(q(x - dot(x, p[0].normal) * p[0].normal), 0);  // in the plane, up to rounding
  }
  EXPECT_EQ(Quadric{}(vector()), 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, QuadricTest, testing::Values(1, 2, 3, 4, 5));

}  // namespace
}  // namespace remaps
