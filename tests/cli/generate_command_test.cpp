#include <nlohmann/json.hpp>

#include "cli/run_binary.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

TEST_F(CommandLine, GenerateComesNearTheWantedNumberOfVertices) {
  const Finished finished = run_well({"generate", "a.ply", "--vertices", "20k", "--json"});
  const Json json = Json::parse(finished.out);
  EXPECT_NEAR(json.at("vertices").get<double>(), 20'000, 2'000);
  const MeshContent mesh = read_mesh(directory() / "a.ply");
  EXPECT_EQ(mesh.positions.size(), json.at("vertices"));
  EXPECT_EQ(mesh.triangles.size(), json.at("faces"));
}

TEST_F(CommandLine, GenerateDependsOnTheSeedOnly) {
  const std::string a = bytes_of(generate("a.ply", "5k", {"--seed", "7"}));
  EXPECT_EQ(a, bytes_of(generate("b.ply", "5k", {"--seed", "7", "--threads", "3"})));
  EXPECT_NE(a, bytes_of(generate("c.ply", "5k", {"--seed", "8"})));
  EXPECT_NE(a, bytes_of(generate("d.ply", "5k", {"--seed", "7", "--shuffled"})));
}

TEST_F(CommandLine, InfoCountsWhatGenerateWrote) {
  generate("a.obj", "3k", {"--base", "torus"});
  const Json json = Json::parse(run_well({"info", "a.obj", "--json"}).out);
  const MeshContent mesh = read_mesh(directory() / "a.obj");
  EXPECT_EQ(json.at("vertices"), mesh.positions.size());
  EXPECT_EQ(json.at("faces"), mesh.triangles.size());
  Box3 box;
  for (const Vec3& p : mesh.positions) box.add(p);
  EXPECT_EQ(json.at("bbox").at("low").at(0), box.low.x);
  EXPECT_EQ(json.at("bbox").at("high").at(2), box.high.z);
  EXPECT_EQ(json.at("bbox_diagonal"), box.diagonal());

  const std::string table = run_well({"info", "a.obj"}).out;
  for (const char* const word : {"vertices", "faces", "diagonal", "a.obj"}) {
    EXPECT_NE(table.find(word), std::string::npos) << table;
  }
}

TEST_F(CommandLine, MeasureOfAMeshAgainstItselfIsExact) {
  generate("a.ply", "2k");
  const Finished finished =
      run_well({"measure", "a.ply", "a.ply", "--samples", "10k", "--json", "--quiet"});
  const Json json = Json::parse(finished.out);
  EXPECT_LT(json.at("l2").get<double>(), 1e-12);
  EXPECT_EQ(json.at("samples_forward"), 10'000);
  EXPECT_TRUE(json.at("psnr").is_null() || json.at("psnr") > 200);
  EXPECT_EQ(finished.err, "");
}

}  // namespace
}  // namespace remaps
