#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/run_binary.h"
#include "support/remesh_job.h"
#include "support/shapes.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<Vec3> directions_in(const std::filesystem::path& path) {
  const std::string bytes = content_of(path);
  std::vector<Vec3> result(bytes.size() / sizeof(Vec3));
  std::memcpy(result.data(), bytes.data(), result.size() * sizeof(Vec3));
  return result;
}

Vec3 vector_of(const Json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

class SphereCommand : public CommandLine {
 protected:
  Json json_of(std::vector<std::string> command) const {
    command.push_back("--json");
    return Json::parse(run_well(command).out);
  }
  /// in.ply of some 3000 vertices, and s.remaps of it with a sphere.
  Json make_sphere(const std::vector<std::string>& more = {}) const {
    generate("in.ply", "3k");
    std::vector<std::string> command{"sphere", "in.ply", "s.remaps", "--intermediate-faces", "400"};
    command.insert(command.end(), more.begin(), more.end());
    return json_of(command);
  }
  void expect_corrupt_after(const std::string& name, std::uint64_t at) const {
    const std::filesystem::path path = directory() / "s.remaps" / name;
    const std::string good = content_of(path);
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    std::ofstream(path, std::ios::binary) << bad;
    expect_failure(6, {"verify", "s.remaps"}, {"sphere"});
    std::ofstream(path, std::ios::binary) << good;
  }
};

TEST_F(SphereCommand, EveryVertexIsMappedAndFoundAgain) {
  const Json said = make_sphere();
  const std::vector<Vec3> direction = directions_in(directory() / "s.remaps/sphere.bin");
  EXPECT_EQ(said.at("input_vertices"), direction.size());
  EXPECT_EQ(said.at("mapped_vertices"), direction.size());
  EXPECT_LT(said.at("round_trip_max").get<double>(), 1e-9);
  ASSERT_EQ(said.at("components").size(), 1u);
  EXPECT_EQ(said.at("components")[0].at("base_faces"), 400);
  EXPECT_GT(said.at("components")[0].at("stretch_efficiency").get<double>(), 0.9);
  for (const Vec3& d : direction) ASSERT_NEAR(norm(d), 1, 1e-12);
  const MeshContent mesh = read_mesh(directory() / "in.ply");
  for (const std::size_t v : {std::size_t{0}, std::size_t{17}, direction.size() - 1}) {
    const Json at = json_of({"locate", "s.remaps", "--vertex", std::to_string(v)})[0];
    EXPECT_LT(norm(vector_of(at.at("sphere").at("direction")) - direction[v]), 1e-12);
    const Vec3& d = direction[v];
    const Json back = json_of({"locate", "s.remaps",
                               "--sphere=" + std::to_string(d.x) + "," + std::to_string(d.y) + "," +
                                   std::to_string(d.z)})[0];
    // Six digits of a direction.
    EXPECT_LT(norm(vector_of(back.at("input").at("position")) - mesh.positions[v]), 1e-4);
  }
  EXPECT_EQ(json_of({"verify", "s.remaps"}).at("sphere_vertices"), direction.size());
}

TEST_F(SphereCommand, ABundleGetsItsSphereAndKeepsTheRest) {
  make_sphere();
  run_well({"parameterize", "in.ply", "p.remaps", "--base-vertices", "202", "--quiet"});
  run_well({"sphere", "p.remaps", "q.remaps", "--quiet"});
  for (const char* const name :
       {"sphere.bin", "sphere-base.bin", "sphere.json", "map.bin", "base.ply", "manifest.json"}) {
    EXPECT_EQ(content_of(directory() / "q.remaps" / name),
              content_of(directory() / "s.remaps" / name))
        << name;
  }
  EXPECT_FALSE(std::filesystem::exists(directory() / "p.remaps/sphere.bin"));
  // Again over itself, and with one thread.
  const std::string before = content_of(directory() / "q.remaps/sphere.bin");
  run_well({"sphere", "q.remaps", "q.remaps", "--threads", "1", "--quiet"});
  EXPECT_EQ(content_of(directory() / "q.remaps/sphere.bin"), before);
  run_well({"verify", "q.remaps", "--quiet"});
}

TEST_F(SphereCommand, DamageIsFound) {
  make_sphere();
  run_well({"verify", "s.remaps", "--quiet"});
  expect_corrupt_after("sphere.bin", 1001);
  expect_corrupt_after("sphere-base.bin", 800);
  const std::string json = content_of(directory() / "s.remaps/sphere.json");
  expect_corrupt_after("sphere.json", json.find("\"sphere.bin\": \"") + 15);
  run_well({"verify", "s.remaps", "--quiet"});
}

TEST_F(SphereCommand, MissingAndCutFilesAreFound) {
  make_sphere();
  for (const char* const name : {"sphere.bin", "sphere-base.bin"}) {
    const std::filesystem::path path = directory() / "s.remaps" / name;
    const std::string good = content_of(path);
    std::ofstream(path, std::ios::binary) << good.substr(0, good.size() - 1);
    expect_failure(6, {"verify", "s.remaps"}, {name, "expected", "bytes"});
    std::filesystem::remove(path);
    expect_failure(6, {"verify", "s.remaps"}, {name, "no such file"});
    std::ofstream(path, std::ios::binary) << good;
  }
  run_well({"verify", "s.remaps", "--quiet"});
}

TEST_F(SphereCommand, WhatIsForMeshesIsRefusedForBundles) {
  make_sphere();
  for (const char* const option : {"--fill-holes", "--intermediate-faces", "--min-component"}) {
    expect_failure(2, {"sphere", "s.remaps", "t.remaps", option, "100"}, {option, "mesh"});
  }
  EXPECT_FALSE(std::filesystem::exists(directory() / "t.remaps"));
}

TEST_F(SphereCommand, OtherSurfacesAreRefusedAndNothingIsLeft) {
  generate("torus.ply", "2k", {"--base", "torus"});
  generate("disk.ply", "2k", {"--base", "disk"});
  const std::vector<std::string> before = names_here();
  expect_failure(4, {"sphere", "torus.ply", "t.remaps"}, {"genus 1", "0 boundary loops"});
  expect_failure(4, {"sphere", "disk.ply", "t.remaps"},
                 {"genus 0", "1 boundary loop", "--fill-holes"});
  expect_failure(3, {"sphere", "none.ply", "t.remaps"}, {"none.ply"});
  generate("ball.ply", "20k");
  expect_failure(
      5, {"sphere", "ball.ply", "t.remaps", "--intermediate-faces", "20000", "--memory", "1M"});
  std::filesystem::remove(directory() / "ball.ply");
  EXPECT_EQ(names_here(), before);
  run_well({"parameterize", "torus.ply", "torus.remaps", "--quiet"});
  expect_failure(3, {"locate", "torus.remaps", "--sphere", "0,0,1"}, {"remaps sphere"});
}

TEST_F(SphereCommand, HolesAreFilledWhenAsked) {
  const test::Shape ball = test::bumpy(test::icosphere(4), 0.2, 0, 1);
  test::MeshLists mesh = test::lists_of(ball);
  mesh.triangle.pop_back();
  test::write_lists(mesh, directory() / "open.ply");
  const std::vector<std::string> command{"sphere", "open.ply", "o.remaps", "--intermediate-faces",
                                         "200"};
  expect_failure(4, command, {"1 boundary loop"});
  std::vector<std::string> filling = command;
  filling.insert(filling.end(), {"--fill-holes", "10"});
  EXPECT_EQ(json_of(filling).at("mapped_vertices"), ball.position.size());
  run_well({"verify", "o.remaps", "--quiet"});
}

TEST_F(SphereCommand, TheLargestComponentOrEach) {
  const test::Shape both =
      test::together(test::octahedron(), test::bumpy(test::icosphere(3), 0.2, 0, 1));
  test::write_lists(test::lists_of(both), directory() / "two.ply");
  const std::vector<std::string> command{"sphere", "two.ply", "two.remaps", "--intermediate-faces",
                                         "200"};
  const Json one = json_of(command);
  EXPECT_EQ(one.at("base_components"), 2);
  EXPECT_EQ(one.at("components").size(), 1u);
  EXPECT_EQ(one.at("mapped_vertices"), both.position.size() - 6);
  const std::vector<Vec3> direction = directions_in(directory() / "two.remaps/sphere.bin");
  for (std::size_t v = 0; v < direction.size(); ++v) {
    EXPECT_EQ(std::isnan(direction[v].x), v < 6) << v;
  }
  expect_failure(3, {"locate", "two.remaps", "--sphere", "0,0,1,1"}, {"component 1"});
  std::vector<std::string> all = command;
  all.insert(all.end(), {"--component", "all"});
  EXPECT_EQ(json_of(all).at("mapped_vertices"), both.position.size());
  const Json at = json_of({"locate", "two.remaps", "--sphere", "0,0,1,1"})[0];
  EXPECT_EQ(at.at("sphere").at("component"), 1);
  run_well({"verify", "two.remaps", "--quiet"});
}

}  // namespace
}  // namespace remaps
