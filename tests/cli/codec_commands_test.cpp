#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/run_binary.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

/// in.ply of 2000 vertices, its bundle in.remaps, and an archive of it with a table, in.remapsa.
class CodecCommands : public CommandLine {
 protected:
  void SetUp() override {
    generate("in.ply", "2k");
    run_well({"parameterize", "in.ply", "in.remaps", "--base-vertices", "40", "--quiet"});
    run_well({"encode", "in.remaps", "in.remapsa", "--level", "3", "--samples", "5k", "--quiet"});
  }
  Json json_of(std::vector<std::string> command) const {
    command.push_back("--json");
    return Json::parse(run_well(command).out);
  }
  std::uint64_t size_of(const std::string& name) const {
    return std::filesystem::file_size(directory() / name);
  }
  std::string number(const Json& json) const { return std::to_string(json.get<std::uint64_t>()); }
};

TEST_F(CodecCommands, EncodeAndInfoSayWhatIsThere) {
  const Json encoded = json_of({"encode", "in.remaps", "a", "--level", "3", "--samples", "5k"});
  const Json info = json_of({"info", "a"});
  EXPECT_EQ(encoded, info);
  EXPECT_EQ(info.at("bytes"), size_of("a"));
  EXPECT_EQ(info.at("complete_bytes"), size_of("a"));
  EXPECT_EQ(info.at("level"), 3);
  EXPECT_EQ(info.at("wavelet"), "butterfly-lifted");
  EXPECT_EQ(info.at("bitplanes"), 12);
  EXPECT_EQ(info.at("base").at("vertices"), 40);
  EXPECT_EQ(info.at("faces"), info.at("base").at("faces").get<int>() * 64);
  const Json& points = info.at("rate_distortion");
  ASSERT_GE(points.size(), 5u);
  for (std::size_t i = 1; i < points.size(); ++i) {
    EXPECT_GT(points[i].at("bytes"), points[i - 1].at("bytes"));
    EXPECT_GT(points[i].at("psnr").get<double>(), points[i - 1].at("psnr").get<double>() - 0.5);
  }
  const std::string table = run_well({"info", "a"}).out;
  for (const char* const word : {"40 vertices", "level     3", "butterfly-lifted", "PSNR"}) {
    EXPECT_NE(table.find(word), std::string::npos) << table;
  }
}

TEST_F(CodecCommands, DecodeMakesAnyLevelOfAnyPrefix) {
  const Json info = json_of({"info", "in.remapsa"});
  const int base_faces = info.at("base").at("faces").get<int>();
  for (const int level : {0, 2, 3}) {
    for (const Json& bytes : {info.at("least_bytes"), Json(1000), info.at("bytes")}) {
      const Json report = json_of({"decode", "in.remapsa", "out.ply", "--level",
                                   std::to_string(level), "--bytes", number(bytes)});
      const MeshContent out = read_mesh(directory() / "out.ply");
      EXPECT_EQ(report.at("level"), level);
      EXPECT_EQ(report.at("bytes"), bytes);
      EXPECT_EQ(report.at("faces"), base_faces << (2 * level));
      EXPECT_EQ(report.at("faces"), out.triangles.size());
      EXPECT_EQ(report.at("vertices"), out.positions.size());
    }
  }
}

TEST_F(CodecCommands, ACutFileIsItsPrefix) {
  run_well({"decode", "in.remapsa", "a.ply", "--bytes", "1500", "-q"});
  make_file("cut", bytes_of(directory() / "in.remapsa").substr(0, 1500));
  run_well({"decode", "cut", "b.ply", "-q"});
  EXPECT_EQ(bytes_of(directory() / "a.ply"), bytes_of(directory() / "b.ply"));
  const Json info = json_of({"info", "cut"});
  EXPECT_EQ(info.at("bytes"), 1500);
  EXPECT_EQ(info.at("complete_bytes"), size_of("in.remapsa"));
}

TEST_F(CodecCommands, PsnrTakesTheBytesOfTheTable) {
  const Json points = json_of({"info", "in.remapsa"}).at("rate_distortion");
  const Json& middle = points.at(points.size() / 2);
  const std::string psnr = std::to_string(middle.at("psnr").get<double>() - 0.001);
  const Json report = json_of({"decode", "in.remapsa", "out.ply", "--psnr", psnr});
  EXPECT_LE(report.at("bytes"), middle.at("bytes"));
  expect_failure(3, {"decode", "in.remapsa", "out2.ply", "--psnr", "200"}, {"in.remapsa", "200"});
  run_well({"encode", "in.remaps", "bare", "--level", "2", "--no-measure", "-q"});
  expect_failure(3, {"decode", "bare", "out2.ply", "--psnr", "40"}, {"bare", "--bytes"});
}

TEST_F(CodecCommands, MaxBytesIsObeyed) {
  const std::uint64_t least = json_of({"info", "in.remapsa"}).at("least_bytes");
  for (const std::uint64_t most : {least, least + 1, least + 7, least + 130, least + 500,
                                   least + 501, least + 2000, std::uint64_t{1} << 20}) {
    for (const bool measure : {false, true}) {
      std::vector<std::string> command = {
          "encode",      "in.remaps",          "a",         "--level", "3", "-q",
          "--max-bytes", std::to_string(most), "--samples", "1k"};
      if (!measure) command.emplace_back("--no-measure");
      run_well(command);
      EXPECT_LE(size_of("a"), most);
      if (!measure && most < size_of("in.remapsa")) {
        EXPECT_GE(size_of("a") + 8, most);
      }
      run_well({"decode", "a", "out.ply", "-q"});
    }
  }
  expect_failure(
      5, {"encode", "in.remaps", "b", "--level", "3", "--max-bytes", std::to_string(least - 1)},
      {std::to_string(least)});
  EXPECT_FALSE(std::filesystem::exists(directory() / "b"));
}

TEST_F(CodecCommands, MaxBytesIsObeyedWithColoursToo) {
  std::filesystem::copy_file(std::filesystem::path(REMAPS_TEST_DATA) / "golden-v1-open.ply",
                             directory() / "coloured.ply");
  const Json info = json_of({"encode", "coloured.ply", "a", "--no-measure"});
  const std::uint64_t least = info.at("least_bytes"), all = info.at("bytes");
  for (std::uint64_t most = least; most < all + 20; most += most < least + 60 ? 7 : 61) {
    run_well(
        {"encode", "coloured.ply", "a", "--no-measure", "-q", "--max-bytes", std::to_string(most)});
    EXPECT_LE(size_of("a"), most);
    run_well({"decode", "a", "out.ply", "-q"});
  }
}

TEST_F(CodecCommands, TargetPsnrIsReached) {
  const Json whole = json_of({"info", "in.remapsa"}).at("rate_distortion").back();
  const double target = whole.at("psnr").get<double>() - 6;
  const Json info = json_of({"encode", "in.remaps", "a", "--level", "3", "--samples", "5k",
                             "--target-psnr", std::to_string(target)});
  EXPECT_GE(info.at("rate_distortion").back().at("psnr").get<double>(), target - 0.01);
  EXPECT_LT(info.at("bytes"), whole.at("bytes"));
  expect_failure(
      4, {"encode", "in.remaps", "b", "--level", "3", "--samples", "1k", "--target-psnr", "300"},
      {"--target-psnr"});
  EXPECT_FALSE(std::filesystem::exists(directory() / "b"));
}

TEST_F(CodecCommands, TakesMeshesWithSubdivisionConnectivity) {
  run_well({"decode", "in.remapsa", "a.obj", "-q"});
  const Json info = json_of({"encode", "a.obj", "b", "--no-measure"});
  EXPECT_EQ(info.at("level"), 3);
  EXPECT_EQ(info.at("base").at("vertices"), 40);
  expect_failure(4, {"encode", "in.ply", "c", "--no-measure"}, {"in.ply"});
}

TEST_F(CodecCommands, BadUsesAreRefused) {
  expect_failure(2, {"encode", "in.remaps"});
  expect_failure(2, {"encode", "in.remaps", "a", "--wavelet", "haar"}, {"haar"});
  expect_failure(2, {"encode", "in.remaps", "a", "--max-bytes", "many"}, {"many"});
  expect_failure(2, {"encode", "in.remaps", "a", "--target-psnr", "-3"}, {"-3"});
  expect_failure(2, {"encode", "in.remaps", "a", "--no-measure", "--target-psnr", "60"},
                 {"--no-measure"});
  expect_failure(2, {"decode", "in.remapsa", "out.xyz"}, {"out.xyz"});
  expect_failure(2, {"decode", "in.remapsa", "out.ply", "--bytes", "-1"}, {"-1"});
  expect_failure(2, {"decode", "in.remapsa", "out.ply", "--level", "15"}, {"15"});
}

TEST_F(CodecCommands, WhatIsNoArchiveIsRefusedAndNothingIsWritten) {
  const std::string bytes = bytes_of(directory() / "in.remapsa");
  const std::vector<std::string> before = names_here();
  const std::uint64_t least = json_of({"info", "in.remapsa"}).at("least_bytes");
  expect_failure(3, {"decode", "none", "out.ply"}, {"none"});
  expect_failure(3, {"decode", "in.ply", "out.ply"}, {"in.ply", "byte 0"});
  expect_failure(3, {"decode", "in.remapsa", "out.ply", "--bytes", std::to_string(least - 1)},
                 {std::to_string(least)});
  expect_failure(3, {"decode", "in.remapsa", "out.ply", "--level", "4"}, {"level 4"});
  expect_failure(5, {"decode", "in.remapsa", "out.ply", "--memory", "100k"}, {"--memory"});
  EXPECT_EQ(names_here(), before);
  for (const std::size_t size : {std::size_t{10}, std::size_t{71}, std::size_t{least - 1}}) {
    make_file("cut", bytes.substr(0, size));
    expect_failure(3, {"decode", "cut", "out.ply"}, {"cut", std::to_string(size)});
  }
  for (const std::size_t at : {std::size_t{20}, std::size_t{90}, bytes.size() / 2}) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    make_file("cut", changed);
    expect_failure(6, {"decode", "cut", "out.ply"}, {"cut"});
    expect_failure(6, {"info", "cut"}, {"cut"});
  }
  EXPECT_FALSE(std::filesystem::exists(directory() / "out.ply"));
}

}  // namespace
}  // namespace remaps
