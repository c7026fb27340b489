#include "remaps/sphere/surface_components.h"

#include <gtest/gtest.h>

#include "remaps/base/errors.h"
#include "support/shapes.h"

namespace remaps::sphere {
namespace {

SurfaceComponents components_of(const test::Shape& shape) {
  return find_components(shape.position.size(), shape.triangle);
}

TEST(SurfaceComponents, CountGenusAndLoops) {
  for (const test::Shape& shape : test::all_shapes()) {
    if (shape.components != 1) continue;
    SCOPED_TRACE(shape.name);
    const SurfaceComponents found = components_of(shape);
    ASSERT_EQ(found.component.size(), 1u);
    const SurfaceComponent& c = found.component[0];
    EXPECT_EQ(c.faces, shape.triangle.size());
    EXPECT_EQ(c.vertices, shape.position.size());
    EXPECT_EQ(c.euler_characteristic, shape.euler_characteristic);
    EXPECT_EQ(c.boundary_loops, static_cast<std::uint64_t>(shape.boundary_loops));
    EXPECT_EQ(c.genus(), (2 - shape.euler_characteristic - shape.boundary_loops) / 2);
    EXPECT_EQ(c.is_sphere(), shape.euler_characteristic == 2);
  }
}

TEST(SurfaceComponents, TheLargestIsFirst) {
  const test::Shape shape = test::together(test::octahedron(), test::torus(6, 7));
  const SurfaceComponents found = components_of(shape);
  ASSERT_EQ(found.component.size(), 2u);
  EXPECT_EQ(found.component[0].faces, 84u);
  EXPECT_EQ(found.component[0].genus(), 1);
  EXPECT_EQ(found.component[1].faces, 8u);
  EXPECT_TRUE(found.component[1].is_sphere());
  for (std::size_t f = 0; f < shape.triangle.size(); ++f) {
    EXPECT_EQ(found.of_face[f], f < 8 ? 1u : 0u);
  }
  // Of equal ones the first face decides.
  const SurfaceComponents equal =
      components_of(test::together(test::octahedron(), test::octahedron()));
  EXPECT_EQ(equal.of_face.front(), 0u);
  EXPECT_EQ(equal.of_face.back(), 1u);
}

TEST(SurfaceComponents, RefusesWhatIsNotManifold) {
  test::Shape shape = test::octahedron();
  shape.triangle.push_back(shape.triangle.front());
  EXPECT_THROW(components_of(shape), GeometryError);
}

}  // namespace
}  // namespace remaps::sphere
