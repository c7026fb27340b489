#include "remaps/generate/patch_grid.h"

#include <gtest/gtest.h>

#include <set>

#include "remaps/base/errors.h"
#include "remaps/generate/base_shapes.h"

namespace remaps {
namespace {

constexpr BaseShape kShapes[] = {BaseShape::kIcosahedron, BaseShape::kTorus,
                                 BaseShape::kDoubleTorus, BaseShape::kDisk};

PatchGrid make_grid(const ShapeMesh& base, std::uint64_t n) {
  return {base.triangles, base.positions.size(), n};
}

TEST(PatchGrid, NumbersEveryGridPointOfItsOwnerOnce) {
  for (const BaseShape shape : kShapes) {
    const ShapeMesh base = make_base_mesh(shape);
    for (const std::uint64_t n : {1u, 2u, 3u, 4u, 7u, 16u}) {
      const PatchGrid grid = make_grid(base, n);
      for (VertexId v = 0; v < grid.vertices(); ++v) ASSERT_EQ(grid.vertex(grid.point(v)), v);
      std::set<VertexId> seen;
      for (std::uint64_t face = 0; face < base.triangles.size(); ++face) {
        for (std::uint64_t row = 0; row <= n; ++row)
          for (std::uint64_t column = 0; column <= row; ++column)
            seen.insert(grid.vertex({face, row, column}));
      }
      EXPECT_EQ(seen.size(), grid.vertices());
      EXPECT_EQ(*seen.rbegin(), grid.vertices() - 1);
    }
  }
}

TEST(PatchGrid, NumbersEveryTriangleOnce) {
  const PatchGrid grid = make_grid(make_base_mesh(BaseShape::kDisk), 9);
  for (FaceId f = 0; f < grid.faces(); ++f) ASSERT_EQ(grid.face(grid.triangle(f)), f);
}

TEST(PatchGrid, FindsTheNearestDivision) {
  const ShapeMesh base = make_base_mesh(BaseShape::kIcosahedron);  // 10 n^2 + 2 vertices
  const auto nearest = [&](std::uint64_t target) {
    return PatchGrid::nearest_n(base.triangles, base.positions.size(), target);
  };
  EXPECT_EQ(nearest(0), 1u);
  EXPECT_EQ(nearest(12), 1u);
  EXPECT_EQ(nearest(26), 1u);
  EXPECT_EQ(nearest(28), 2u);
  EXPECT_EQ(nearest(1002), 10u);
  EXPECT_EQ(nearest(10'000'000'000'000u), 1'000'000u);
}

TEST(PatchGrid, InvertsItsNumberingBeyond32Bits) {
  const ShapeMesh base = make_base_mesh(BaseShape::kTorus);
  const PatchGrid grid = make_grid(base, 3'000'000);
  ASSERT_GT(grid.vertices(), std::uint64_t{1} << 48);
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const VertexId v = grid.vertices() / 5000 * i + i;
    ASSERT_EQ(grid.vertex(grid.point(v)), v);
    const FaceId f = grid.faces() / 5000 * i + i;
    ASSERT_EQ(grid.face(grid.triangle(f)), f);
  }
  EXPECT_EQ(grid.vertex(grid.point(grid.vertices() - 1)), grid.vertices() - 1);
  EXPECT_EQ(grid.face(grid.triangle(grid.faces() - 1)), grid.faces() - 1);
}

TEST(PatchGrid, RefusesABaseThatIsNoOrientedManifold) {
  const auto build = [](std::vector<Triangle> base) { PatchGrid(base, 4, 2); };
  EXPECT_THROW(build({}), GeometryError);
  EXPECT_THROW(build({{0, 1, 4}}), GeometryError);             // no such vertex
  EXPECT_THROW(build({{0, 1, 1}, {0, 2, 3}}), GeometryError);  // a corner twice
  EXPECT_THROW(build({{0, 1, 2}}), GeometryError);             // vertex 3 unused
  EXPECT_THROW(build({{0, 1, 2}, {0, 1, 3}}), GeometryError);  // not oriented alike
  EXPECT_NO_THROW(build({{0, 1, 2}, {1, 0, 3}}));
}

}  // namespace
}  // namespace remaps
