#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "remaps/pipeline/remesh.h"
#include "support/attribute_files.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::AttributeLists;
using test::MeshLists;

/// A prism over a U, whose ends no fan covers from any corner. Texture coordinates of corners are
/// x and y of their positions.
class PolygonAttributes : public test::TempFiles {
 protected:
  static constexpr std::array<std::array<int, 2>, 8> kOutline = {
      {{3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}, {0, 0}}};

  static std::vector<std::vector<int>> polygons() {
    std::vector<std::vector<int>> all(2);
    for (int i = 0; i < 8; ++i) {
      all[0].push_back(8 + i);
      all[1].push_back(7 - i);
      const int next = (i + 1) % 8;
      all.push_back({i, next, 8 + next, 8 + i});
    }
    return all;
  }
  static std::array<int, 3> at(int v) {
    const auto& p = kOutline[static_cast<std::size_t>(v % 8)];
    return {p[0], p[1], v / 8};
  }
  void put_obj() const {
    std::string text;
    for (int v = 0; v < 16; ++v) {
      const auto p = at(v);
      text += fmt::format("v {} {} {}\nvt {} {}\n", p[0], p[1], p[2], p[0], p[1]);
    }
    for (const auto& polygon : polygons()) {
      text += "f";
      for (const int v : polygon) text += fmt::format(" {}/{}", v + 1, v + 1);
      text += "\n";
    }
    std::ofstream(directory() / "in.obj") << text;
  }
  void put_ply() const {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 16\nproperty float x\nproperty float y\n"
        "property float z\nelement face 10\nproperty list uchar float texcoord\n"
        "property list uchar int vertex_indices\nend_header\n";
    for (int v = 0; v < 16; ++v) text += fmt::format("{} {} {}\n", at(v)[0], at(v)[1], at(v)[2]);
    for (const auto& polygon : polygons()) {
      text += fmt::format("{}", 2 * polygon.size());
      for (const int v : polygon) text += fmt::format(" {} {}", at(v)[0], at(v)[1]);
      text += fmt::format(" {}", polygon.size());
      for (const int v : polygon) text += fmt::format(" {}", v);
      text += "\n";
    }
    std::ofstream(directory() / "in.ply") << text;
  }
  void expect_positions_as_texture(const std::string& input, std::optional<double> weld) const {
    RemeshOptions o = test::remesh_options(directory(), directory() / input);
    o.base_vertices = 16;
    o.weld_distance = weld;
    Progress progress;
    remesh(o, progress);
    const MeshLists mesh = test::read_lists(o.output);
    const AttributeLists found = test::read_attributes(o.output);
    const auto u = found.column("uv", 0), v = found.column("uv", 1);
    ASSERT_EQ(u.size(), 3 * mesh.triangle.size()) << input;
    for (std::size_t c = 0; c < u.size(); ++c) {
      const Vec3& p = mesh.position[mesh.triangle[c / 3][c % 3]];
      EXPECT_NEAR(u[c], p.x, 1e-5) << input << ", corner " << c;
      EXPECT_NEAR(v[c], p.y, 1e-5) << input << ", corner " << c;
    }
  }
};

TEST_F(PolygonAttributes, FollowTheEarsOfConcavePolygons) {
  put_obj();
  put_ply();
  for (const char* const input : {"in.obj", "in.ply"}) {
    expect_positions_as_texture(input, std::nullopt);
    expect_positions_as_texture(input, 0.0);
  }
}

}  // namespace
}  // namespace remaps::pipeline
