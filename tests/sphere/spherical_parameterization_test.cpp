#include "remaps/sphere/spherical_parameterization.h"

#include <gtest/gtest.h>

#include "remaps/base/errors.h"
#include "remaps/sphere/spherical_map.h"
#include "sphere/sphere_shapes.h"

namespace remaps::sphere {
namespace {

std::vector<SpherePoint> map_shape(const test::Shape& shape, std::uint64_t memory = 64u << 20) {
  MemoryBudget budget(memory);
  Progress progress;
  return parameterize_sphere(shape.position, shape.triangle, {}, budget, progress);
}

SphericalQuality quality_of(const test::Shape& shape) {
  const SphericalMap map(map_shape(shape), shape.triangle,
                         std::vector<std::uint32_t>(shape.triangle.size(), 0));
  return map.quality(shape.position, 0);
}

TEST(SphericalParameterization, TurnsNoTriangleOver) {
  for (const test::Shape& shape : test::spherical_shapes()) {
    SCOPED_TRACE(shape.name);
    const std::vector<SpherePoint> place = map_shape(shape);
    ASSERT_EQ(place.size(), shape.position.size());
    for (const LocalTriangle& t : shape.triangle) {
      EXPECT_TRUE(orientation(place[t[0]], place[t[1]], place[t[2]]) > 0);
    }
    // Covers the sphere once, or this throws.
    EXPECT_NO_THROW(
        SphericalMap(place, shape.triangle, std::vector<std::uint32_t>(shape.triangle.size(), 0)));
    EXPECT_EQ(map_shape(shape), place);
  }
}

TEST(SphericalParameterization, ASphereIsNearlyItself) {
  const SphericalQuality q = quality_of(test::icosphere(3));
  EXPECT_GT(q.stretch_efficiency, 0.97);
  EXPECT_LE(q.stretch_efficiency, 1 + 2e-4);
  EXPECT_LT(q.area_distortion, 1.02);
  EXPECT_LT(q.angle_distortion, 1.02);
}

TEST(SphericalParameterization, LimbsAreStretchedModerately) {
  test::Shape needle = test::icosphere(3);
  for (Vec3& p : needle.position) p.x *= 6;
  EXPECT_GT(quality_of(needle).stretch_efficiency, 0.5);
  EXPECT_GT(quality_of(test::bumpy(test::icosphere(4), 0.4, 0.005, 3)).stretch_efficiency, 0.7);
}

TEST(SphericalParameterization, ASurfaceWithoutAreaIsMapped) {
  test::Shape flat = test::octahedron();
  for (Vec3& p : flat.position) p = {p.x, 0, 0};
  const std::vector<SpherePoint> place = map_shape(flat);
  for (const LocalTriangle& t : flat.triangle) {
    EXPECT_TRUE(orientation(place[t[0]], place[t[1]], place[t[2]]) > 0);
  }
}

TEST(SphericalParameterization, RefusesWhatIsNoSphere) {
  for (const test::Shape& shape : {test::torus(8, 9), test::disk(4), test::annulus(8, 3)}) {
    EXPECT_THROW(map_shape(shape), GeometryError) << shape.name;
  }
}

TEST(SphericalParameterization, KeepsToTheBudget) {
  EXPECT_THROW(map_shape(test::icosphere(4), 1u << 20), BudgetError);
}

}  // namespace
}  // namespace remaps::sphere
