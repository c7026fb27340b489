#include "remaps/mesh/closest_point_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "measure/test_surfaces.h"
#include "remaps/base/errors.h"
#include "remaps/mesh/point_triangle.h"

namespace remaps {
namespace {

using test::bumpy_sphere;
using test::Soup;

/// The closest triangle by looking at all.
ClosestPoint look_at_all(const Vec3& p, const Soup& soup) {
  ClosestPoint best;
  for (std::size_t i = 0; i < soup.size(); ++i) {
    const TrianglePoint found = closest_point_on_triangle(p, soup[i]);
    if (found.distance2 < best.distance2) {
      best = {static_cast<LocalIndex>(i), found.distance2, found.weights};
    }
  }
  return best;
}

void expect_all_closest(const Soup& soup, const std::vector<Vec3>& points) {
  const ClosestPointTree tree(soup);
  LocalIndex hint = kNoIndex;
  for (const Vec3& p : points) {
    const ClosestPoint expected = look_at_all(p, soup);
    for (const ClosestPoint& found :
         {tree.closest(p), tree.closest(p, expected.distance2), tree.closest(p, 1e300, hint)}) {
      EXPECT_EQ(found.triangle, expected.triangle);
      EXPECT_EQ(found.distance2, expected.distance2);
      EXPECT_EQ(found.weights, expected.weights);
    }
    hint = expected.triangle;
  }
}

std::vector<Vec3> points_about(const Vec3& centre, double spread, std::size_t n) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> offset(-spread, spread);
  std::vector<Vec3> points(n);
  for (Vec3& p : points) p = centre + Vec3{offset(random), offset(random), offset(random)};
  return points;
}

TEST(ClosestPointTree, FindsWhatLookingAtAllFinds) {
  expect_all_closest(bumpy_sphere(20, 0.02, 1), points_about({0, 0, 0}, 1.5, 500));
}

TEST(ClosestPointTree, FindsTheClosestOfASmallSurfaceFarFromTheOrigin) {
  Soup soup = bumpy_sphere(12, 0.02, 1);
  const Vec3 away{1e7, -3e7, 2e7};
  for (TrianglePositions& triangle : soup) {
    for (Vec3& corner : triangle) corner = corner + away;
  }
  expect_all_closest(soup, points_about(away, 1.5, 200));
}

TEST(ClosestPointTree, FindsTheClosestInAnyUnit) {
  for (const double unit : {1e-60, 1e-20, 1e20, 1e60}) {
    Soup soup = bumpy_sphere(8, 0.02, 1);
    for (TrianglePositions& triangle : soup) {
      for (Vec3& corner : triangle) corner = unit * corner;
    }
    expect_all_closest(soup, points_about({0, 0, 0}, 1.5 * unit, 50));
  }
}

TEST(ClosestPointTree, FindsTheClosestToPointsFarAway) {
  const Soup soup = bumpy_sphere(8, 0.02, 1);
  for (const double far : {1e3, 1e9, 1e14, 1e17, 1e30, 1e100}) {
    expect_all_closest(soup, points_about({far, -far, 0.5 * far}, 0.1 * far, 10));
  }
}

TEST(ClosestPointTree, SeesDetailsBesideAnOutlier) {
  Soup soup = bumpy_sphere(10, 0.02, 1);
  soup.push_back({{{1e6, 1e6, 1e6}, {1.1e6, 1e6, 1e6}, {1e6, 1.1e6, 1e6}}});
  expect_all_closest(soup, points_about({0, 0, 0}, 1.5, 100));
}

TEST(ClosestPointTree, FindsDegenerateTriangles) {
  Soup soup;
  for (const Vec3& p : points_about({0, 0, 0}, 1, 100)) soup.push_back({p, p, p});
  for (const Vec3& p : points_about({0.5, 0, 0}, 1, 100)) soup.push_back({p, p, Vec3{1, 1, 1}});
  expect_all_closest(soup, points_about({0, 0, 0}, 1.2, 200));
}

TEST(ClosestPointTree, PrefersTheLowestIndexOfEquals) {
  Soup soup(100, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  const ClosestPointTree tree(soup);
  EXPECT_EQ(tree.closest({0.2, 0.2, 1}).triangle, 0u);
  EXPECT_EQ(tree.closest({0.2, 0.2, 1}, 2, 57).triangle, 0u);
}

TEST(ClosestPointTree, AnswersNothingBeyondTheBound) {
  const ClosestPointTree tree(test::square(0, 0));
  EXPECT_EQ(tree.closest({0.5, 0.5, 2}, 3.999).triangle, kNoIndex);
  EXPECT_EQ(tree.closest({0.5, 0.5, 2}, 3.999, 1).triangle, kNoIndex);
  EXPECT_EQ(tree.closest({0.5, 0.5, 2}, 4).distance2, 4);
  EXPECT_EQ(tree.closest({0.25, 0.5, 0}, 0).distance2, 0);
}

TEST(ClosestPointTree, HoldsNothing) {
  const ClosestPointTree tree(Soup{});
  EXPECT_EQ(tree.closest({0, 0, 0}).triangle, kNoIndex);
  EXPECT_TRUE(tree.box().empty());
}

TEST(ClosestPointTree, RefusesCoordinatesThatAreNotFinite) {
  for (const double bad : {std::numeric_limits<double>::infinity(), std::nan("")}) {
    const Soup soup{{{{0, 0, 0}, {1, 0, 0}, {0, bad, 0}}}};
    EXPECT_THROW(ClosestPointTree{soup}, GeometryError);
  }
}

TEST(ClosestPointTree, KeepsItsPromiseOfMemory) {
  for (const std::size_t n : {1u, 5u, 40u, 160u}) {
    const Soup soup = bumpy_sphere(n + 1, 0.01, 1);
    const ClosestPointTree tree(soup, 2);
    EXPECT_LE(tree.peak_bytes(),
              soup.size() * ClosestPointTree::kPeakBytesPerTriangle + (std::size_t{1} << 14));
  }
}

TEST(ClosestPointTree, HandsItsTrianglesBack) {
  const Soup soup = bumpy_sphere(4, 0.01, 1);
  ClosestPointTree tree(soup);
  EXPECT_EQ(tree.triangles(), soup);
  EXPECT_EQ(std::move(tree).release(), soup);
}

}  // namespace
}  // namespace remaps
