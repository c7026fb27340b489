#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
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

/// The part of a sphere that a place belongs to, by the signs of its coordinates, and the names of
/// the two labels in the file that tell it: four of x and y, two of z.
int part_at(const Vec3& p) {
  return (p.x > 0) + 2 * (p.y > 0) + 4 * (p.z > 0);
}

Vec3 centre(const MeshLists& mesh, const Triangle& t) {
  return (1.0 / 3) * (mesh.position[t[0]] + mesh.position[t[1]] + mesh.position[t[2]]);
}

/// A sphere whose faces do not cross the coordinate planes, as an OBJ with groups and materials.
void write_parts(const MeshLists& mesh, const std::filesystem::path& path) {
  std::ofstream file(path);
  file.precision(9);
  for (const Vec3& p : mesh.position) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const Triangle& t : mesh.triangle) {
    const int part = part_at(centre(mesh, t));
    file << "g side " << part % 4 << "\nusemtl " << (part < 4 ? "below" : "above") << "\nf "
         << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }
}

/// The sphere, with its octants' corners and borders on edges.
MeshLists octant_sphere(unsigned n) {
  MeshLists mesh = test::lists_of(test::cube(n));
  for (Vec3& p : mesh.position) p = widen(to_float((1 / norm(p)) * p));
  return mesh;
}

/// How far a face reaches beyond the part in which its centre is.
double reach_beyond(const MeshLists& mesh) {
  double reach = 0;
  for (const Triangle& t : mesh.triangle) {
    const Vec3 c = centre(mesh, t);
    for (const VertexId v : t) {
      const Vec3& p = mesh.position[v];
      for (const auto& [a, b] : {std::pair{p.x, c.x}, std::pair{p.y, c.y}, std::pair{p.z, c.z}})
        if (a * b < 0) reach = std::max(reach, std::fabs(a));
    }
  }
  return reach;
}

/// Length of edges in the coordinate planes, each counted from both sides.
double length_on_borders(const MeshLists& mesh, bool only_z) {
  double length = 0;
  for (const Triangle& t : mesh.triangle) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = mesh.position[t[i]];
      const Vec3& b = mesh.position[t[(i + 1) % 3]];
      const auto in_plane = [](double x, double y) {
        return std::max(std::fabs(x), std::fabs(y)) < 1e-6;  // the rounding of floats
      };
      const bool on = in_plane(a.z, b.z) || (!only_z && (in_plane(a.x, b.x) || in_plane(a.y, b.y)));
      if (on) length += norm(b - a);
    }
  }
  return length;
}

TEST_F(Features, BetweenLabelsAreEdgesOfBaseAndOutputInManySegmentsAndForAnyThreads) {
  const MeshLists sphere = octant_sphere(32);
  write_parts(sphere, directory() / "in.obj");
  RemeshOptions o = test::remesh_options(directory(), directory() / "in.obj");
  o.feature_labels = FaceLabelChoice("all");
  const double borders = length_on_borders(sphere, false);
  for (const std::uint64_t buffer : {std::uint64_t{100'000}, test::kSmallDomainBuffer}) {
    SCOPED_TRACE(buffer);
    o.domain_buffer = buffer;
    o.threads = 1;
    const Report report = run(o);
    ASSERT_TRUE(report.features);
    EXPECT_EQ(report.features->labels, (std::vector<std::string>{"group", "material"}));
    EXPECT_EQ(report.features->edges, 3u * 4 * 32);
    EXPECT_EQ(report.features->corners, 6u);
    EXPECT_EQ(report.features->dropped_edges, 0u);
    EXPECT_EQ(report.sweeps.size() > 1, buffer == test::kSmallDomainBuffer);
    expect_sound(o);
    const MeshLists output = test::read_lists(o.output);
    EXPECT_LT(reach_beyond(output), 1e-6);
    EXPECT_NEAR(length_on_borders(output, false), borders, 0.01 * borders);
    const auto one = contents(o);
    o.threads = 2;
    run(o);
    EXPECT_EQ(contents(o), one);
  }
}

TEST_F(Features, BetweenLabelsOfOneNameLeaveTheOthersAloneAndJoinThoseOfAnAngle) {
  const MeshLists sphere = octant_sphere(16);
  write_parts(sphere, directory() / "in.obj");
  RemeshOptions o = test::remesh_options(directory(), directory() / "in.obj");
  o.feature_labels = FaceLabelChoice("material");
  EXPECT_EQ(run(o).features->edges, 4u * 16);
  EXPECT_EQ(Bundle(o.bundle).manifest().feature_labels, std::vector<std::string>{"material"});
  const double borders = length_on_borders(sphere, true);
  EXPECT_NEAR(length_on_borders(test::read_lists(o.output), true), borders, 0.02 * borders);
  o.feature_labels = FaceLabelChoice("part");
  EXPECT_THROW(run(o), InputError);

  const MeshLists cube = test::lists_of(test::cube(16));
  write_parts(cube, directory() / "in.obj");
  o.feature_labels = FaceLabelChoice("material");
  o.feature_angle_deg = 30;
  EXPECT_EQ(run(o).features->edges, 12u * 16 + 4 * 16);
  EXPECT_NEAR(length_on_creases(test::read_lists(o.output)), 2 * 12 * 2, 1e-5);
}

TEST_F(Features, BetweenLabelsSurviveRepair) {
  MeshLists sphere = octant_sphere(16);
  std::swap(sphere.triangle[7][0], sphere.triangle[7][1]);  // against its neighbours
  write_parts(sphere, directory() / "in.obj");
  RemeshOptions o = test::remesh_options(directory(), directory() / "in.obj");
  o.feature_labels = FaceLabelChoice("group,material");
  const Report report = run(o);
  EXPECT_EQ(report.repairs.flipped_faces, 1u);
  EXPECT_EQ(report.features->edges, 3u * 4 * 16);
  EXPECT_LT(reach_beyond(test::read_lists(o.output)), 1e-6);
}

}  // namespace
}  // namespace remaps::pipeline
