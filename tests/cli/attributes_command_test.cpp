#include <nlohmann/json.hpp>

#include "cli/run_binary.h"
#include "support/attribute_files.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

class AttributesCommand : public CommandLine {
 protected:
  void put() const {
    const test::MeshLists mesh = test::scan(BaseShape::kTorus, 3'000);
    write_with_attributes(
        mesh,
        {{"heat",
          AttributeKind::scalar,
          AttributePer::vertex,
          {{"heat", ScalarType::float32}},
          false},
         {"part", AttributeKind::label, AttributePer::face, {{"part", ScalarType::int32}}, false}},
        {[](std::size_t v, std::size_t) { return double(v); },
         [](std::size_t f, std::size_t) { return double(f); },
         {}},
        directory() / "in.ply");
  }
};

TEST_F(AttributesCommand, InfoListsThemOfAMeshAndOfABundle) {
  put();
  const std::string text = run_well({"info", "in.ply"}).out;
  EXPECT_NE(text.find("carries   heat (float32), part (of faces, int32)\n"), std::string::npos)
      << text;
  const Json json = Json::parse(run_well({"info", "in.ply", "--json"}).out);
  ASSERT_EQ(json.at("attributes").size(), 2u);
  EXPECT_EQ(json.at("attributes")[1].at("name"), "part");
  EXPECT_EQ(json.at("attributes")[1].at("per"), "face");
  EXPECT_EQ(json.at("attributes")[0].at("components")[0].at("type"), "float32");
  run_well({"parameterize", "in.ply", "b.remaps", "--attributes", "part"});
  EXPECT_NE(run_well({"info", "b.remaps"}).out.find("carries   part\n"), std::string::npos);
}

TEST_F(AttributesCommand, RemeshCarriesThoseThatAreNamedAndSaysSo) {
  put();
  Finished done = run_well({"remesh", "in.ply", "a.ply", "--level", "2", "--no-measure"});
  EXPECT_NE(done.out.find("carried   heat, part (of faces)\n"), std::string::npos) << done.out;
  done = run_well({"remesh", "in.ply", "a.obj", "--level", "2", "--no-measure", "--json"});
  const Json report = Json::parse(done.out);
  ASSERT_EQ(report.at("attributes").size(), 2u);
  EXPECT_EQ(report.at("attributes")[0].at("kind"), "scalar");
  EXPECT_EQ(report.at("attributes")[0].at("written"), false);
  done = run_well(
      {"remesh", "in.ply", "b.ply", "--level", "2", "--attributes", "none", "--no-measure"});
  EXPECT_EQ(done.out.find("carried"), std::string::npos) << done.out;
  EXPECT_TRUE(test::read_attributes(directory() / "b.ply").specs.empty());
  run_well({"remesh", "in.ply", "b.ply", "--level", "2", "--attributes", "heat", "--no-measure"});
  EXPECT_EQ(test::read_attributes(directory() / "b.ply").specs.size(), 1u);
}

TEST_F(AttributesCommand, NamesThatAreNotThereAreRefused) {
  put();
  expect_failure(3, {"remesh", "in.ply", "a.ply", "--attributes", "heat,colour"},
                 {"in.ply", "no attribute 'colour'", "heat, part"});
  expect_failure(2, {"remesh", "in.ply", "a.ply", "--attributes", "heat,,part"},
                 {"--attributes", "empty name"});
  EXPECT_EQ(names_here(), std::vector<std::string>{"in.ply"});
}

}  // namespace
}  // namespace remaps
