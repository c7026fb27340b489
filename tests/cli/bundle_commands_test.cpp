#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/run_binary.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

/// in.ply of 3000 vertices and its bundle in.remaps.
class BundleCommands : public CommandLine {
 protected:
  void SetUp() override {
    generate("in.ply", "3k");
    run_well({"parameterize", "in.ply", "in.remaps", "--base-vertices", "40", "--quiet"});
  }
  Json locate(std::vector<std::string> questions) const {
    questions.insert(questions.begin(), {"locate", "in.remaps", "--json"});
    return Json::parse(run_well(questions).out);
  }
};

double distance(const Json& a, const Json& b) {
  return std::hypot(a.at(0).get<double>() - b.at(0).get<double>(),
                    a.at(1).get<double>() - b.at(1).get<double>(),
                    a.at(2).get<double>() - b.at(2).get<double>());
}

TEST_F(BundleCommands, InfoSummarizesTheManifest) {
  const std::string table = run_well({"info", "in.remaps"}).out;
  for (const char* const word : {"in.ply", "40 vertices", "1 component", "sweeps"}) {
    EXPECT_NE(table.find(word), std::string::npos) << table;
  }
  const Json manifest = Json::parse(run_well({"info", "in.remaps", "--json"}).out);
  EXPECT_EQ(manifest.at("format"), "remaps-bundle");
}

TEST_F(BundleCommands, ResampleMakesAnyLevel) {
  for (const char* const level : {"0", "3"}) {
    const Json report = Json::parse(run_well({"resample", "in.remaps", "out.ply", "--level", level,
                                              "--samples", "10k", "--json"})
                                        .out);
    const MeshContent out = read_mesh(directory() / "out.ply");
    EXPECT_EQ(report.at("output").at("vertices"), out.positions.size());
    EXPECT_EQ(std::to_string(report.at("level").get<int>()), level);
  }
}

TEST_F(BundleCommands, ResampleGivesWhatRemeshGives) {
  run_well({"remesh", "in.ply", "a.ply", "--base-vertices", "40", "--level", "3", "-q"});
  run_well({"resample", "in.remaps", "b.ply", "--level", "3", "-q"});
  EXPECT_EQ(bytes_of(directory() / "a.ply"), bytes_of(directory() / "b.ply"));
}

TEST_F(BundleCommands, VerifyPassesASoundBundle) {
  const Json json = Json::parse(run_well({"verify", "in.remaps", "--json"}).out);
  EXPECT_EQ(json.at("vertices"), read_mesh(directory() / "in.ply").positions.size());
  EXPECT_EQ(json.at("base").at("vertices"), 40);
  EXPECT_EQ(json.at("euler_characteristic"), 2);
  EXPECT_LT(json.at("round_trip_max"), 1e-4);
  EXPECT_NE(run_well({"verify", "in.remaps"}).out.find("sound"), std::string::npos);
}

TEST_F(BundleCommands, VerifyFindsAChangedByteInEachFile) {
  for (const auto& entry : std::filesystem::directory_iterator(directory() / "in.remaps")) {
    const std::string name = entry.path().filename().string();
    if (name == "manifest.json") continue;
    const std::string bytes = bytes_of(entry.path());
    std::string changed = bytes;
    changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] ^ 0x10);
    make_file("in.remaps/" + name, changed);
    expect_failure(6, {"verify", "in.remaps"}, {name});
    make_file("in.remaps/" + name, bytes);
  }
  run_well({"verify", "in.remaps", "--quiet"});
}

TEST_F(BundleCommands, LocateAnswersInTheOrderAsked) {
  const Json found = locate({"--base", "3,0.25,0.5", "--vertex", "17", "--input", "5,0.1,0.2",
                             "--vertex", "4", "--base", "0,0,1"});
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[0].at("asked").at("base").at("face"), 3);
  EXPECT_EQ(found[1].at("asked").at("vertex"), 17);
  EXPECT_EQ(found[2].at("asked").at("input").at("face"), 5);
  EXPECT_EQ(found[3].at("asked").at("vertex"), 4);
  EXPECT_EQ(found[4].at("base").at("face"), 0);

  const MeshContent in = read_mesh(directory() / "in.ply");
  const Vec3 p = in.positions[17];
  EXPECT_LT(distance(found[1].at("input").at("position"), Json{p.x, p.y, p.z}), 1e-6);
}

TEST_F(BundleCommands, LocateThereAndBackReturns) {
  const Json there = locate({"--input", "1000,0.2,0.3"})[0];
  const Json& base = there.at("base");
  std::ostringstream question;
  question.precision(17);
  question << base.at("face") << "," << base.at("u").get<double>() << ","
           << base.at("v").get<double>();
  const Json back = locate({"--base", question.str()})[0];
  EXPECT_LT(distance(there.at("input").at("position"), back.at("input").at("position")), 1e-6);
}

TEST_F(BundleCommands, LocateReadsFilesOfPoints) {
  make_file("points.csv",
            "kind,index,u,v\n"
            "# the tip of the nose\r\n"
            "\n"
            "vertex,17\n"
            " base , 3 , 0.25 , 0.5  # blanks are fine\n"
            "input,5,0.1,0.2\n");
  std::istringstream lines(run_well({"locate", "in.remaps", "--in", "points.csv"}).out);
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].find("asked,base_face,"), 0u);
  EXPECT_EQ(rows[1].find("vertex,"), 0u);
  EXPECT_EQ(rows[2].find("base,3,"), 0u);
  EXPECT_EQ(rows[3].find("input,"), 0u);
  for (const std::string& row : rows) {
    EXPECT_EQ(std::count(row.begin(), row.end(), ','), 15) << row;
  }
}

TEST_F(BundleCommands, LocateNamesTheBadLine) {
  for (const char* const line :
       {"vertx,17", "vertex", "vertex,-1", "vertex,1,2", "base,3,0.25", "base,3,0.8,0.8",
        "base,3,nan,0", "input,1.5,0,0", "base,3,0.1,0.2,0.7"}) {
    make_file("points.csv", std::string("vertex,1\n# fine so far\n") + line + "\n");
    expect_failure(3, {"locate", "in.remaps", "--in", "points.csv"}, {"points.csv", "line 3"});
  }
  expect_failure(3, {"locate", "in.remaps", "--in", "none.csv"}, {"none.csv"});
}

TEST_F(BundleCommands, LocateRefusesPointsThatAreNotThere) {
  expect_failure(3, {"locate", "in.remaps", "--vertex", "999999"}, {"999999"});
  expect_failure(3, {"locate", "in.remaps", "--base", "999999,0,0"}, {"999999"});
  expect_failure(3, {"locate", "in.remaps", "--base", "99999999999,0,0"}, {"99999999999"});
  expect_failure(3, {"locate", "in.remaps", "--input", "999999,0,0"}, {"999999"});
  expect_failure(2, {"locate", "in.remaps", "--vertex", "nose"}, {"--vertex", "nose"});
  expect_failure(2, {"locate", "in.remaps", "--base", "3,0.25"}, {"--base", "FACE,U,V"});
  expect_failure(2, {"locate", "in.remaps", "--base", "3,0.9,0.2"}, {"outside"});
}

}  // namespace
}  // namespace remaps
