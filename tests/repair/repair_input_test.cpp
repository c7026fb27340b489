#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "remaps/pipeline/check.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/surface_check.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::MeshLists;

/// A mesh with something wrong, remeshed in one segment and in many, on one thread and on three.
class RepairInput : public test::TempFiles {
 protected:
  RemeshOptions options(const MeshLists& mesh) const {
    test::write_lists(mesh, directory() / "in.ply");
    return test::remesh_options(directory(), directory() / "in.ply");
  }

  static Report run(const RemeshOptions& o) {
    Progress progress;
    return remesh(o, progress);
  }

  /// Remeshes in all ways. The repairs and the topology must be the same, the output a manifold of
  /// that topology, and the bundle must verify.
  Report run_all(RemeshOptions o) const {
    std::vector<Report> reports;
    for (const std::uint64_t buffer : {std::uint64_t{0}, test::kSmallDomainBuffer}) {
      for (const unsigned threads : {1u, 3u}) {
        SCOPED_TRACE(std::to_string(buffer) + " faces, " + std::to_string(threads) + " threads");
        o.domain_buffer = buffer;
        o.threads = threads;
        reports.push_back(run(o));
        check(o, reports.back());
        const Repairs& a = reports.front().repairs;
        const Repairs& b = reports.back().repairs;
        EXPECT_EQ(a.unreferenced_vertices, b.unreferenced_vertices);
        EXPECT_EQ(a.duplicate_faces, b.duplicate_faces);
        EXPECT_EQ(a.flipped_faces, b.flipped_faces);
        EXPECT_EQ(a.nonmanifold_edges, b.nonmanifold_edges);
        EXPECT_EQ(a.nonmanifold_vertices, b.nonmanifold_vertices);
        EXPECT_EQ(a.split_vertices, b.split_vertices);
        EXPECT_EQ(a.dropped_components, b.dropped_components);
        EXPECT_EQ(a.dropped_component_faces, b.dropped_component_faces);
        EXPECT_EQ(reports.front().euler_characteristic, reports.back().euler_characteristic);
      }
    }
    return reports.back();
  }

  static void check(const RemeshOptions& o, const Report& report) {
    const test::CountedSurface counted = test::count_surface(test::read_lists(o.output).triangle);
    EXPECT_EQ(counted.defect, "");
    EXPECT_EQ(counted.topology.components, report.components);
    EXPECT_EQ(counted.topology.boundary_loops, report.boundary_loops);
    EXPECT_EQ(counted.topology.euler_characteristic(), report.euler_characteristic);
    Progress progress;
    QueryOptions query;
    query.bundle = o.bundle;
    const Verification verified = verify_bundle(query, progress);
    EXPECT_LT(verified.round_trip_max, 1e-9);
  }

  MeshCheck checked(const RemeshOptions& o) const {
    CheckOptions check_options;
    check_options.input = o.input;
    check_options.temp_dir = directory();
    Progress progress;
    return check_mesh(check_options, progress);
  }
};

MeshLists ball() {
  return test::scan(BaseShape::kIcosahedron, 6'000);
}

TEST_F(RepairInput, LeavesASoundMeshAlone) {
  const RemeshOptions o = options(ball());
  const Report report = run_all(o);
  EXPECT_EQ(report.repairs.split_vertices, 0u);
  EXPECT_EQ(report.repairs.flipped_faces, 0u);
  EXPECT_TRUE(checked(o).sound());
}

TEST_F(RepairInput, TurnsFacesUntilTheyAgree) {
  MeshLists mesh = test::scan(BaseShape::kTorus, 6'000);
  std::mt19937_64 random(1);
  std::uint64_t turned = 0;
  for (Triangle& t : mesh.triangle) {
    if (random() % 3 != 0) continue;
    std::swap(t[0], t[1]);
    ++turned;
  }
  const RemeshOptions o = options(mesh);
  const MeshCheck found = checked(o);
  EXPECT_FALSE(found.sound());
  EXPECT_GT(found.defects.misoriented_edges, turned);
  EXPECT_EQ(found.places.misoriented_edges.size(), 5u);
  const Report report = run_all(o);
  EXPECT_EQ(report.repairs.flipped_faces, turned);
  EXPECT_EQ(report.euler_characteristic, 0);
  EXPECT_EQ(report.repairs.split_vertices, 0u);
}

TEST_F(RepairInput, DropsRepeatedFacesWhicheverWayTheyRun) {
  MeshLists mesh = ball();
  for (std::size_t i = 0; i < 40; ++i) {
    const Triangle t = mesh.triangle[97 * i];
    mesh.triangle.push_back(i % 2 == 0 ? Triangle{t[1], t[2], t[0]} : Triangle{t[2], t[1], t[0]});
  }
  const RemeshOptions o = options(mesh);
  const Report report = run_all(o);
  EXPECT_EQ(report.repairs.duplicate_faces, 40u);
  EXPECT_EQ(report.repairs.nonmanifold_edges, 0u);
  EXPECT_EQ(report.euler_characteristic, 2);
  EXPECT_EQ(report.input_faces, mesh.triangle.size());
  EXPECT_EQ(checked(o).defects.duplicate_faces, 40u);
}

TEST_F(RepairInput, OpensWhatIsTwoFacesBackToBack) {
  MeshLists mesh = ball();
  const VertexId n = mesh.position.size();
  for (const double x : {3.0, 4.0, 5.0}) mesh.position.push_back({x, x * x, 0});
  mesh.triangle.push_back({n, n + 1, n + 2});
  mesh.triangle.push_back({n, n + 2, n + 1});
  const Report report = run_all(options(mesh));
  EXPECT_EQ(report.repairs.duplicate_faces, 1u);
  EXPECT_EQ(report.components, 2u);
  EXPECT_EQ(report.boundary_loops, 1u);
}

TEST_F(RepairInput, CutsFlapsOff) {
  MeshLists mesh = ball();
  for (std::size_t i = 0; i < 20; ++i) {
    const Triangle t = mesh.triangle[211 * i];
    const Vec3& a = mesh.position[t[0]];
    mesh.triangle.push_back({t[0], t[1], mesh.position.size()});
    mesh.position.push_back({1.2 * a.x, 1.2 * a.y, 1.2 * a.z});
  }
  const RemeshOptions o = options(mesh);
  const Report report = run_all(o);
  EXPECT_EQ(report.repairs.nonmanifold_edges, 20u);
  EXPECT_EQ(report.repairs.nonmanifold_vertices, 40u);
  EXPECT_EQ(report.repairs.split_vertices, 40u);
  EXPECT_EQ(report.components, 21u) << "the ball, closed as it was, and the flaps";
  EXPECT_EQ(report.boundary_loops, 20u);

  RemeshOptions without = o;
  without.min_component = 2;
  const Report cleaned = run_all(without);
  EXPECT_EQ(cleaned.components, 1u);
  EXPECT_EQ(cleaned.repairs.dropped_components, 20u);
  EXPECT_EQ(cleaned.repairs.dropped_component_faces, 20u);
  EXPECT_EQ(cleaned.euler_characteristic, 2);
}

TEST_F(RepairInput, PartsBallsThatTouchAtVerticesAndEdges) {
  MeshLists mesh = ball();
  const MeshLists other = mesh;
  const std::size_t n = mesh.position.size();
  // The second ball shares an edge with the first, and one vertex far from it.
  const Triangle edge = other.triangle[100];
  const VertexId far = other.triangle[7000][0];
  ASSERT_EQ(std::count(edge.begin(), edge.end(), far), 0);
  const auto moved = [&](VertexId v) {
    return v == edge[0] || v == edge[1] || v == far ? v : v + n;
  };
  for (const Vec3& p : other.position) mesh.position.push_back({p.x + 3, p.y, p.z});
  for (const Triangle& t : other.triangle)
    mesh.triangle.push_back({moved(t[0]), moved(t[1]), moved(t[2])});
  const RemeshOptions o = options(mesh);
  const Report report = run_all(o);
  EXPECT_EQ(report.repairs.nonmanifold_edges, 1u);
  EXPECT_EQ(report.repairs.nonmanifold_vertices, 3u);
  EXPECT_EQ(report.repairs.split_vertices, 3u);
  EXPECT_EQ(report.repairs.unreferenced_vertices, 3u);
  EXPECT_EQ(report.components, 2u);
  EXPECT_EQ(report.euler_characteristic, 4);
  EXPECT_EQ(report.boundary_loops, 0u);
}

TEST_F(RepairInput, FillsHolesOfUpToSoManyEdges) {
  MeshLists mesh = ball();
  // Holes of three edges, some rings of five to seven, and one of a face and all its neighbours.
  std::vector<Triangle> kept;
  const std::set<VertexId> centres{17, 1500, 3001};
  const Triangle wide = mesh.triangle[9000];
  std::size_t large = 0;
  for (std::size_t f = 0; f < mesh.triangle.size(); ++f) {
    const Triangle& t = mesh.triangle[f];
    const auto has = [&](const auto& list) {
      return std::any_of(t.begin(), t.end(), [&](VertexId v) {
        return std::find(list.begin(), list.end(), v) != list.end();
      });
    };
    large += has(wide);
    if (f == 4000 || f == 7777 || has(centres) || has(wide)) continue;
    kept.push_back(t);
  }
  mesh.triangle = kept;
  RemeshOptions o = options(mesh);
  o.fill_holes = 8;
  const Report some = run_all(o);
  EXPECT_EQ(some.repairs.filled_holes, 5u);
  EXPECT_EQ(some.boundary_loops, 1u);
  EXPECT_GT(large, 9u);
  o.fill_holes = 1000;
  const Report all = run_all(o);
  EXPECT_EQ(all.repairs.filled_holes, 6u);
  EXPECT_EQ(all.boundary_loops, 0u);
  EXPECT_EQ(all.euler_characteristic, 2);
  EXPECT_EQ(all.input_faces, mesh.triangle.size());
}

TEST_F(RepairInput, DropsDegenerateFacesAndVerticesThatAreNotFinite) {
  MeshLists mesh = ball();
  const Triangle t = mesh.triangle[50];
  mesh.triangle.push_back({t[0], t[0], t[1]});
  mesh.triangle.push_back({t[1], t[2], t[1]});
  RemeshOptions o = options(mesh);
  const Report report = run_all(o);
  EXPECT_EQ(report.repairs.degenerate_faces, 2u);
  EXPECT_EQ(report.euler_characteristic, 2);
  o.strict = true;
  EXPECT_THROW(run(o), GeometryError);
}

TEST_F(RepairInput, RefusesAllOfThatWhenStrict) {
  MeshLists mesh = ball();
  std::swap(mesh.triangle[10][0], mesh.triangle[10][1]);
  RemeshOptions o = options(mesh);
  o.strict = true;
  EXPECT_THROW(run(o), GeometryError);
  EXPECT_EQ(entries_in(directory()), 1u) << "something is left behind";
}

TEST_F(RepairInput, RefusesASurfaceWithOneSide) {
  MeshLists mesh;
  constexpr std::size_t kAround = 400, kAcross = 4;
  for (std::size_t i = 0; i < kAround; ++i) {
    for (std::size_t j = 0; j <= kAcross; ++j) {
      const double angle = 2 * M_PI * double(i) / kAround;
      const double x = double(j) / kAcross - 0.5;
      const double r = 2 + x * std::cos(angle / 2);
      const auto f = [](double v) { return double(float(v)); };
      mesh.position.push_back(
          {f(r * std::cos(angle)), f(r * std::sin(angle)), f(x * std::sin(angle / 2))});
    }
  }
  const auto at = [](std::size_t i, std::size_t j) -> VertexId {
    return i < kAround ? i * (kAcross + 1) + j : kAcross - j;
  };
  for (std::size_t i = 0; i < kAround; ++i) {
    for (std::size_t j = 0; j < kAcross; ++j) {
      mesh.triangle.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangle.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  RemeshOptions o = options(mesh);
  for (const std::uint64_t buffer : {std::uint64_t{0}, std::uint64_t{500}}) {
    o.domain_buffer = buffer;
    o.base_vertices = 20;
    try {
      run(o);
      ADD_FAILURE() << "a Moebius strip was remeshed";
    } catch (const GeometryError& error) {
      EXPECT_NE(std::string(error.what()).find("one side"), std::string::npos) << error.what();
    }
  }
  EXPECT_FALSE(checked(o).one_sided.empty());
}

}  // namespace
}  // namespace remaps::pipeline
