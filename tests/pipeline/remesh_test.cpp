#include "remaps/pipeline/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/map_file.h"
#include "remaps/resample/dyadic_grid.h"
#include "support/remesh_job.h"
#include "support/surface_check.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::MeshLists;

class RemeshTest : public test::TempFiles {
 protected:
  std::filesystem::path put(const MeshLists& mesh, const std::string& name = "in.ply") const {
    test::write_lists(mesh, directory() / name);
    return directory() / name;
  }
  RemeshOptions options(const std::filesystem::path& input) const {
    return test::remesh_options(directory(), input);
  }
  static Report run(const RemeshOptions& options) {
    Progress progress;
    return remesh(options, progress);
  }
  std::vector<MapRecord> map_records(const std::filesystem::path& bundle) const {
    const std::string bytes = bytes_of(bundle / kMapName);
    std::vector<MapRecord> records(bytes.size() / sizeof(MapRecord));
    std::memcpy(records.data(), bytes.data(), records.size() * sizeof(MapRecord));
    return records;
  }
  /// All files that a run made, by name.
  std::map<std::string, std::string> contents(const RemeshOptions& o) const {
    std::map<std::string, std::string> result{{"output", bytes_of(o.output)}};
    for (const auto& entry : std::filesystem::directory_iterator(o.bundle)) {
      result[entry.path().filename()] = bytes_of(entry.path());
    }
    return result;
  }
  void expect_valid(const RemeshOptions& o, const Report& report, const MeshLists& input) const;
};

Topology kind_of(const std::vector<Triangle>& triangles) {
  const test::CountedSurface counted = test::count_surface(triangles);
  EXPECT_EQ(counted.defect, "");
  return counted.topology;
}

void expect_same_kind(const Topology& a, const Topology& b) {
  EXPECT_EQ(a.euler_characteristic(), b.euler_characteristic());
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.boundary_loops, b.boundary_loops);
}

/// What holds of every run: the base and the output are of the input's kind, base vertices are
/// input vertices, every vertex has its place in map.bin, and the report says so.
void RemeshTest::expect_valid(const RemeshOptions& o, const Report& report,
                              const MeshLists& input) const {
  const Topology kind = kind_of(input.triangle);
  EXPECT_EQ(report.input_vertices, input.position.size());
  EXPECT_EQ(report.input_faces, input.triangle.size());
  EXPECT_EQ(report.components, kind.components);
  EXPECT_EQ(report.boundary_loops, kind.boundary_loops);
  EXPECT_EQ(report.euler_characteristic, kind.euler_characteristic());
  EXPECT_EQ(report.repairs.unreferenced_vertices, input.position.size() - kind.vertices);

  const MeshLists output = test::read_lists(o.output);
  EXPECT_EQ(report.output_vertices, output.position.size());
  EXPECT_EQ(report.output_faces, output.triangle.size());
  const Topology output_kind = kind_of(output.triangle);
  expect_same_kind(output_kind, kind);
  EXPECT_EQ(output_kind.vertices, output.position.size());

  const MeshLists base = test::read_lists(o.bundle / kBaseName);
  EXPECT_EQ(report.base_vertices, base.position.size());
  EXPECT_EQ(report.base_faces, base.triangle.size());
  EXPECT_LE(base.position.size(), std::max<std::uint64_t>(o.base_vertices, 4));
  expect_same_kind(kind_of(base.triangle), kind);
  EXPECT_EQ(output.triangle.size(), base.triangle.size() << (2 * o.level));
  std::set<std::array<double, 3>> places;
  for (const Vec3& p : input.position) places.insert({p.x, p.y, p.z});
  for (std::size_t v = 0; v < base.position.size(); ++v) {
    const Vec3& p = base.position[v];
    EXPECT_TRUE(places.contains({p.x, p.y, p.z})) << "base vertex " << v << " is no input vertex";
    EXPECT_EQ(output.position[v], p);
  }

  std::vector<bool> used(input.position.size(), false);
  for (const Triangle& t : input.triangle)
    for (const VertexId v : t) used[v] = true;
  const std::vector<MapRecord> records = map_records(o.bundle);
  ASSERT_EQ(records.size(), input.position.size());
  for (std::size_t v = 0; v < records.size(); ++v) {
    if (!used[v]) {
      ASSERT_EQ(records[v].face, 0xFFFFFFFFu) << v;
      continue;
    }
    ASSERT_LT(records[v].face, base.triangle.size()) << v;
    ASSERT_GE(records[v].u, 0);
    ASSERT_GE(records[v].v, 0);
    ASSERT_LE(records[v].u + records[v].v, 1 + 1e-6f);
  }
  // Input, output and bundle: no temporary file is left.
  EXPECT_EQ(entries_in(directory()), 3u);
}

struct ScanCase {
  const char* name;
  BaseShape shape;
  std::uint64_t vertices;
};
void PrintTo(const ScanCase& c, std::ostream* out) {
  *out << c.name;
}

class RemeshScans : public RemeshTest, public testing::WithParamInterface<ScanCase> {};

TEST_P(RemeshScans, KeepsTheKindOfTheSurfaceInCore) {
  const MeshLists input = test::scan(GetParam().shape, GetParam().vertices);
  const RemeshOptions o = options(put(input));
  const Report report = run(o);
  expect_valid(o, report, input);
  EXPECT_EQ(report.base_vertices, o.base_vertices);
}

TEST_P(RemeshScans, KeepsTheKindOfTheSurfaceInManySegments) {
  const MeshLists input = test::scan(GetParam().shape, GetParam().vertices, true);
  RemeshOptions o = options(put(input));
  o.domain_buffer = test::kSmallDomainBuffer;
  const Report report = run(o);
  expect_valid(o, report, input);
  EXPECT_EQ(report.base_vertices, o.base_vertices);
  ASSERT_GE(report.sweeps.size(), 2u);
  EXPECT_GE(report.sweeps[0].segments, 8u);
  EXPECT_EQ(report.sweeps.back().segments, 1u);
  EXPECT_EQ(report.sweeps[0].faces_in, input.triangle.size());
  EXPECT_EQ(report.sweeps.back().faces_out, report.base_faces);
  for (std::size_t i = 1; i < report.sweeps.size(); ++i) {
    EXPECT_EQ(report.sweeps[i].faces_in, report.sweeps[i - 1].faces_out);
  }
}

TEST_P(RemeshScans, WritesTheSameBytesForAnyNumberOfThreads) {
  const auto input = put(test::scan(GetParam().shape, GetParam().vertices));
  std::map<std::string, std::string> first;
  for (const unsigned threads : {1u, 2u, 1u, 3u}) {
    SCOPED_TRACE(std::to_string(threads) + " threads");
    RemeshOptions o = options(input);
    o.domain_buffer = test::kSmallDomainBuffer;
    o.map_buffer = 700;
    o.threads = threads;
    run(o);
    const auto made = contents(o);
    if (first.empty()) first = made;
    ASSERT_EQ(made.size(), first.size());
    for (const auto& [name, bytes] : first) EXPECT_TRUE(made.at(name) == bytes) << name;
    std::filesystem::remove_all(o.bundle);
    std::filesystem::remove(o.output);
  }
  EXPECT_TRUE(first.contains(kMapName) && first.contains(kBaseName) && first.contains(kTilesName) &&
              first.contains(log_name(1)));
}

INSTANTIATE_TEST_SUITE_P(Scans, RemeshScans,
                         testing::Values(ScanCase{"Sphere", BaseShape::kIcosahedron, 10'000},
                                         ScanCase{"Torus", BaseShape::kTorus, 6'000},
                                         ScanCase{"DoubleTorus", BaseShape::kDoubleTorus, 6'000},
                                         ScanCase{"Disk", BaseShape::kDisk, 5'000}),
                         [](const auto& test) { return test.param.name; });

TEST_F(RemeshTest, ApproximatesTheInput) {
  RemeshOptions o = options(put(test::scan(BaseShape::kIcosahedron, 20'000)));
  o.level = 3;
  o.measure = true;
  o.samples = 20'000;
  o.threads = 2;
  const Report report = run(o);
  ASSERT_TRUE(report.error.has_value());
  EXPECT_LT(report.error->l2(), 0.01);
  EXPECT_GT(report.error->l2(), 0);
  EXPECT_LT(report.error->max_backward, 0.1);
}

TEST_F(RemeshTest, RunsInAnyMemoryFromTheLeast) {
  const MeshLists input = test::scan(BaseShape::kTorus, 12'000);
  const auto path = put(input);
  for (const std::uint64_t mib : {24u, 40u, 400u}) {
    SCOPED_TRACE(std::to_string(mib) + " MiB");
    RemeshOptions o = options(path);
    o.memory_bytes = mib << 20;
    o.threads = 2;
    const Report report = run(o);
    expect_valid(o, report, input);
    EXPECT_EQ(report.memory_budget_bytes, mib << 20);
  }
}

TEST_F(RemeshTest, TakesAnyLevelAndAnySmallBase) {
  const MeshLists input = test::lists_of(test::bumpy(test::icosphere(3), 0.05, 0.01, 1));
  const auto path = put(input);
  for (const unsigned level : {0u, 1u, 4u}) {
    for (const std::uint64_t base : {4u, 100u}) {
      SCOPED_TRACE("level " + std::to_string(level) + ", base " + std::to_string(base));
      RemeshOptions o = options(path);
      o.level = level;
      o.base_vertices = base;
      const Report report = run(o);
      MeshLists output = test::read_lists(o.output);
      expect_same_kind(kind_of(output.triangle), kind_of(input.triangle));
      EXPECT_LE(report.base_vertices, base == 4 ? 12u : base);
    }
  }
}

TEST_F(RemeshTest, LeavesAMeshSmallerThanItsBaseAsItIs) {
  const MeshLists input = test::lists_of(test::octahedron());
  RemeshOptions o = options(put(input));
  o.level = 1;
  const Report report = run(o);
  expect_valid(o, report, input);
  EXPECT_EQ(report.base_vertices, 6u);
  EXPECT_EQ(report.output_vertices, 6u + 12u);
}

TEST_F(RemeshTest, WritesObjAsWellAsPly) {
  const auto input = put(test::scan(BaseShape::kDisk, 5'000));
  RemeshOptions o = options(input);
  run(o);
  const MeshLists ply = test::read_lists(o.output);
  o.output = directory() / "out.obj";
  run(o);
  const MeshLists obj = test::read_lists(o.output);
  EXPECT_EQ(obj.triangle, ply.triangle);
  ASSERT_EQ(obj.position.size(), ply.position.size());
  for (std::size_t v = 0; v < obj.position.size(); ++v) {
    ASSERT_LT(norm(obj.position[v] - ply.position[v]), 1e-6);
  }
}

TEST_F(RemeshTest, CountsVerticesWithoutAFaceAndGivesThemNone) {
  for (const std::uint64_t domain_buffer : {std::uint64_t{0}, test::kSmallDomainBuffer}) {
    MeshLists input = test::scan(BaseShape::kTorus, 5'000);
    for (const std::size_t at : {std::size_t{0}, std::size_t{1000}, input.position.size()}) {
      input.position.insert(input.position.begin() + static_cast<std::ptrdiff_t>(at),
                            {0.1, 0.2, double(at) / 5000});
      for (Triangle& t : input.triangle) {
        for (VertexId& v : t) v += v >= at;
      }
    }
    input.position.back() = {9, 9, 9};
    for (Vec3& p : input.position) p = widen(to_float(p));
    RemeshOptions o = options(put(input));
    if (domain_buffer != 0) o.domain_buffer = domain_buffer;
    const Report report = run(o);
    expect_valid(o, report, input);
    EXPECT_EQ(report.repairs.unreferenced_vertices, 3u);
  }
}

TEST_F(RemeshTest, KeepsABaseForEachComponent) {
  const test::Shape ball = test::bumpy(test::icosphere(4), 0.06, 0.004, 2);
  const test::Shape ring = test::bumpy(test::torus(50, 25), 0.04, 0.003, 3);
  const MeshLists input = test::lists_of(test::together(ball, ring));
  for (const std::uint64_t domain_buffer : {std::uint64_t{0}, test::kSmallDomainBuffer}) {
    RemeshOptions o = options(put(input));
    if (domain_buffer != 0) o.domain_buffer = domain_buffer;
    const Report report = run(o);
    expect_valid(o, report, input);
    EXPECT_EQ(report.components, 2u);
    EXPECT_EQ(report.euler_characteristic, 2);
    // The second component lies beyond x = 3; a vertex is mapped to its own component's faces.
    const MeshLists base = test::read_lists(o.bundle / kBaseName);
    const std::vector<MapRecord> records = map_records(o.bundle);
    for (std::size_t v = 0; v < records.size(); ++v) {
      const bool second = v >= ball.position.size();
      for (const VertexId b : base.triangle.at(records[v].face)) {
        ASSERT_EQ(base.position[b].x > 3, second) << "vertex " << v;
      }
    }
  }
}

TEST_F(RemeshTest, PutsVerticesOfTheMapWhereTheOutputSaysTheyAre) {
  // Base vertices have weight 1 at their own corner.
  const MeshLists input = test::scan(BaseShape::kDoubleTorus, 6'000);
  const RemeshOptions o = options(put(input));
  run(o);
  const MeshLists base = test::read_lists(o.bundle / kBaseName);
  std::map<std::array<double, 3>, std::size_t> base_at;
  for (std::size_t b = 0; b < base.position.size(); ++b) {
    base_at[{base.position[b].x, base.position[b].y, base.position[b].z}] = b;
  }
  const std::vector<MapRecord> records = map_records(o.bundle);
  std::size_t found = 0;
  for (std::size_t v = 0; v < records.size(); ++v) {
    const Vec3& p = input.position[v];
    const auto at = base_at.find({p.x, p.y, p.z});
    if (at == base_at.end()) continue;
    ++found;
    const MapRecord& r = records[v];
    const std::size_t corner = r.u == 1 ? 1 : r.v == 1 ? 2 : 0;
    EXPECT_EQ(base.triangle[r.face][corner], at->second);
    EXPECT_EQ(r.u + r.v, corner == 0 ? 0 : 1);
  }
  EXPECT_EQ(found, base.position.size());
}

TEST_F(RemeshTest, ResamplesABundleAtAnyLevelWithNestedVertices) {
  RemeshOptions o = options(put(test::scan(BaseShape::kTorus, 5'000)));
  run(o);
  std::vector<MeshLists> made;
  for (const unsigned level : {1u, 2u, 3u}) {
    ResampleBundleOptions resample;
    resample.bundle = o.bundle;
    resample.output = directory() / ("level-" + std::to_string(level) + ".ply");
    resample.level = level;
    resample.threads = 1;
    resample.memory_bytes = 24 << 20;
    resample.measure = false;
    Progress progress;
    const Report report = resample_bundle(resample, progress);
    made.push_back(test::read_lists(resample.output));
    EXPECT_EQ(report.output_faces, made.back().triangle.size());
    EXPECT_EQ(report.level, level);
    if (level == o.level) {
      EXPECT_TRUE(bytes_of(resample.output) == bytes_of(o.output));
    }
  }
  const Bundle bundle(o.bundle);
  const auto& base = bundle.base();
  for (unsigned level = 1; level < 3; ++level) {
    const auto vertices = static_cast<std::uint32_t>(base.position.size());
    const resample::DyadicGrid coarse(vertices, base.triangle, level);
    const resample::DyadicGrid fine(vertices, base.triangle, level + 1);
    const std::uint32_t n = 1u << level;
    for (std::uint32_t f = 0; f < base.triangle.size(); ++f) {
      for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i + j <= n; ++i) {
          ASSERT_EQ(made[level - 1].position[coarse.vertex(f, i, j)],
                    made[level].position[fine.vertex(f, 2 * i, 2 * j)]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace remaps::pipeline
