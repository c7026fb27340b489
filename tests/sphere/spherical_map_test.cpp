#include "remaps/sphere/spherical_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "remaps/base/errors.h"
#include "remaps/sphere/spherical_parameterization.h"
#include "sphere/sphere_shapes.h"

namespace remaps::sphere {
namespace {

std::vector<SpherePoint> places_of(const test::Shape& shape) {
  MemoryBudget budget(64u << 20);
  Progress progress;
  return parameterize_sphere(shape.position, shape.triangle, {}, budget, progress);
}

std::vector<std::uint32_t> all_on_one(const test::Shape& shape) {
  return std::vector<std::uint32_t>(shape.triangle.size(), 0);
}

SphericalMap map_of(const test::Shape& shape) {
  return {places_of(shape), shape.triangle, all_on_one(shape)};
}

/// Where on the surface a point of a face is.
Vec3 on_surface(const test::Shape& shape, const FaceWeights& at) {
  const LocalTriangle& t = shape.triangle[at.face];
  const Vec3 &a = shape.position[t[0]], &b = shape.position[t[1]], &c = shape.position[t[2]];
  return a + at.u * (b - a) + at.v * (c - a);
}

TEST(SphericalMap, BackAndForthIsTheIdentity) {
  for (const test::Shape& shape : test::spherical_shapes()) {
    SCOPED_TRACE(shape.name);
    const SphericalMap map = map_of(shape);
    const double diagonal = test::diagonal_of(shape);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> any(0, 1);
    LocalIndex near = 0;
    const auto check = [&](const FaceWeights& point) {
      const Vec3 direction = map.direction(point);
      EXPECT_NEAR(norm(direction), 1, 1e-12);
      const FaceWeights back = map.locate(direction, near);
      near = back.face;
      EXPECT_LT(norm(on_surface(shape, back) - on_surface(shape, point)), 1e-6 * diagonal);
      EXPECT_LT(norm(map.direction(back) - direction), 1e-11);
      EXPECT_GE(back.u, 0);
      EXPECT_GE(back.v, 0);
      EXPECT_LE(back.u + back.v, 1 + 1e-15);
    };
    for (int i = 0; i < 300; ++i) {
      const auto face = static_cast<LocalIndex>(random() % shape.triangle.size());
      const double u = any(random), v = any(random) * (1 - u);
      check({face, u, v});
      check({face, u, 0});      // on an edge
      check({face, u, 1 - u});  // on another
      check({face, 1, 0});      // at a corner
      check({face, 0, 0});
    }
  }
}

TEST(SphericalMap, AVertexIsItsPlace) {
  const test::Shape shape = test::cube(4);
  const std::vector<SpherePoint> place = places_of(shape);
  const SphericalMap map(place, shape.triangle, all_on_one(shape));
  for (LocalIndex f = 0; f < shape.triangle.size(); ++f) {
    const LocalTriangle& t = shape.triangle[f];
    EXPECT_LT(norm(map.direction({f, 0, 0}) - to_vector(place[t[0]])), 1e-11);
    EXPECT_LT(norm(map.direction({f, 1, 0}) - to_vector(place[t[1]])), 1e-11);
    EXPECT_LT(norm(map.direction({f, 0, 1}) - to_vector(place[t[2]])), 1e-11);
  }
}

TEST(SphericalMap, EveryStartFindsTheSame) {
  const test::Shape shape = test::icosphere(2);
  const SphericalMap map = map_of(shape);
  const Vec3 direction = map.direction({17, 0.3, 0.4});
  for (LocalIndex near = 0; near < shape.triangle.size(); ++near) {
    EXPECT_EQ(map.locate(direction, near).face, 17u);
  }
}

TEST(SphericalMap, RefusesATurnedTriangle) {
  const test::Shape shape = test::icosphere(1);
  std::vector<SpherePoint> place = places_of(shape);
  for (std::int64_t& x : place[7]) x = -x;  // to the other side
  EXPECT_THROW(SphericalMap(place, shape.triangle, all_on_one(shape)), GeometryError);
}

TEST(SphericalMap, RefusesPlacesThatAreNotOnTheSphere) {
  const test::Shape shape = test::octahedron();
  for (const int shift : {1, 21}) {  // the second would overflow 128 bits
    std::vector<SpherePoint> place = places_of(shape);
    for (SpherePoint& p : place) {
      for (std::int64_t& x : p) x *= std::int64_t{1} << shift;
    }
    EXPECT_THROW(SphericalMap(place, shape.triangle, all_on_one(shape)), GeometryError) << shift;
  }
}

TEST(SphericalMap, RefusesADoubleCover) {
  // Two turns about an axis: all triangles of a bipyramid turn the same way, but cover twice.
  const test::Shape shape = test::bipyramid(10);
  std::vector<SpherePoint> place(shape.position.size());
  std::vector<LocalIndex> valence(place.size());
  for (const LocalTriangle& t : shape.triangle) {
    for (const LocalIndex v : t) ++valence[v];
  }
  for (std::size_t v = 0; v < place.size(); ++v) {
    const Vec3& p = shape.position[v];
    const double twice = 2 * std::atan2(p.y, p.x);
    place[v] = to_sphere_point(valence[v] > 4 ? Vec3{0, 0, p.z > 0 ? 1.0 : -1.0}
                                              : Vec3{std::cos(twice), std::sin(twice), 0});
  }
  EXPECT_THROW(SphericalMap(place, shape.triangle, all_on_one(shape)), GeometryError);
}

TEST(SphericalMap, EachComponentHasASphere) {
  const test::Shape a = test::octahedron(), b = test::icosphere(1), both = test::together(a, b);
  std::vector<SpherePoint> place = places_of(a);
  const std::vector<SpherePoint> other = places_of(b);
  place.insert(place.end(), other.begin(), other.end());
  std::vector<std::uint32_t> component(both.triangle.size(), 1);
  std::fill_n(component.begin(), a.triangle.size(), 0);
  const SphericalMap map(place, both.triangle, component);
  ASSERT_EQ(map.components(), 2u);
  for (std::uint32_t c = 0; c < 2; ++c) {
    const FaceWeights at = map.locate({0.6, 0, 0.8}, map.first_face(c));
    EXPECT_EQ(map.component_of(at.face), c);
    EXPECT_LT(norm(map.direction(at) - Vec3{0.6, 0, 0.8}), 1e-11);
  }
  // One that has none.
  std::fill_n(component.begin(), a.triangle.size(), kNoIndex);
  for (std::uint32_t& c : component) {
    if (c == 1) c = 0;
  }
  const SphericalMap one(place, both.triangle, component);
  EXPECT_EQ(one.components(), 1u);
  EXPECT_EQ(one.component_of(0), kNoIndex);
}

TEST(SphericalMap, QualityIsThatOfTheMapItself) {
  test::Shape shape = test::octahedron();
  std::vector<SpherePoint> place;
  for (const Vec3& p : shape.position) place.push_back(to_sphere_point(1 / norm(p) * p));
  const SphericalMap map(place, shape.triangle, all_on_one(shape));
  for (Vec3& p : shape.position) p = 3 * p;
  // Central projection of a face x + y + z = 1: s1 = |p|, s2 = sqrt(3) |p|^2.
  double s2 = 0, areas = 0, angles = 0;
  const int n = 1000;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n - i; ++j) {
      const double u = (i + 1.0 / 3) / n, v = (j + 1.0 / 3) / n;
      const double p = norm({1 - u - v, u, v}), a = p, b = std::sqrt(3.0) * p * p;
      const double scale = std::numbers::pi / std::sqrt(3.0), ratio = scale * a * b;
      s2 += scale * (a * a + b * b) / 2;
      areas += (ratio + 1 / ratio) / 2;
      angles += (a / b + b / a) / 2;
    }
  }
  const double points = n * (n + 1) / 2;
  const SphericalQuality q = map.quality(shape.position, 0);
  EXPECT_NEAR(q.stretch_efficiency, points / s2, 3e-3);
  EXPECT_NEAR(q.area_distortion, areas / points, 3e-3);
  EXPECT_NEAR(q.angle_distortion, angles / points, 3e-3);
}

TEST(SphericalMap, QualityIsOneForAnIsometry) {
  const test::Shape shape = test::icosphere(5);
  std::vector<SpherePoint> place;
  for (const Vec3& p : shape.position) place.push_back(to_sphere_point(p));
  const SphericalQuality q =
      SphericalMap(place, shape.triangle, all_on_one(shape)).quality(shape.position, 0);
  EXPECT_NEAR(q.stretch_efficiency, 1, 1e-3);
  EXPECT_LE(q.stretch_efficiency, 1 + 2e-4);
  EXPECT_NEAR(q.area_distortion, 1, 1e-3);
  EXPECT_NEAR(q.angle_distortion, 1, 1e-3);
}

}  // namespace
}  // namespace remaps::sphere
