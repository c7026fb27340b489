#include "remaps/pipeline/bundle.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <string_view>

#include "remaps/base/errors.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

class BundleTest : public test::TempFiles {
 protected:
  BundleTest() {
    const auto input = directory() / "in.ply";
    test::write_lists(test::lists_of(test::bumpy(test::torus(30, 20), 0.05, 0.01, 1)), input);
    RemeshOptions options = test::remesh_options(directory(), input);
    options.output.clear();
    Progress progress;
    remesh(options, progress);
    path_ = options.bundle;
  }
  void put_back(const std::string& name, const std::string& bytes) const {
    make_file("out.remaps/" + name, bytes);
  }

  std::filesystem::path path_;
};

TEST_F(BundleTest, ReadsBackAManifest) {
  const Bundle bundle(path_);
  Manifest m = bundle.manifest();
  EXPECT_EQ(m.input_vertices, 600u);
  EXPECT_EQ(m.topology.faces, 1200u);
  EXPECT_EQ(m.topology.euler_characteristic(), 0);
  EXPECT_EQ(m.input_name, "in.ply");
  m.input_name = "a \"strange\" name\n";
  m.origin = {0.1, -1e300, 3};
  m.diagonal = 1.0 / 3;
  m.map_checksum = ~std::uint64_t{0};
  m.base_vertices_requested = std::uint64_t{1} << 60;
  write_manifest(m, path_);
  const Manifest back = Bundle(path_).manifest();
  EXPECT_EQ(back.input_name, m.input_name);
  EXPECT_EQ(back.input_vertices, m.input_vertices);
  EXPECT_EQ(back.topology, m.topology);
  EXPECT_EQ(back.origin, m.origin);
  EXPECT_EQ(back.diagonal, m.diagonal);
  EXPECT_EQ(back.base_vertices_requested, m.base_vertices_requested);
  EXPECT_EQ(back.segments, m.segments);
  EXPECT_EQ(back.map_checksum, m.map_checksum);
  EXPECT_EQ(back.base_checksum, m.base_checksum);
}

TEST_F(BundleTest, RefusesABaseThatIsNotFinite) {
  std::ifstream file(path_ / "base.ply", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string_view end = "end_header\n";
  std::memcpy(bytes.data() + bytes.find(end) + end.size() + 16, &nan, sizeof nan);
  put_back("base.ply", bytes);
  try {
    Bundle bundle(path_);
    ADD_FAILURE() << "was read";
  } catch (const CorruptionError& error) {
    EXPECT_NE(std::string(error.what()).find("base.ply: vertex 1 is not finite"), std::string::npos)
        << error.what();
  }
}

TEST_F(BundleTest, RefusesWhatIsNoBundle) {
  EXPECT_THROW(Bundle(directory() / "absent"), InputError);
  EXPECT_THROW(Bundle{directory()}, InputError);
}

TEST_F(BundleTest, RefusesDamagedManifestsOrReadsThem) {
  const std::string whole = bytes_of(path_ / kManifestName);
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    std::string damaged = whole;
    damaged[random() % damaged.size()] = static_cast<char>(random() % 128);
    if (i % 5 == 0) damaged.resize(random() % damaged.size());
    put_back(kManifestName, damaged);
    try {
      const Bundle bundle(path_);
    } catch (const CorruptionError& error) {
      EXPECT_NE(std::string(error.what()), "");
    }
  }
  for (const char* const content : {"", "{}", "[]", "null", "{\"format\": \"remaps-bundle\"}"}) {
    put_back(kManifestName, content);
    EXPECT_THROW(Bundle{path_}, CorruptionError) << content;
  }
}

TEST_F(BundleTest, RefusesABundleWithAPartMissing) {
  for (const std::string& name : {log_name(0), std::string(kTilesName), std::string(kBaseName)}) {
    const std::string bytes = bytes_of(path_ / name);
    std::filesystem::remove(path_ / name);
    EXPECT_THROW(Bundle{path_}, CorruptionError) << name;
    put_back(name, bytes.substr(0, bytes.size() / 2));
    EXPECT_THROW(Bundle{path_}, CorruptionError) << name;
    put_back(name, bytes);
    EXPECT_NO_THROW(Bundle{path_});
  }
}

}  // namespace
}  // namespace remaps::pipeline
