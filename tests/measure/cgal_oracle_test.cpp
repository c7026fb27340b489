// Compares with CGAL's AABB tree and a sampling of its own. CGAL is GPL: it is used here only,
// never in the library.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "measure/test_surfaces.h"
#include "remaps/measure/surface_error.h"
#include "remaps/mesh/closest_point_tree.h"

namespace remaps {
namespace {

using test::bumpy_sphere;
using test::Soup;
using test::source_of;

class Oracle {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Triangles = std::vector<Kernel::Triangle_3>;
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;

 public:
  explicit Oracle(const Soup& soup) {
    for (const TrianglePositions& t : soup) {
      triangles_.emplace_back(point(t[0]), point(t[1]), point(t[2]));
    }
    tree_.insert(triangles_.cbegin(), triangles_.cend());
    tree_.accelerate_distance_queries();
  }

  double distance2(const Vec3& p) const { return tree_.squared_distance(point(p)); }

 private:
  static Kernel::Point_3 point(const Vec3& p) { return {p.x, p.y, p.z}; }

  Triangles triangles_;
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree_;
};

struct Moments {
  double l2 = 0, mean = 0, max = 0;
};

/// Distances from one surface to another at independent random points of it.
Moments sampled_distances(const Soup& from, const Soup& to, int n) {
  std::mt19937_64 random(11);
  std::vector<double> areas;
  for (const TrianglePositions& t : from) areas.push_back(norm(cross(t[1] - t[0], t[2] - t[0])));
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::uniform_real_distribution<double> unit(0, 1);
  const Oracle oracle(to);
  Moments m;
  for (int i = 0; i < n; ++i) {
    const TrianglePositions& t = from[pick(random)];
    double v = unit(random), w = unit(random);
    if (v + w > 1) v = 1 - v, w = 1 - w;
    const double d2 = oracle.distance2(t[0] + v * (t[1] - t[0]) + w * (t[2] - t[0]));
    m.l2 += d2;
    m.mean += std::sqrt(d2);
    m.max = std::max(m.max, std::sqrt(d2));
  }
  m.l2 = std::sqrt(m.l2 / n);
  m.mean /= n;
  return m;
}

TEST(CgalOracle, AgreesOnEveryClosestPoint) {
  const Soup soup = bumpy_sphere(70, 0.01, 1);
  const Oracle oracle(soup);
  const ClosestPointTree tree(soup, 2);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (int i = 0; i < 5'000; ++i) {
    const Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
    EXPECT_NEAR(tree.closest(p).distance2, oracle.distance2(p), 1e-12);
  }
}

TEST(CgalOracle, AgreesOnTheErrorOfACoarserSurface) {
  const Soup fine = bumpy_sphere(70, 0.01, 1), coarse = bumpy_sphere(25, 0, 2);
  for (const std::uint64_t bytes : {std::uint64_t{1} << 20, std::uint64_t{1} << 26}) {
    const SurfaceError e =
        measure_surface_error(source_of(fine), source_of(coarse),
                              {.samples = 200'000, .threads = 2, .memory_bytes = bytes});
    const Moments forward = sampled_distances(fine, coarse, 100'000);
    const Moments backward = sampled_distances(coarse, fine, 100'000);
    EXPECT_NEAR(e.l2_forward * e.diagonal / forward.l2, 1, 0.02);
    EXPECT_NEAR(e.mean_forward * e.diagonal / forward.mean, 1, 0.02);
    EXPECT_NEAR(e.l2_backward * e.diagonal / backward.l2, 1, 0.02);
    EXPECT_NEAR(e.mean_backward * e.diagonal / backward.mean, 1, 0.02);
    EXPECT_GE(e.max_forward * e.diagonal, 0.99 * forward.max);
    EXPECT_GE(e.max_backward * e.diagonal, 0.99 * backward.max);
  }
}

/// Compares mean, root mean square and maximum with those of independent samples.
void expect_agreement(const Soup& a, const Soup& b, double tolerance) {
  for (const std::uint64_t bytes : {std::uint64_t{1} << 20, std::uint64_t{1} << 26}) {
    const SurfaceError e = measure_surface_error(
        source_of(a), source_of(b), {.samples = 50'000, .threads = 2, .memory_bytes = bytes});
    const Moments forward = sampled_distances(a, b, 50'000);
    const Moments backward = sampled_distances(b, a, 50'000);
    EXPECT_NEAR(e.l2_forward * e.diagonal / forward.l2, 1, tolerance);
    EXPECT_NEAR(e.mean_forward * e.diagonal / forward.mean, 1, tolerance);
    EXPECT_NEAR(e.l2_backward * e.diagonal / backward.l2, 1, tolerance);
    EXPECT_NEAR(e.mean_backward * e.diagonal / backward.mean, 1, tolerance);
    EXPECT_GE(e.max_forward * e.diagonal, 0.98 * forward.max);
    EXPECT_GE(e.max_backward * e.diagonal, 0.98 * backward.max);
  }
}

TEST(CgalOracle, AgreesOnConcentricSpheres) {
  Soup large = bumpy_sphere(30, 0.01, 3);
  for (TrianglePositions& triangle : large) {
    for (Vec3& corner : triangle) corner = 1.4 * corner;
  }
  expect_agreement(bumpy_sphere(40, 0.01, 4), large, 0.01);
}

TEST(CgalOracle, AgreesOnAHugeTriangleAmongTiny) {
  Soup mixed = bumpy_sphere(30, 0.01, 5);
  mixed.push_back({{{-5, -5, 0.3}, {6, -5, 0.2}, {0, 7, 0.3}}});
  expect_agreement(mixed, bumpy_sphere(40, 0, 6), 0.02);
}

TEST(CgalOracle, AgreesOnDisjointSurfacesInAnyOrder) {
  Soup aside = bumpy_sphere(30, 0.01, 7), shuffled = bumpy_sphere(40, 0.01, 8);
  for (TrianglePositions& triangle : aside) {
    for (Vec3& corner : triangle) corner = corner + Vec3{2.5, 0.5, 0};
  }
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937_64(9));
  expect_agreement(aside, shuffled, 0.01);
}

}  // namespace
}  // namespace remaps
