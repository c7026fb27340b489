#include "remaps/codec/geometry_code.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codec/semi_regular_shapes.h"

namespace remaps::codec {
namespace {

constexpr Wavelet kWavelets[] = {Wavelet::kButterfly, Wavelet::kLiftedButterfly, Wavelet::kLoop};

TEST(GeometryCode, DetailsGiveBackThePositions) {
  for (const test::CodecBase& base : test::codec_bases()) {
    SCOPED_TRACE(base.name);
    const SemiRegularMesh mesh = test::rough_mesh(base, 3, 0.05, 4);
    MemoryBudget budget(test::kCodecMemory);
    const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
    for (const Wavelet wavelet : kWavelets) {
      SemiRegularMesh again = mesh;
      to_details(hierarchy, wavelet, again.position, nullptr);
      from_details(hierarchy, wavelet, mesh.levels, again.position);
      EXPECT_LT(test::largest_distance(again, mesh), 1e-11 * test::diagonal_of(mesh));
    }
  }
}

TEST(GeometryCode, FlatSurfacesHaveNoNormalDetails) {
  test::CodecBase flat = test::base_of(test::disk(3));
  for (Vec3& p : flat.position) p = {p.x, p.y, 0.5 * p.x - p.y};
  SemiRegularMesh mesh = test::rough_mesh(flat, 3, 0, 4);
  std::mt19937_64 random(1);
  for (Vec3& p : mesh.position) {
    const double slide = 0.01 * std::generate_canonical<double, 53>(random);
    p = p + slide * Vec3{1, 0, 0.5};
  }
  MemoryBudget budget(test::kCodecMemory);
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  to_details(hierarchy, Wavelet::kButterfly, mesh.position, nullptr);
  for (std::uint32_t v = mesh.base_vertices; v < mesh.position.size(); ++v) {
    EXPECT_LT(std::fabs(mesh.position[v].x), 1e-12);
  }
}

TEST(GeometryCode, RoundsWithinHalfAStep) {
  const SemiRegularMesh mesh = test::rough_mesh(test::base_of(test::octahedron()), 3, 0.1, 4);
  MemoryBudget budget(test::kCodecMemory);
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  std::mt19937_64 random(2);
  const std::vector<Vec3> values = test::random_values(mesh.position.size(), random);
  Quantization q;
  q.planes = 20;
  q.step = 1e-4;
  Coefficients coefficients;
  quantize(hierarchy, q, values, coefficients);
  const std::vector<Vec3> rounded = dequantize(hierarchy, q, mesh.levels, coefficients);
  std::uint32_t v = 0;
  for (unsigned m = 0; m <= mesh.levels; ++m) {
    for (; v < hierarchy.vertices(m); ++v) {
      const Vec3 error = rounded[v] - values[v];
      // Small ones become 0, which is a step away at most.
      EXPECT_LE(std::fabs(error.x), q.step_of(m, 0));
      EXPECT_LE(std::fabs(error.y), q.step_of(m, 1));
      EXPECT_LE(std::fabs(error.z), q.step_of(m, 2));
      if (coefficients.magnitude[v][0] != 0) {
        EXPECT_LE(std::fabs(error.x), 0.501 * q.step_of(m, 0));
      }
    }
  }
}

TEST(GeometryCode, StepsGrowWithTheLevel) {
  Quantization q;
  q.step = 2;
  q.level_ratio = 96;
  q.tangential = 64;
  EXPECT_DOUBLE_EQ(q.step_of(0, 0), 2);
  EXPECT_DOUBLE_EQ(q.step_of(0, 2), 2);
  EXPECT_DOUBLE_EQ(q.step_of(1, 0), 2);
  EXPECT_DOUBLE_EQ(q.step_of(1, 1), 8);
  EXPECT_DOUBLE_EQ(q.step_of(3, 0), 4.5);
  EXPECT_DOUBLE_EQ(q.step_of(3, 1), 18);
}

TEST(GeometryCode, CellsHoldTheirPositions) {
  const BaseGrid grid{{-3, 1e3, 7}, 0.125};
  std::mt19937_64 random(5);
  for (const Vec3& p : test::random_values(1000, random)) {
    const Vec3 error = grid.centre_of(grid.cell_of(grid.origin + p)) - (grid.origin + p);
    EXPECT_LE(std::max({std::fabs(error.x), std::fabs(error.y), std::fabs(error.z)}),
              0.0625 + 1e-9);
  }
}

}  // namespace
}  // namespace remaps::codec
