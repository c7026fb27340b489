#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/surface_check.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::MeshLists;

class Features : public test::TempFiles {
 protected:
  std::filesystem::path put(const MeshLists& mesh) const {
    test::write_lists(mesh, directory() / "in.ply");
    return directory() / "in.ply";
  }
  static Report run(const RemeshOptions& options) {
    Progress progress;
    return remesh(options, progress);
  }
  std::map<std::string, std::string> contents(const RemeshOptions& o) const {
    std::map<std::string, std::string> result{{"output", bytes_of(o.output)}};
    for (const auto& entry : std::filesystem::directory_iterator(o.bundle)) {
      result[entry.path().filename()] = bytes_of(entry.path());
    }
    return result;
  }
  void expect_sound(const RemeshOptions& o) const {
    QueryOptions query;
    query.bundle = o.bundle;
    query.threads = 1;
    Progress progress;
    EXPECT_LT(verify_bundle(query, progress).round_trip_max, 1e-8);
  }
};

/// How many of a cube's coordinates are at its sides.
int sides_at(const Vec3& p) {
  return (std::fabs(p.x) == 1) + (std::fabs(p.y) == 1) + (std::fabs(p.z) == 1);
}

/// The length of a mesh's edges that lie on the cube's, each counted from both sides.
double length_on_creases(const MeshLists& mesh) {
  double length = 0;
  for (const Triangle& t : mesh.triangle) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = mesh.position[t[i]];
      const Vec3& b = mesh.position[t[(i + 1) % 3]];
      if (sides_at(a) >= 2 && sides_at(b) >= 2 && sides_at(0.5 * (a + b)) >= 2) {
        length += norm(b - a);
      }
    }
  }
  return length;
}

TEST_F(Features, OfACubeAreEdgesOfBaseAndOutputInManySegmentsAndForAnyThreads) {
  MeshLists input = test::lists_of(test::cube(40));
  for (Vec3& p : input.position) {
    const auto move = [](double x, double y) { return x + 0.01 * (1 - x * x) * std::sin(9 * y); };
    p = widen(to_float({move(p.x, p.y + p.z), move(p.y, p.z - p.x), move(p.z, p.x * p.y)}));
  }
  RemeshOptions o = test::remesh_options(directory(), put(input));
  o.feature_angle_deg = 30;
  for (const std::uint64_t buffer : {std::uint64_t{100'000}, test::kSmallDomainBuffer}) {
    SCOPED_TRACE(buffer);
    o.domain_buffer = buffer;
    o.threads = 1;
    const Report report = run(o);
    ASSERT_TRUE(report.features);
    EXPECT_EQ(report.features->edges, 12u * 40);
    EXPECT_EQ(report.features->corners, 8u);
    EXPECT_EQ(report.features->dropped_edges, 0u);
    EXPECT_GE(report.features->base_edges, 12u);
    EXPECT_EQ(report.base_vertices, o.base_vertices);
    EXPECT_EQ(report.sweeps.size() > 1, buffer == test::kSmallDomainBuffer);
    expect_sound(o);
    EXPECT_EQ(Bundle(o.bundle).manifest().feature_angle_deg, 30);
    const MeshLists base = test::read_lists(o.bundle / kBaseName);
    const MeshLists output = test::read_lists(o.output);
    EXPECT_NEAR(length_on_creases(base), 2 * 12 * 2, 1e-5);
    EXPECT_NEAR(length_on_creases(output), 2 * 12 * 2, 1e-5);
    EXPECT_EQ(test::count_surface(output.triangle).topology.euler_characteristic(), 2);
    const auto one = contents(o);
    o.threads = 2;
    run(o);
    EXPECT_EQ(contents(o), one);
  }
}

TEST_F(Features, TakeTheErrorFromCreases) {
  RemeshOptions o = test::remesh_options(directory(), put(test::lists_of(test::drum(24, 20))));
  o.level = 3;
  o.measure = true;
  o.samples = 50'000;
  const double without = run(o).error->l2();
  o.feature_angle_deg = 30;
  EXPECT_LT(run(o).error->l2(), 0.3 * without);
}

TEST_F(Features, LeaveTheBytesAloneWhereNothingIsSharp) {
  const std::filesystem::path input = put(test::scan(BaseShape::kTorus, 8'000));
  for (const std::uint64_t buffer : {std::uint64_t{100'000}, test::kSmallDomainBuffer}) {
    RemeshOptions o = test::remesh_options(directory(), input);
    o.domain_buffer = buffer;
    EXPECT_FALSE(run(o).features);
    const auto without = contents(o);
    o.feature_angle_deg = 179;
    const Report report = run(o);
    ASSERT_TRUE(report.features);
    EXPECT_EQ(report.features->edges, 0u);
    EXPECT_EQ(report.features->corners, 0u);
    auto with = contents(o);
    with.erase(kManifestName);
    for (const auto& [name, bytes] : with) EXPECT_EQ(bytes, without.at(name)) << name;
  }
}

TEST_F(Features, KeepAllCornersAndSomeMoreWhereTheBaseIsToBeSmaller) {
  RemeshOptions o = test::remesh_options(directory(), put(test::lists_of(test::cube(12))));
  o.base_vertices = 4;
  o.feature_angle_deg = 30;
  const Report report = run(o);
  EXPECT_EQ(report.features->least_base_vertices, 8u);
  EXPECT_EQ(report.base_vertices, 12u);
  EXPECT_GE(report.features->base_edges, 12u);
  expect_sound(o);
  EXPECT_NEAR(length_on_creases(test::read_lists(o.bundle / kBaseName)), 2 * 12 * 2, 1e-5);
}

}  // namespace
}  // namespace remaps::pipeline
