#include "remaps/pipeline/vertex_spool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/formats/mesh_reader.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

class VertexSpoolTest : public test::TempFiles {
 protected:
  std::unique_ptr<IndexedMeshReader> write_and_open(const test::MeshLists& mesh) const {
    test::write_lists(mesh, directory() / "in.ply");
    return open_mesh_reader(directory() / "in.ply");
  }
  /// OBJ keeps all digits of a double.
  std::unique_ptr<IndexedMeshReader> write_obj_and_open(const std::vector<Vec3>& position) const {
    std::ofstream out(directory() / "in.obj");
    out.precision(17);
    for (const Vec3& p : position) out << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    out << "f 1 2 3\n";
    out.close();
    return open_mesh_reader(directory() / "in.obj");
  }
  std::filesystem::path path() const { return directory() / "spool"; }

  MemoryBudget budget_{std::uint64_t{64} << 20};
};

TEST_F(VertexSpoolTest, ReadsBackPositionsFromAnywhere) {
  const test::MeshLists mesh = test::scan(BaseShape::kTorus, 40'000);
  write_and_open(mesh);
  test::write_lists(mesh, directory() / "in.obj");
  for (const char* name : {"in.ply", "in.obj"}) {
    const auto reader = open_mesh_reader(directory() / name);
    PositionSample sample(100);
    VertexSpool spool(path(), budget_);
    spool.fill(*reader, &sample, [](double) {});
    EXPECT_EQ(std::filesystem::exists(path()), std::string(name) == "in.obj")
        << "a PLY of floats needs no copy";
    ASSERT_EQ(spool.vertices(), mesh.position.size());
    EXPECT_EQ(spool.origin(), Vec3{});
    EXPECT_EQ(sample.seen(), mesh.position.size());
    Box3 box;
    for (const Vec3& p : mesh.position) box.add(p);
    EXPECT_EQ(spool.box().low, box.low);
    EXPECT_EQ(spool.box().high, box.high);
    std::mt19937_64 random(1);
    std::vector<Vec3f> part;
    for (int i = 0; i < 50; ++i) {
      const std::size_t first = random() % mesh.position.size();
      part.resize(std::min<std::size_t>(random() % 3000, mesh.position.size() - first));
      spool.read(first, part);
      for (std::size_t k = 0; k < part.size(); ++k)
        ASSERT_EQ(widen(part[k]), mesh.position[first + k]);
    }
    part.resize(2);
    EXPECT_THROW(spool.read(mesh.position.size() - 1, part), CorruptionError);
  }
  EXPECT_FALSE(std::filesystem::exists(path()));
}

TEST_F(VertexSpoolTest, MovesTheOriginOfSurveysSoThatFloatsSuffice) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> offset(0, 1);
  std::vector<Vec3> position;
  for (int i = 0; i < 1000; ++i)
    position.push_back({4'500'000 + offset(random), 600'000 + offset(random), offset(random)});
  const auto reader = write_obj_and_open(position);
  VertexSpool spool(path(), budget_);
  spool.fill(*reader, nullptr, [](double) {});
  EXPECT_NE(spool.origin(), Vec3{});
  std::vector<Vec3f> stored(position.size());
  spool.read(0, stored);
  for (std::size_t i = 0; i < stored.size(); ++i) {
    ASSERT_LT(norm(spool.origin() + widen(stored[i]) - position[i]), 1e-6);
  }
}

TEST_F(VertexSpoolTest, KeepsTheOriginOfWhatLiesNearZero) {
  const auto reader = write_obj_and_open({{10, 0, 0}, {11, 0.1, 0}, {10, 1, 0}});
  VertexSpool spool(path(), budget_);
  spool.fill(*reader, nullptr, [](double) {});
  EXPECT_EQ(spool.origin(), Vec3{});
}

TEST(VertexRuns, HoldWhatWasAddedAndPayForIt) {
  MemoryBudget budget(std::uint64_t{8} << 20);
  {
    VertexRuns runs;
    std::vector<bool> in(1'000);
    std::mt19937_64 random(4);
    for (VertexId v = 0; v < in.size(); ++v) {
      in[v] = v > 3 && random() % 3 != 0;
      if (in[v]) runs.add(v, budget);
    }
    EXPECT_EQ(runs.size(), std::uint64_t(std::count(in.begin(), in.end(), true)));
    for (VertexId v = 0; v < in.size(); ++v) ASSERT_EQ(runs.contains(v), in[v]) << v;
    EXPECT_FALSE(runs.contains(1'000'000));
    const std::vector<VertexId> first = runs.first(3);
    ASSERT_EQ(first.size(), 3u);
    EXPECT_TRUE(in[first[0]] &&
                std::count(in.begin(), in.begin() + std::ptrdiff_t(first[0]), true) == 0);
    EXPECT_EQ(budget.available(), budget.total());
    EXPECT_EQ(VertexRuns().first(3).size(), 0u);
  }
  VertexRuns run;
  for (VertexId v = 0; v < 5'000'000; ++v) run.add(v, budget);
  EXPECT_EQ(budget.available(), budget.total()) << "a run is a run, however long";
  {
    VertexRuns many;
    for (VertexId v = 0; v < 200'000; ++v) many.add(2 * v, budget);
    EXPECT_LT(budget.available() + (std::uint64_t{3} << 20), budget.total());
    EXPECT_TRUE(many.contains(399'998));
    EXPECT_FALSE(many.contains(399'999));
    EXPECT_THROW(
        {
          for (VertexId v = 200'000; v < 2'000'000; ++v) many.add(2 * v, budget);
        },
        BudgetError);
  }
  EXPECT_EQ(budget.available(), budget.total());
}

TEST_F(VertexSpoolTest, LooksUpAnyOrderThroughASmallCache) {
  const test::MeshLists mesh = test::scan(BaseShape::kIcosahedron, 30'000);
  const auto reader = write_and_open(mesh);
  VertexSpool spool(path(), budget_);
  PositionSample sample(1000);
  spool.fill(*reader, &sample, [](double) {});
  const SpaceCut cut(sample.kept(), 7, 0);
  for (const std::uint64_t cache_bytes : {std::uint64_t{0}, std::uint64_t{1} << 24}) {
    VertexLookup lookup(spool, &cut, cache_bytes, budget_);
    VertexLookup uncut(spool, nullptr, cache_bytes, budget_);
    EXPECT_LT(budget_.available(), budget_.total());
    std::mt19937_64 random(3);
    for (int i = 0; i < 30'000; ++i) {
      // Runs of neighbours with leaps between them.
      const VertexId v = i % 50 == 0 ? random() % spool.vertices()
                                     : (static_cast<VertexId>(i) * 7) % spool.vertices();
      ASSERT_EQ(widen(lookup[v].position), mesh.position[v]);
      ASSERT_EQ(lookup[v].segment, cut.segment_of(to_float(mesh.position[v])));
      ASSERT_EQ(uncut[v].segment, 0u);
    }
  }
  EXPECT_EQ(budget_.available(), budget_.total());
}

TEST_F(VertexSpoolTest, StreamsTrianglesAgainAndAgain) {
  const test::MeshLists mesh = test::scan(BaseShape::kDisk, 20'000, true);
  const auto reader = write_and_open(mesh);
  VertexSpool spool(path(), budget_);
  spool.fill(*reader, nullptr, [](double) {});
  VertexLookup lookup(spool, nullptr, 0, budget_);
  const Vec3 shift{1, 2, 3};
  const TriangleSource source = triangles_of(*reader, lookup, shift);
  for (int round = 0; round < 2; ++round) {
    std::size_t f = 0;
    source([&](std::span<const TrianglePositions> chunk) {
      for (const TrianglePositions& t : chunk) {
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_EQ(t[c], shift + mesh.position[mesh.triangle[f][c]]);
        ++f;
      }
    });
    EXPECT_EQ(f, mesh.triangle.size());
  }
}

TEST_F(VertexSpoolTest, CutsConcavePolygonsOfAllFormats) {
  const std::string corners = "0 0 0\n4 0 0\n1 1 0\n0 4 0\n-1 2 0\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty "
      "float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string lists = "4 1 2 3 0\n3 0 3 4\n";
  std::string obj = "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nv -1 2 0\nf 2 3 4 1\nf 1 4 5\n";
  for (const std::string& bytes : {ply + corners + lists, "OFF 5 2 0\n" + corners + lists, obj}) {
    const auto reader = open_mesh_reader(make_file("dart", bytes));
    VertexSpool spool(path(), budget_);
    spool.fill(*reader, nullptr, [](double) {});
    std::vector<Triangle> triangles;
    const auto read = [&] {
      triangles.clear();
      reader->read_triangles([&](std::span<const Triangle> chunk) {
        triangles.insert(triangles.end(), chunk.begin(), chunk.end());
      });
    };
    {
      const PolygonCutting cutting(*reader, spool, 0, budget_);
      EXPECT_EQ(budget_.available(), budget_.total());
      read();
      EXPECT_LT(budget_.available(), budget_.total());
    }
    // 0 2 is the inner diagonal; the fan from 1 would take 1 3.
    ASSERT_EQ(triangles.size(), 3U);
    for (const std::size_t t : {0U, 1U}) {
      EXPECT_EQ(std::count(triangles[t].begin(), triangles[t].end(), 0U), 1);
      EXPECT_EQ(std::count(triangles[t].begin(), triangles[t].end(), 2U), 1);
    }
    EXPECT_EQ(triangles[2], (Triangle{0, 3, 4}));
    read();
    EXPECT_EQ(triangles[0], (Triangle{1, 2, 3})) << "without a cutter it is a fan";
  }
}

/// Polygons that are too long to be kept become fans.
TEST_F(VertexSpoolTest, CutsPolygonsOfAnyLength) {
  for (const std::size_t n : {4U, 1023U, 1024U, 1025U, 10'000U}) {
    std::ofstream out(directory() / "long.obj");
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 6.283185307179586 * double(i) / double(n);
      out << "v " << 1000 * std::cos(angle) << ' ' << 1000 * std::sin(angle) << " 0\n";
    }
    out << 'f';
    for (std::size_t i = 1; i <= n; ++i) out << ' ' << i;
    out.close();
    const auto reader = open_mesh_reader(directory() / "long.obj");
    VertexSpool spool(path(), budget_);
    spool.fill(*reader, nullptr, [](double) {});
    const PolygonCutting cutting(*reader, spool, 0, budget_);
    std::size_t triangles = 0;
    reader->read_triangles([&](std::span<const Triangle> chunk) { triangles += chunk.size(); });
    EXPECT_EQ(triangles, n - 2);
  }
}

}  // namespace
}  // namespace remaps::pipeline
