#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/welded_lists.h"
#include "remaps/pipeline/remesh.h"
#include "support/attribute_files.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::AttributeLists;
using test::MeshLists;

constexpr ScalarType kFloat = ScalarType::float32;

AttributeSpec of_vertices(const std::string& name, AttributeKind kind,
                          std::initializer_list<const char*> components, ScalarType type) {
  AttributeSpec spec{name, kind, AttributePer::vertex, {}, false};
  for (const char* component : components) spec.components.push_back({component, type});
  return spec;
}

/// A scan each face of which has vertices of its own, as glTF has them along seams. Its vertices
/// carry their coordinates, the direction in which they lie, and texture coordinates of two charts:
/// faces on one side of x = 0 are `kApart` from the others.
class WeldAttributes : public test::TempFiles {
 protected:
  static constexpr double kApart = 100;

  void put(const std::string& name) const {
    const MeshLists soup = test::soup_of(test::lists_of(test::icosphere(5)));
    const auto value = [&](std::size_t v, std::size_t channel) {
      const Vec3& p = soup.position[v];
      const Vec3 out = 1 / norm(p) * p;
      const std::size_t face = v / 3 * 3;
      const double side =
          soup.position[face].x + soup.position[face + 1].x + soup.position[face + 2].x;
      const double values[] = {
          p.z, double(face % 7), out.x, out.y, out.z, p.x + (side > 0 ? kApart : 0), p.y, p.x, p.y,
          p.z};
      return values[channel];
    };
    write_with_attributes(
        soup,
        {of_vertices("height", AttributeKind::scalar, {"height"}, kFloat),
         of_vertices("part", AttributeKind::label, {"part"}, ScalarType::int32),
         of_vertices("normal", AttributeKind::normal, {"nx", "ny", "nz"}, kFloat),
         of_vertices("uv", AttributeKind::uv, {"s", "t"}, kFloat),
         of_vertices("colour", AttributeKind::colour, {"red", "green", "blue"}, kFloat)},
        {value, {}, {}}, directory() / name);
  }
  RemeshOptions job() const {
    put("in.ply");
    RemeshOptions o = test::remesh_options(directory(), directory() / "in.ply");
    o.weld_distance = 0;
    o.level = 3;
    return o;
  }
  static Report run(const RemeshOptions& options) {
    Progress progress;
    return remesh(options, progress);
  }
};

TEST_F(WeldAttributes, ComeAlongAndSeamsStay) {
  const RemeshOptions o = job();
  const Report report = run(o);
  EXPECT_GT(report.repairs.welded_vertices, 0u);
  const MeshLists mesh = test::read_lists(o.output);
  const AttributeLists found = test::read_attributes(o.output);
  double size = 0;
  for (const Vec3& p : mesh.position) size = std::max(size, norm(p));
  const auto height = found.column("height"), red = found.column("colour", 0),
             nx = found.column("normal", 0), ny = found.column("normal", 1),
             nz = found.column("normal", 2);
  ASSERT_EQ(height.size(), mesh.position.size());
  ASSERT_EQ(nx.size(), mesh.position.size());
  for (std::size_t v = 0; v < mesh.position.size(); ++v) {
    EXPECT_NEAR(height[v], mesh.position[v].z, 1e-6 * size);
    EXPECT_NEAR(red[v], mesh.position[v].x, 1e-6 * size);
    const Vec3 normal{nx[v], ny[v], nz[v]};
    EXPECT_NEAR(norm(normal), 1, 1e-6);
    EXPECT_GT(dot(normal, mesh.position[v]), 0.99 * norm(mesh.position[v]));
  }
  // Texture coordinates are those of corners now, and every face lies in one chart.
  ASSERT_NE(found.find("uv"), nullptr);
  EXPECT_EQ(found.find("uv")->per, AttributePer::corner);
  const auto u = found.column("uv", 0);
  ASSERT_EQ(u.size(), 3 * mesh.triangle.size());
  std::size_t charts[2] = {0, 0}, exact = 0;
  for (std::size_t f = 0; f < mesh.triangle.size(); ++f) {
    const bool far = u[3 * f] > kApart / 2;
    ++charts[far];
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(u[3 * f + k] > kApart / 2, far) << "face " << f;
      const double own = u[3 * f + k] - (far ? kApart : 0);
      exact += std::fabs(own - mesh.position[mesh.triangle[f][k]].x) < 1e-5 * kApart;
    }
  }
  EXPECT_GT(charts[0], mesh.triangle.size() / 4);
  EXPECT_GT(charts[1], mesh.triangle.size() / 4);
  // But for faces that lie across the seam, which one chart foretells.
  EXPECT_GT(double(exact), 0.97 * double(u.size()));
}

TEST_F(WeldAttributes, AreTheSameInLittleMemory) {
  RemeshOptions o = job();
  run(o);
  const AttributeLists large = test::read_attributes(o.output);
  RemeshOptions little = o;
  little.memory_bytes = 24 << 20;
  little.output = directory() / "little.ply";
  little.bundle.clear();
  run(little);
  const AttributeLists small = test::read_attributes(little.output);
  EXPECT_EQ(large.vertex, small.vertex);
  EXPECT_EQ(large.corner, small.corner);
}

/// A label is that of the first of the vertices that became one.
TEST_F(WeldAttributes, FirstVerticesDecideOfLabels) {
  MeshLists soup;
  soup.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  soup.triangle = {{0, 1, 2}, {3, 4, 5}};
  write_with_attributes(
      soup, {of_vertices("part", AttributeKind::label, {"part"}, ScalarType::int32)},
      {[](std::size_t v, std::size_t) { return double(v); }, {}, {}}, directory() / "in.ply");
  RemeshOptions o = test::remesh_options(directory(), directory() / "in.ply");
  o.weld_distance = 0;
  o.base_vertices = 4;
  o.level = 0;
  run(o);
  std::vector<double> part = test::read_attributes(o.output).column("part");
  std::sort(part.begin(), part.end());
  EXPECT_EQ(part, (std::vector<double>{0, 1, 2, 4}));
}

}  // namespace
}  // namespace remaps::pipeline
