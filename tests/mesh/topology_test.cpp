#include "remaps/mesh/topology.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "support/cut_shape.h"
#include "support/surface_check.h"
#include "support/temp_files.h"

namespace remaps {
namespace {

using test::Shape;

class TopologyCounterTest : public test::TempFiles,
                            public testing::WithParamInterface<std::size_t> {
 protected:
  Topology count_cut(const Shape& shape, std::size_t segments) {
    const auto domain = test::cut_shape(shape, segments, 0, directory(), budget_);
    TopologyCounter counter(directory(), shape.position.size(), 1 << 16, budget_);
    VertexIndex scratch;
    Segment s;
    Patch patch;
    std::vector<FaceLink> origin;
    for (std::size_t i = 0; i < segments; ++i) {
      domain->load(i, scratch, s, origin);
      const ManifoldDefect defect = patch.build(s.vertex_id.size(), s.own_vertices, s.triangle);
      EXPECT_EQ(defect.kind, ManifoldDefect::Kind::kNone);
      counter.add(count_segment(s, patch));
    }
    return counter.finish();
  }

  MemoryBudget budget_{std::uint64_t{64} << 20};
};

/// A grid of n x n squares without those where `hole`.
template <class Hole>
Shape sheet(unsigned n, Hole&& hole) {
  Shape s{"sheet", {}, {}};
  for (unsigned i = 0; i <= n; ++i) {
    for (unsigned j = 0; j <= n; ++j) s.position.push_back({double(i), double(j), 0.1 * (i % 3)});
  }
  for (unsigned i = 0; i < n; ++i) {
    for (unsigned j = 0; j < n; ++j) {
      if (hole(i, j)) continue;
      const LocalIndex a = i * (n + 1) + j;
      s.triangle.push_back({a, a + n + 1, a + n + 2});
      s.triangle.push_back({a, a + n + 2, a + 1});
    }
  }
  return s;
}

void expect_same(const Topology& a, const Topology& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.boundary_edges, b.boundary_edges);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.boundary_loops, b.boundary_loops);
}

Topology from_scratch(const Shape& shape) {
  std::vector<Triangle> triangles;
  for (const LocalTriangle& t : shape.triangle) triangles.push_back({t[0], t[1], t[2]});
  return test::count_surface(triangles).topology;
}

TEST_P(TopologyCounterTest, CountsInPiecesAsInOne) {
  std::vector<Shape> shapes = test::all_shapes();
  shapes.push_back(test::icosphere(3));
  shapes.push_back(
      test::together(test::torus(12, 9), test::together(test::disk(5), test::tetrahedron())));
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(shape.name);
    const Topology counted = count_cut(shape, GetParam());
    expect_same(counted, from_scratch(shape));
    EXPECT_EQ(counted.euler_characteristic(), shape.euler_characteristic);
    EXPECT_EQ(counted.components, static_cast<std::uint64_t>(shape.components));
    EXPECT_EQ(counted.boundary_loops, static_cast<std::uint64_t>(shape.boundary_loops));
  }
}

TEST_P(TopologyCounterTest, CountsHolesThatManySegmentsTouch) {
  const Shape holes = sheet(20, [](unsigned i, unsigned j) {
    return (i % 6 == 2 && j % 5 == 3) || (i == 10 && j > 3 && j < 17);
  });
  const Topology counted = count_cut(holes, GetParam());
  expect_same(counted, from_scratch(holes));
  EXPECT_GT(counted.boundary_loops, 10u);
}

TEST_P(TopologyCounterTest, CountsStripsThatWindThroughManySegments) {
  // Every second row gone: ten components, each through all segments across it.
  const Shape strips = sheet(19, [](unsigned i, unsigned) { return i % 2 == 1; });
  const Topology counted = count_cut(strips, GetParam());
  expect_same(counted, from_scratch(strips));
  EXPECT_EQ(counted.components, 10u);
  EXPECT_EQ(counted.boundary_loops, 10u);
}

TEST_P(TopologyCounterTest, LeavesOutVerticesWithoutFaces) {
  Shape shape = test::icosphere(2);
  shape.position.push_back({0.1, 0.2, 0.3});
  shape.position.push_back({3, 3, 3});
  EXPECT_EQ(count_cut(shape, GetParam()).vertices, shape.position.size() - 2);
}

INSTANTIATE_TEST_SUITE_P(Segments, TopologyCounterTest, testing::Values(1u, 3u, 17u));

TEST(Topology, KnowsTheEulerCharacteristic) {
  EXPECT_EQ((Topology{4, 4, 0, 1, 0}.euler_characteristic()), 2);
  EXPECT_EQ((Topology{3, 1, 3, 1, 1}.euler_characteristic()), 1);
  EXPECT_EQ((Topology{7, 14, 0, 1, 0}.euler_characteristic()), 0);
}

class LabelJoinTest : public test::TempFiles {};

TEST_F(LabelJoinTest, RefusesMoreLabelsThan32BitsTell) {
  MemoryBudget budget(1 << 20);
  LabelJoin join(directory() / "labels", 100, 1 << 12, budget);
  join.add(10, {});
  EXPECT_THROW(join.add(kNoIndex - 9, {}), GeometryError);
  EXPECT_EQ(join.finish(), 10u);
}

TEST_F(LabelJoinTest, JoinsLabelsThatShareAVertex) {
  MemoryBudget budget(1 << 20);
  LabelJoin join(directory() / "labels", 100, 1 << 12, budget);
  using Shared = std::vector<std::pair<VertexId, std::uint32_t>>;
  join.add(3, Shared{{10, 0}, {11, 1}});           // 0 1 2
  join.add(2, Shared{{11, 0}, {12, 0}, {13, 1}});  // 3 4: 3 joins 1
  join.add(0, Shared{});
  join.add(1, Shared{{10, 0}, {13, 0}});  // 5 joins 0 and 4
  EXPECT_EQ(join.finish(), 3u);           // {0, 4, 5} {1, 3} {2}
}

}  // namespace
}  // namespace remaps
