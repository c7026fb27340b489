#include <nlohmann/json.hpp>

#include "cli/run_binary.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

Json parse_file(const std::filesystem::path& path) {
  std::ifstream file(path);
  return Json::parse(file);
}

/// All keys of the contract, with what they hold.
void expect_contract(const Json& report) {
  const auto expect_numbers = [&](const char* group, std::initializer_list<const char*> keys) {
    for (const char* const key : keys) {
      EXPECT_TRUE(report.at(group).at(key).is_number()) << group << "." << key;
    }
  };
  EXPECT_TRUE(report.at("input").at("path").is_string());
  expect_numbers("input", {"vertices", "faces", "bbox_diagonal", "components", "boundary_loops",
                           "euler_characteristic"});
  for (const auto& [name, count] : report.at("repairs").items()) {
    EXPECT_TRUE(count.is_number_unsigned()) << name;
  }
  expect_numbers("base", {"vertices", "faces"});
  EXPECT_TRUE(report.at("level").is_number_unsigned());
  expect_numbers("output", {"vertices", "faces"});
  expect_numbers("seconds", {"ingest", "sweeps", "map", "resample", "measure", "total"});
  for (const char* const key : {"cpu_seconds", "peak_rss_bytes", "memory_budget_bytes"}) {
    EXPECT_TRUE(report.at(key).is_number()) << key;
  }
  expect_numbers("io", {"bytes_read", "bytes_written"});
  EXPECT_FALSE(report.at("sweeps").empty());
  for (const Json& sweep : report.at("sweeps")) {
    for (const char* const key : {"faces_in", "faces_out", "segments"}) {
      EXPECT_TRUE(sweep.at(key).is_number_unsigned()) << key;
    }
  }
  expect_numbers("error", {"l2_forward", "l2_backward", "l2", "max_forward", "max_backward"});
  for (const Json& sample : report.at("memory_trace")) {
    EXPECT_TRUE(sample.at("seconds").is_number());
    EXPECT_TRUE(sample.at("rss_bytes").is_number_unsigned());
  }
}

std::vector<std::string> remesh_arguments(std::initializer_list<const char*> more = {}) {
  std::vector<std::string> arguments{"remesh", "in.ply",   "out.ply", "--base-vertices",
                                     "50",     "--level",  "2",       "--samples",
                                     "20k",    "--memory", "128M"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST_F(CommandLine, RemeshReportsAllKeysOfTheContract) {
  generate("in.ply", "5k");
  const Finished finished = run_well(remesh_arguments({"--report", "r.json"}));
  const Json report = parse_file(directory() / "r.json");
  expect_contract(report);

  const MeshContent in = read_mesh(directory() / "in.ply");
  const MeshContent out = read_mesh(directory() / "out.ply");
  EXPECT_EQ(report.at("input").at("vertices"), in.positions.size());
  EXPECT_EQ(report.at("input").at("faces"), in.triangles.size());
  EXPECT_EQ(report.at("output").at("vertices"), out.positions.size());
  EXPECT_EQ(report.at("output").at("faces"), out.triangles.size());
  EXPECT_EQ(report.at("output").at("faces"),
            16 * report.at("base").at("faces").get<std::uint64_t>());
  EXPECT_EQ(report.at("level"), 2);
  EXPECT_EQ(report.at("memory_budget_bytes"), 128u << 20);
  EXPECT_EQ(names_here(), (std::vector<std::string>{"in.ply", "out.ply", "r.json"}));

  for (const char* const word :
       {"input", "base", "output", "genus 0", "closed", "error", "PSNR", "time", "memory"}) {
    EXPECT_NE(finished.out.find(word), std::string::npos) << finished.out;
  }
}

TEST_F(CommandLine, RemeshWithJsonPrintsTheReportOnly) {
  generate("in.ply", "5k");
  const Finished finished = run_well(remesh_arguments({"--json", "--report", "r.json"}));
  const Json report = Json::parse(finished.out);
  expect_contract(report);
  EXPECT_EQ(report, parse_file(directory() / "r.json"));
}

TEST_F(CommandLine, QuietRemeshPrintsNothing) {
  generate("in.ply", "5k");
  const Finished finished = run_well(remesh_arguments({"--quiet"}));
  EXPECT_EQ(finished.out, "");
  EXPECT_EQ(finished.err, "");
}

TEST_F(CommandLine, NoBarIsDrawnOutsideATerminal) {
  generate("in.ply", "5k");
  const Finished finished = run_well(remesh_arguments());
  EXPECT_EQ(finished.err.find('\r'), std::string::npos);
  EXPECT_EQ(finished.err.find('\x1b'), std::string::npos);
}

TEST_F(CommandLine, RemeshSaysWhenTheBaseIsLargerThanAskedFor) {
  // Eight vertices cannot carry two handles.
  generate("in.ply", "5k", {"--base", "double-torus"});
  const Finished finished = run_well({"remesh", "in.ply", "out.ply", "--base-vertices", "4",
                                      "--level", "1", "--no-measure", "--report", "r.json"});
  EXPECT_NE(finished.out.find("asked for 4 base vertices"), std::string::npos) << finished.out;
  EXPECT_NE(finished.out.find("genus 2"), std::string::npos) << finished.out;
  EXPECT_EQ(finished.out.find("PSNR"), std::string::npos) << finished.out;
  EXPECT_FALSE(parse_file(directory() / "r.json").contains("error"));
}

TEST_F(CommandLine, RemeshTellsOfFeatures) {
  generate("in.ply", "5k");
  const Finished finished =
      run_well(remesh_arguments({"--feature-angle", "179.5", "--report", "r.json"}));
  EXPECT_NE(finished.out.find("features  0 edges sharper than 179.5 degrees; on the base 0 edges"),
            std::string::npos)
      << finished.out;
  const Json features = parse_file(directory() / "r.json").at("features");
  EXPECT_EQ(features.at("angle_deg"), 179.5);
  EXPECT_EQ(features.at("edges"), 0);
  EXPECT_EQ(features.at("corners"), 0);
  run_well(remesh_arguments({"--report", "r.json"}));
  EXPECT_FALSE(parse_file(directory() / "r.json").contains("features"));
}

TEST_F(CommandLine, RemeshAcceptsSizesWithSuffixes) {
  generate("in.ply", "2k");
  const std::pair<const char*, std::uint64_t> sizes[] = {{"134217728", 128u << 20},
                                                         {"131072K", 128u << 20},
                                                         {"128m", 128u << 20},
                                                         {"0.125G", 128u << 20},
                                                         {"1.5G", 1536u << 20}};
  for (const auto& [text, bytes] : sizes) {
    const Finished finished =
        run_well({"remesh", "in.ply", "out.ply", "--base-vertices", "50", "--level", "0",
                  "--no-measure", "--json", "--memory", text});
    EXPECT_EQ(Json::parse(finished.out).at("memory_budget_bytes"), bytes) << text;
  }
}

TEST_F(CommandLine, PathsMayHoldBlanksAndLookLikeDirectories) {
  generate("my scan.ply", "2k");
  run_well({"parameterize", "my scan.ply", "my bundle.remaps/", "--base-vertices", "50", "-q"});
  EXPECT_TRUE(std::filesystem::exists(directory() / "my bundle.remaps" / "manifest.json"));
  // An earlier bundle may be replaced.
  run_well({"parameterize", "my scan.ply", "my bundle.remaps", "--base-vertices", "60", "-q"});
  EXPECT_EQ(names_here(), (std::vector<std::string>{"my bundle.remaps", "my scan.ply"}));
}

TEST_F(CommandLine, RemeshWritesOneMeshALevel) {
  generate("in.ply", "2k");
  const Finished finished = run_well({"remesh", "in.ply", "out.glb", "--base-vertices", "50",
                                      "--levels", "1..3", "--no-measure", "--report", "r.json"});
  EXPECT_EQ(names_here(), (std::vector<std::string>{"in.ply", "out-l1.glb", "out-l2.glb",
                                                    "out-l3.glb", "r.json"}));
  const Json report = parse_file(directory() / "r.json");
  EXPECT_EQ(report.at("level"), 3);
  EXPECT_EQ(report.at("output").at("path"), "out-l3.glb");
  ASSERT_EQ(report.at("outputs").size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Json& output = report.at("outputs").at(i);
    EXPECT_EQ(output.at("level"), i + 1);
    const MeshContent mesh = read_mesh(directory() / output.at("path").get<std::string>());
    EXPECT_EQ(output.at("vertices"), mesh.positions.size());
    EXPECT_EQ(output.at("faces"), mesh.triangles.size());
    EXPECT_NE(finished.out.find(output.at("path").get<std::string>()), std::string::npos);
  }
}

TEST_F(CommandLine, RemeshRefusesLevelsThatAreNoRange) {
  generate("in.ply", "500");
  for (const char* const bad : {"5..0", "0..15", "..3", "1..", "a..b", "1-3", "0...2", ""}) {
    expect_failure(2, {"remesh", "in.ply", "out.ply", "--levels", bad}, {"--levels"});
  }
  expect_failure(2, {"remesh", "in.ply", "out.ply", "--levels", "0..2", "--level", "3"},
                 {"--level"});
  // The names of the levels count.
  generate("out-l1.ply", "500");
  expect_failure(2, {"remesh", "out-l1.ply", "out.ply", "--levels", "0..2"}, {"out-l1.ply"});
  std::filesystem::create_directory(directory() / "dir-l2.ply");
  expect_failure(2, {"remesh", "in.ply", "dir.ply", "--levels", "0..2"}, {"dir-l2.ply"});
}

TEST_F(CommandLine, RemeshRefusesATooLargeGlbBeforeItStarts) {
  generate("in.ply", "5k");
  expect_failure(5, {"remesh", "in.ply", "out.glb", "--base-vertices", "1000", "--level", "14"},
                 {"out.glb", "4 GiB", ".ply"});
}

}  // namespace
}  // namespace remaps
