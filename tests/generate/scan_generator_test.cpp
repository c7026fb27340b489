#include "remaps/generate/scan_generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

struct Mesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

Mesh collect(const ScanGenerator& generator, unsigned threads = 1) {
  Mesh mesh;
  generator.positions(
      [&](std::span<const Vec3> chunk) {
        mesh.positions.insert(mesh.positions.end(), chunk.begin(), chunk.end());
      },
      threads);
  generator.triangles(
      [&](std::span<const Triangle> chunk) {
        mesh.triangles.insert(mesh.triangles.end(), chunk.begin(), chunk.end());
      },
      threads);
  return mesh;
}

/// Half-edges of an oriented manifold: each at most once. The value counts.
std::map<std::pair<VertexId, VertexId>, int> half_edges(const Mesh& mesh) {
  std::map<std::pair<VertexId, VertexId>, int> counts;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++counts[{t[k], t[(k + 1) % 3]}];
  return counts;
}

struct ShapeCase {
  const char* name;
  BaseShape shape;
  std::int64_t euler;
  bool closed;
};

constexpr ShapeCase kCases[] = {{"icosahedron", BaseShape::kIcosahedron, 2, true},
                                {"torus", BaseShape::kTorus, 0, true},
                                {"double-torus", BaseShape::kDoubleTorus, -2, true},
                                {"disk", BaseShape::kDisk, 1, false}};

GeneratorOptions options_for(BaseShape shape, std::uint64_t vertices) {
  GeneratorOptions options;
  options.base = shape;
  options.vertices = vertices;
  options.jitter = 1;
  options.flip_fraction = 1;
  return options;
}

TEST(ScanGenerator, MakesOrientedManifoldsOfTheExpectedTopology) {
  for (const ShapeCase& c : kCases) {
    for (const std::uint64_t vertices : {0u, 100u, 300u, 1000u, 20'000u}) {
      SCOPED_TRACE(testing::Message() << c.name << " " << vertices);
      const ScanGenerator generator(options_for(c.shape, vertices));
      const Mesh mesh = collect(generator);
      ASSERT_EQ(mesh.positions.size(), generator.vertices());
      ASSERT_EQ(mesh.triangles.size(), generator.faces());

      const auto counts = half_edges(mesh);
      std::int64_t border = 0;
      for (const auto& [edge, count] : counts) {
        ASSERT_EQ(count, 1);
        if (!counts.contains({edge.second, edge.first})) ++border;
      }
      EXPECT_EQ(border == 0, c.closed);
      const auto edges = (static_cast<std::int64_t>(counts.size()) + border) / 2;
      EXPECT_EQ(static_cast<std::int64_t>(generator.vertices()) - edges +
                    static_cast<std::int64_t>(generator.faces()),
                c.euler);
    }
  }
}

TEST(ScanGenerator, HasIrregularValences) {
  const Mesh mesh = collect(ScanGenerator(options_for(BaseShape::kTorus, 20'000)));
  std::map<VertexId, int> valences;
  for (const auto& [edge, count] : half_edges(mesh)) ++valences[edge.first];
  std::map<int, int> histogram;
  for (const auto& [vertex, valence] : valences) ++histogram[valence];
  EXPECT_GE(histogram.begin()->first, 3);
  EXPECT_LE(histogram.rbegin()->first, 12);
  EXPECT_LT(histogram[6], 10'000);
  EXPECT_GT(histogram[4] + histogram[8], 1000);
}

Vec3 doubled_area(const ScanGenerator& generator, FaceId f) {
  const Triangle t = generator.triangle(f);
  const Vec3 a = generator.vertex(t[0]);
  return cross(generator.vertex(t[1]) - a, generator.vertex(t[2]) - a);
}

TEST(ScanGenerator, FlipsNoTriangleOver) {
  GeneratorOptions options;
  options.base =
      ShapeMesh{{{0, 0, 0}, {1, 0, 0}, {0.5, 0.8, 0}, {1.5, 0.9, 0}}, {{0, 1, 2}, {1, 3, 2}}};
  options.vertices = 50'000;
  options.amplitude = 0;
  options.jitter = 1;
  options.flip_fraction = 1;
  const ScanGenerator generator(options);
  double sum = 0;
  for (FaceId f = 0; f < generator.faces(); ++f) {
    const double area = doubled_area(generator, f).z;
    ASSERT_GT(area, 0) << f;
    sum += area;
  }
  EXPECT_NEAR(sum, 0.8 + 0.85, 1e-9);
}

TEST(ScanGenerator, LeavesNoTriangleDegenerate) {
  for (const ShapeCase& c : kCases) {
    const ScanGenerator generator(options_for(c.shape, 20'000));
    const double mean = 1.0 / static_cast<double>(generator.faces());
    for (FaceId f = 0; f < generator.faces(); ++f)
      ASSERT_GT(norm(doubled_area(generator, f)), 0.01 * mean) << c.name << " face " << f;
  }
}

TEST(ScanGenerator, ShuffledIsTheSameSurfaceInAnotherOrder) {
  GeneratorOptions options = options_for(BaseShape::kDoubleTorus, 5000);
  const Mesh coherent = collect(ScanGenerator(options));
  options.shuffled = true;
  const Mesh shuffled = collect(ScanGenerator(options));

  const auto corners = [](const Mesh& mesh) {
    std::vector<std::vector<double>> result;
    for (const Triangle& t : mesh.triangles) {
      std::vector<double>& row = result.emplace_back();
      for (const VertexId v : t) {
        const Vec3& p = mesh.positions.at(v);
        row.insert(row.end(), {p.x, p.y, p.z});
      }
    }
    std::sort(result.begin(), result.end());
    return result;
  };
  EXPECT_EQ(corners(coherent), corners(shuffled));
  EXPECT_NE(coherent.positions, shuffled.positions);
  EXPECT_NE(coherent.triangles, shuffled.triangles);
}

TEST(ScanGenerator, CoherentOrderIsLocal) {
  const ScanGenerator generator(options_for(BaseShape::kIcosahedron, 200'000));
  const double row = std::sqrt(static_cast<double>(generator.vertices()) / 10);
  std::uint64_t near = 0;
  for (FaceId f = 0; f < generator.faces(); ++f) {
    const auto [low, high] = std::ranges::minmax(generator.triangle(f));
    near += static_cast<double>(high - low) <= 2 * row ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(near), 0.95 * static_cast<double>(generator.faces()));
}

TEST(ScanGenerator, StreamsWhatRandomAccessGives) {
  GeneratorOptions options = options_for(BaseShape::kIcosahedron, 100'000);
  for (const bool shuffled : {false, true}) {
    options.shuffled = shuffled;
    const ScanGenerator generator(options);
    const Mesh mesh = collect(generator);
    const Mesh parallel = collect(ScanGenerator(options), 3);
    EXPECT_EQ(mesh.positions, parallel.positions);
    EXPECT_EQ(mesh.triangles, parallel.triangles);
    for (VertexId v = 0; v < generator.vertices(); ++v)
      ASSERT_EQ(mesh.positions[v], generator.vertex(v));
    for (FaceId f = 0; f < generator.faces(); ++f)
      ASSERT_EQ(mesh.triangles[f], generator.triangle(f));
  }
}

TEST(ScanGenerator, DependsOnTheSeed) {
  GeneratorOptions options = options_for(BaseShape::kIcosahedron, 1000);
  const Mesh one = collect(ScanGenerator(options));
  options.seed = 2;
  const Mesh two = collect(ScanGenerator(options));
  EXPECT_NE(one.positions, two.positions);
  EXPECT_NE(one.triangles, two.triangles);
}

TEST(ScanGenerator, JoinsTrianglesBeyond32Bits) {
  for (const ShapeCase& c : kCases) {
    GeneratorOptions options = options_for(c.shape, 20'000'000'000);
    options.shuffled = true;
    const ScanGenerator shuffled(options);
    options.shuffled = false;
    const ScanGenerator generator(options);
    ASSERT_GT(generator.vertices(), std::uint64_t{1} << 34);
    for (std::uint64_t sample = 0; sample < 200; ++sample) {
      // Faces in a window cover a stretch of a strip: its inner edges occur in both directions.
      const FaceId first = generator.faces() / 200 * sample;
      std::set<std::pair<VertexId, VertexId>> edges;
      std::size_t joined = 0;
      for (FaceId f = first; f < first + 60; ++f) {
        const Triangle t = generator.triangle(f);
        for (std::size_t k = 0; k < 3; ++k) {
          ASSERT_LT(t[k], generator.vertices());
          ASSERT_TRUE(edges.insert({t[k], t[(k + 1) % 3]}).second);
          joined += edges.count({t[(k + 1) % 3], t[k]});
        }
        for (const VertexId v : shuffled.triangle(f)) ASSERT_LT(v, generator.vertices());
      }
      EXPECT_GE(joined, 30u) << c.name << " face " << first;
    }
  }
}

TEST(ScanGenerator, TakesAnyBaseMesh) {
  GeneratorOptions options;
  options.base = ShapeMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  options.vertices = 10'000;
  const Mesh mesh = collect(ScanGenerator(options));
  for (const auto& [edge, count] : half_edges(mesh)) ASSERT_EQ(count, 1);
}

TEST(ScanGenerator, RefusesOptionsOutOfRange) {
  const auto build = [](auto change) {
    GeneratorOptions options;
    change(options);
    ScanGenerator generator(options);
  };
  EXPECT_THROW(build([](auto& o) { o.jitter = 1.5; }), std::invalid_argument);
  EXPECT_THROW(build([](auto& o) { o.flip_fraction = -0.1; }), std::invalid_argument);
  EXPECT_THROW(build([](auto& o) { o.octaves = 0; }), std::invalid_argument);
  EXPECT_THROW(build([](auto& o) { o.vertices = ~std::uint64_t{0}; }), GeometryError);
}

}  // namespace
}  // namespace remaps
