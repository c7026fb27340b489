#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/run_binary.h"
#include "remaps/sphere/octahedral_unfolding.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

/// s.remaps: a bundle of some 3000 vertices with a sphere.
class ImageCommand : public CommandLine {
 protected:
  void SetUp() override {
    generate("in.ply", "3k");
    run_well({"sphere", "in.ply", "s.remaps", "--intermediate-faces", "400", "--quiet"});
  }
  Json json_of(std::vector<std::string> command) const {
    command.push_back("--json");
    return Json::parse(run_well(command).out);
  }
  std::string content_of(const std::string& name) const {
    std::ifstream file(directory() / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// The pixels of an .npy of so many a side.
  std::vector<Vec3f> pixels_of(const std::string& name, std::size_t side) const {
    const std::string bytes = content_of(name);
    std::vector<Vec3f> result(side * side);
    const std::size_t data = result.size() * sizeof(Vec3f);
    EXPECT_GT(bytes.size(), data);
    std::memcpy(result.data(), bytes.data() + bytes.size() - data, data);
    return result;
  }
};

TEST_F(ImageCommand, GeometryIsWhatLocateFindsAndItsSidesClose) {
  const Json said = json_of({"image", "s.remaps", "g.npy", "--size", "65", "--samples", "20k"});
  EXPECT_EQ(said.at("samples"), 64 * 64 + 2);
  EXPECT_GT(said.at("error").at("l2").get<double>(), 0);
  EXPECT_LT(said.at("error").at("l2").get<double>(), 3e-3);
  const std::vector<Vec3f> pixel = pixels_of("g.npy", 65);
  const auto at = [&](std::size_t row, std::size_t column) { return pixel[row * 65 + column]; };
  for (std::size_t i = 0; i < 65; ++i) {
    EXPECT_EQ(at(0, i), at(0, 64 - i));
    EXPECT_EQ(at(64, i), at(64, 64 - i));
    EXPECT_EQ(at(i, 0), at(64 - i, 0));
    EXPECT_EQ(at(i, 64), at(64 - i, 64));
  }
  EXPECT_EQ(at(0, 0), at(64, 64));
  EXPECT_FALSE(at(0, 0) == at(0, 32));
  const sphere::OctahedralGrid grid(65);
  for (const auto& [row, column] : {std::pair{32u, 32u}, std::pair{7u, 50u}, std::pair{0u, 0u}}) {
    const Vec3 d = grid.direction(row, column);
    const Json found = json_of(
        {"locate", "s.remaps", fmt::format("--sphere={:.17g},{:.17g},{:.17g}", d.x, d.y, d.z)})[0];
    const Json& position = found.at("input").at("position");
    const Vec3 there{position[0], position[1], position[2]};
    EXPECT_LT(norm(there - widen(at(row, column))), 1e-6);
  }
}

TEST_F(ImageCommand, TheMeshIsClosedAndHasTheImagesError) {
  const Json said = json_of({"image", "s.remaps", "g.ply", "--size", "65", "--samples", "20k"});
  const Json checked = json_of({"check", "g.ply"});
  const MeshContent mesh = read_mesh(directory() / "g.ply");
  EXPECT_EQ(mesh.positions.size(), 64u * 64 + 2);
  EXPECT_EQ(mesh.triangles.size(), 2u * 64 * 64);
  EXPECT_TRUE(checked.at("sound").get<bool>()) << checked;
  EXPECT_NE(checked.dump().find("\"euler_characteristic\":2"), std::string::npos) << checked;
  const Json measured = json_of({"measure", "in.ply", "g.ply", "--samples", "20k"});
  EXPECT_NEAR(measured.at("l2").get<double>() / said.at("error").at("l2").get<double>(), 1, 0.05);
  // Outside is outside: the volume is positive.
  double volume = 0;
  for (const Triangle& t : mesh.triangles) {
    volume += dot(mesh.positions[t[0]], cross(mesh.positions[t[1]], mesh.positions[t[2]]));
  }
  EXPECT_GT(volume, 0);
}

TEST_F(ImageCommand, NormalsAreThoseOfTheInput) {
  const Json said = json_of({"image", "s.remaps", "n.npy", "--kind", "normal", "--size", "32"});
  EXPECT_EQ(said.at("samples"), 32 * 32 * 16);
  run_well({"image", "s.remaps", "g.npy", "--size", "65", "--quiet"});
  const std::vector<Vec3f> normal = pixels_of("n.npy", 32), place = pixels_of("g.npy", 65);
  // A pixel lies in the middle of 2 x 2 cells of the geometry image, around a sample of it.
  double sum = 0;
  for (std::size_t row = 0; row < 32; ++row) {
    for (std::size_t column = 0; column < 32; ++column) {
      const Vec3 n = widen(normal[row * 32 + column]);
      EXPECT_NEAR(norm(n), 1, 1e-6);
      const auto at = [&](std::size_t r, std::size_t c) { return widen(place[r * 65 + c]); };
      const std::size_t r = 2 * row, c = 2 * column;
      const Vec3 flat = cross(at(r + 2, c + 2) - at(r, c), at(r, c + 2) - at(r + 2, c));
      sum += dot(n, flat) / norm(flat);
    }
  }
  EXPECT_GT(sum / (32 * 32), 0.95);
}

TEST_F(ImageCommand, ColoursAreThoseOfTheVertices) {
  const MeshContent mesh = read_mesh(directory() / "in.ply");
  const auto colour_at = [](const Vec3& p) {
    return Vec3{0.5 + 0.3 * p.x, 0.5 + 0.3 * p.y, 0.5 - 0.3 * p.z};
  };
  {
    std::ofstream file(directory() / "coloured.obj");
    for (const Vec3& p : mesh.positions) {
      const Vec3 c = colour_at(p);
      file << fmt::format("v {} {} {} {} {} {}\n", p.x, p.y, p.z, c.x, c.y, c.z);
    }
    for (const Triangle& t : mesh.triangles) {
      file << fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
  }
  run_well({"sphere", "coloured.obj", "c.remaps", "--intermediate-faces", "400", "--quiet"});
  run_well({"image", "c.remaps", "c.npy", "--kind", "color", "--size", "32", "--quiet"});
  run_well({"image", "c.remaps", "g.npy", "--size", "65", "--quiet"});
  const std::vector<Vec3f> colour = pixels_of("c.npy", 32), place = pixels_of("g.npy", 65);
  for (std::size_t row = 0; row < 32; ++row) {
    for (std::size_t column = 0; column < 32; ++column) {
      const Vec3 there = widen(place[(2 * row + 1) * 65 + 2 * column + 1]);
      EXPECT_LT(norm(widen(colour[row * 32 + column]) - colour_at(there)), 0.03)
          << row << ' ' << column;
    }
  }
  expect_failure(3, {"image", "s.remaps", "x.png", "--kind", "color"}, {"s.remaps", "colours"});
}

TEST_F(ImageCommand, ThreadsMakeNoDifference) {
  for (const std::string kind : {"geometry", "normal"}) {
    for (const std::string extension : {"exr", "png"}) {
      const std::string a = "a." + extension, b = "b." + extension;
      run_well({"image", "s.remaps", a, "--kind", kind, "--size", "33", "--threads", "1", "-q"});
      run_well({"image", "s.remaps", b, "--kind", kind, "--size", "33", "--threads", "3", "-q"});
      EXPECT_FALSE(content_of(a).empty());
      EXPECT_EQ(content_of(a), content_of(b));
    }
  }
}

TEST_F(ImageCommand, BadUsesAreRefusedAndNothingIsLeft) {
  run_well({"parameterize", "in.ply", "p.remaps", "--quiet"});
  const std::vector<std::string> before = names_here();
  expect_failure(3, {"image", "p.remaps", "g.exr"}, {"remaps sphere"});
  expect_failure(2, {"image", "s.remaps", "g.jpg"}, {"g.jpg", ".exr"});
  expect_failure(2, {"image", "s.remaps", "n.ply", "--kind", "normal"}, {"n.ply", ".exr"});
  expect_failure(2, {"image", "s.remaps", "g.exr", "--size", "64"}, {"odd", "65"});
  expect_failure(3, {"image", "s.remaps", "g.exr", "--size", "100001"}, {"100001"});
  expect_failure(3, {"image", "s.remaps", "g.exr", "--size", "5000000001"}, {"16385"});
  expect_failure(3, {"image", "s.remaps", "g.exr", "--component", "1"}, {"component 1"});
  expect_failure(3, {"image", "s.remaps", "g.exr", "--component", "5000000000"}, {"component"});
  expect_failure(5, {"image", "s.remaps", "g.exr", "--size", "8193", "--memory", "64M"},
                 {"8193 x 8193"});
  EXPECT_EQ(names_here(), before);
}

}  // namespace
}  // namespace remaps
