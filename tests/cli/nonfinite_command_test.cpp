#include <nlohmann/json.hpp>
#include <string>

#include "cli/run_binary.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

/// dirty.off: a strip of triangles; vertices 2 and 7 to 12 are not finite.
class NonfiniteCommand : public CommandLine {
 protected:
  void SetUp() override {
    std::string text = "OFF\n40 38 0\n";
    for (int v = 0; v < 40; ++v) {
      const bool wild = v == 2 || (v >= 7 && v <= 12);
      text += std::to_string(v / 2) + (wild ? " -1.#IND " : v % 2 == 0 ? " 0 " : " 1 ") + "0\n";
    }
    for (int f = 0; f < 38; ++f) {
      text += "3 " + std::to_string(f + f % 2) + " " + std::to_string(f + 1 - f % 2) + " " +
              std::to_string(f + 2) + "\n";
    }
    make_file("dirty.off", text);
  }
};

void expect_words(const std::string& text, std::initializer_list<std::string_view> words) {
  for (const std::string_view word : words)
    EXPECT_NE(text.find(word), std::string::npos) << text << "\nlacks: " << word;
}

TEST_F(NonfiniteCommand, CheckNamesTheFirstFew) {
  expect_words(run_well({"check", "dirty.off"}).out,
               {"defects   7 vertices not finite, in 11 faces: 2, 7, 8, 9, 10, …",
                "drops 7 vertices and 11 faces with them"});
  const Json json = Json::parse(run_well({"check", "dirty.off", "--json"}).out);
  EXPECT_EQ(json.at("defects").at("nonfinite_vertices"), 7);
  EXPECT_EQ(json.at("places").at("nonfinite_vertices"), Json::parse("[2, 7, 8, 9, 10]"));
  EXPECT_EQ(json.at("sound"), false);
}

TEST_F(NonfiniteCommand, InfoLeavesThemOutOfTheBox) {
  expect_words(run_well({"info", "dirty.off"}).out,
               {"7 vertices not finite", "x 0 … 19, y 0 … 1, z 0 … 0"});
  const Json json = Json::parse(run_well({"info", "dirty.off", "--json"}).out);
  EXPECT_EQ(json.at("nonfinite_vertices"), 7);
  EXPECT_EQ(json.at("bbox").at("high"), Json::parse("[19, 1, 0]"));
}

TEST_F(NonfiniteCommand, RemeshCountsThemAndStrictRefuses) {
  const std::vector<std::string> remesh = {"remesh", "dirty.off", "out.ply",  "--level",
                                           "1",      "--bundle",  "b.remaps", "--report",
                                           "r.json", "--samples", "1000"};
  expect_words(run_well(remesh).out, {"7 vertices not finite dropped", "11 faces with them"});
  const Json report = Json::parse(bytes_of(directory() / "r.json"));
  EXPECT_EQ(report.at("repairs").at("nonfinite_vertices"), 7);
  EXPECT_EQ(report.at("repairs").at("nonfinite_faces"), 11);
  run_well({"verify", "b.remaps"});
  run_well({"measure", "dirty.off", "out.ply", "--samples", "1000"});
  expect_failure(4, {"locate", "b.remaps", "--vertex", "8"}, {"vertex 8", "not finite"});
  std::vector<std::string> strict = remesh;
  strict[2] = "other.ply";
  strict[6] = "other.remaps";
  strict.push_back("--strict");
  expect_failure(4, strict, {"dirty.off", "7 vertices", "vertex 2", "face 0"});
}

TEST_F(NonfiniteCommand, ASurfaceWithoutAreaIsRefusedByName) {
  make_file("point.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n");
  expect_failure(4, {"remesh", "point.obj", "out.ply"}, {"point.obj", "no area"});
  expect_failure(4, {"measure", "dirty.off", "point.obj"}, {"point.obj", "no area"});
}

}  // namespace
}  // namespace remaps
