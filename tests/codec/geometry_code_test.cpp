#include "remaps/codec/geometry_code.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codec/semi_regular_shapes.h"

namespace remaps::codec {
namespace {

constexpr Wavelet kWavelets[] = {Wavelet::kButterfly, Wavelet::kLiftedButterfly, Wavelet::kLoop};

struct Coded {
  Coefficients coefficients;
  std::vector<Vec3> decoded;
};

/// Rounds the details of a mesh, and decodes them.
Coded code(const SubdivisionHierarchy& hierarchy, Wavelet wavelet, const Quantization& q,
           std::vector<Vec3> position) {
  Coded result;
  to_details(hierarchy, wavelet, q, position, nullptr);
  const std::vector<Vec3> centre(hierarchy.vertices(0), Vec3{});
  quantize_details(hierarchy, wavelet, q, centre, position, result.coefficients, nullptr);
  result.decoded = dequantize(hierarchy, q, hierarchy.levels(), result.coefficients);
  from_details(hierarchy, wavelet, hierarchy.levels(), result.decoded);
  return result;
}

TEST(GeometryCode, DetailsGiveBackThePositions) {
  for (const test::CodecBase& base : test::codec_bases()) {
    SCOPED_TRACE(base.name);
    const SemiRegularMesh mesh = test::rough_mesh(base, 3, 0.05, 4);
    MemoryBudget budget(test::kCodecMemory);
    const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
    Quantization q;
    q.planes = 30;
    q.step = 1e-8 * test::diagonal_of(mesh);
    for (const Wavelet wavelet : kWavelets) {
      SemiRegularMesh again = mesh;
      again.position = code(hierarchy, wavelet, q, mesh.position).decoded;
      EXPECT_LT(test::largest_distance(again, mesh), 100 * q.step);
    }
  }
}

/// Where the surface is folded, the smallest change of the coarse surface turns the axes of its
/// edges far: the decoder's are others than the surface's own.
TEST(GeometryCode, TurnedAxesCostNothing) {
  test::CodecBase folded = test::base_of(test::octahedron());
  SemiRegularMesh mesh = test::rough_mesh(folded, 2, 0.3, 4);
  // Slivers: all is nearly on a line.
  for (Vec3& p : mesh.position) p = {p.x, 3e-3 * p.y, 3e-3 * p.z};
  std::mt19937_64 random(3);
  for (Vec3& p : mesh.position) {
    const double out = std::generate_canonical<double, 53>(random);
    p = p + 0.3 * out * Vec3{0, 1, 1};
  }
  MemoryBudget budget(test::kCodecMemory);
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  Quantization q;
  q.planes = 16;
  q.step = 1e-3;
  q.tangential = 255;
  SemiRegularMesh again = mesh;
  again.position = code(hierarchy, Wavelet::kButterfly, q, mesh.position).decoded;
  double cells = std::sqrt(3) * q.step;
  for (unsigned m = 1; m <= mesh.levels; ++m) {
    cells += std::hypot(q.step_of(m, 0), q.step_of(m, 1), q.step_of(m, 2));
  }
  EXPECT_LT(test::largest_distance(again, mesh), 2 * cells);
}

TEST(GeometryCode, SaysTheLargestDetail) {
  const SemiRegularMesh mesh = test::rough_mesh(test::base_of(test::octahedron()), 3, 0.1, 4);
  MemoryBudget budget(test::kCodecMemory);
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  Quantization q;
  q.planes = 30;
  q.step = 1e-6;
  std::vector<Vec3> details = mesh.position;
  const double largest = to_details(hierarchy, Wavelet::kLiftedButterfly, q, details, nullptr);
  Coefficients coefficients;
  const std::vector<Vec3> centre(hierarchy.vertices(0), Vec3{});
  const double along_decoders = quantize_details(hierarchy, Wavelet::kLiftedButterfly, q, centre,
                                                 details, coefficients, nullptr);
  EXPECT_NEAR(along_decoders, largest, 1e-3 * largest);
  std::uint32_t most = 0;
  for (std::uint32_t v = hierarchy.vertices(0); v < hierarchy.vertices(); ++v) {
    const auto& m = coefficients.magnitude[v];
    most = std::max({most, m[0], m[1], m[2]});
  }
  EXPECT_EQ(most, std::floor(along_decoders));
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
  Quantization q;
  q.planes = 30;
  q.step = 1e-7;
  const Coefficients coefficients =
      code(hierarchy, Wavelet::kButterfly, q, mesh.position).coefficients;
  for (std::uint32_t v = mesh.base_vertices; v < mesh.position.size(); ++v) {
    EXPECT_LE(coefficients.magnitude[v][0], 2) << v;
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
