#include "remaps/pipeline/output_levels.h"

#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::MeshLists;

class OutputLevels : public test::TempFiles {
 protected:
  /// A bundle of a torus.
  std::filesystem::path bundle() const {
    const auto input = directory() / "in.ply";
    test::write_lists(test::scan(BaseShape::kTorus, 4'000), input);
    RemeshOptions options = test::remesh_options(directory(), input);
    options.output.clear();
    Progress progress;
    remesh(options, progress);
    return options.bundle;
  }
  static Report resample(const std::filesystem::path& bundle, const std::filesystem::path& output,
                         std::optional<unsigned> coarsest, unsigned level, bool fit = false,
                         bool measure = false) {
    ResampleBundleOptions options;
    options.bundle = bundle;
    options.output = output;
    options.coarsest = coarsest;
    options.level = level;
    options.threads = 1;
    options.memory_bytes = 24 << 20;
    options.fit = fit;
    options.measure = measure;
    options.samples = 20'000;
    Progress progress;
    return resample_bundle(options, progress);
  }
};

TEST(LevelPath, PutsTheLevelBeforeTheExtension) {
  EXPECT_EQ(level_path("out.ply", 0), "out-l0.ply");
  EXPECT_EQ(level_path("a.b/c.d.OBJ", 12), "a.b/c.d-l12.OBJ");
}

TEST_F(OutputLevels, AreTheMeshesOfTheirLevelsByteForByte) {
  const auto from = bundle();
  for (const bool fit : {false, true}) {
    for (const std::string extension : {".ply", ".obj", ".off", ".stl", ".glb", ".vtp"}) {
      if (fit && extension != ".ply" && extension != ".vtp") continue;
      const Report report = resample(from, directory() / ("all" + extension), 0, 4, fit);
      ASSERT_EQ(report.outputs.size(), 5u);
      for (unsigned level = 0; level <= 4; ++level) {
        const auto single = directory() / ("one" + extension);
        const Report one = resample(from, single, std::nullopt, level, fit);
        const Report::Output& output = report.outputs[level];
        EXPECT_EQ(output.path, level_path(directory() / ("all" + extension), level).string());
        EXPECT_EQ(output.level, level);
        EXPECT_EQ(output.vertices, one.output_vertices);
        EXPECT_EQ(output.faces, one.output_faces);
        EXPECT_TRUE(bytes_of(output.path) == bytes_of(single)) << output.path << " fit " << fit;
        ASSERT_EQ(one.outputs.size(), 1u);
        EXPECT_EQ(one.outputs[0].path, single.string());
      }
      EXPECT_EQ(report.level, 4u);
      EXPECT_EQ(report.output_path, report.outputs.back().path);
      EXPECT_EQ(report.output_faces, report.outputs.back().faces);
      EXPECT_FALSE(std::filesystem::exists(directory() / ("all" + extension)));
    }
  }
  // in.ply, the bundle, and for each format one mesh and five levels.
  EXPECT_EQ(entries_in(directory()), 2u + 6 * 6);
}

TEST_F(OutputLevels, MayBeginAnywhere) {
  const auto from = bundle();
  const Report report = resample(from, directory() / "some.ply", 2, 3);
  ASSERT_EQ(report.outputs.size(), 2u);
  EXPECT_EQ(report.outputs[0].level, 2u);
  EXPECT_EQ(report.outputs[1].level, 3u);
  const Report one = resample(from, directory() / "one.ply", 3, 3);
  ASSERT_EQ(one.outputs.size(), 1u);
  EXPECT_TRUE(bytes_of(one.outputs[0].path) == bytes_of(report.outputs[1].path));
  EXPECT_EQ(entries_in(directory()), 2u + 3);
}

/// Whatever the format, the surface is the same.
TEST_F(OutputLevels, AreMeasuredInAnyFormat) {
  const auto from = bundle();
  for (const bool fit : {false, true}) {
    const Report ply = resample(from, directory() / "m.ply", std::nullopt, 3, fit, true);
    ASSERT_TRUE(ply.error && ply.quality);
    for (const std::string extension : {".obj", ".off", ".stl", ".glb", ".vtp"}) {
      const Report other = resample(from, directory() / ("m" + extension), 2, 3, fit, true);
      ASSERT_TRUE(other.error && other.quality) << extension;
      EXPECT_EQ(other.error->l2_forward, ply.error->l2_forward) << extension;
      EXPECT_EQ(other.error->max_backward, ply.error->max_backward) << extension;
      EXPECT_EQ(other.quality->area_ratio, ply.quality->area_ratio) << extension;
    }
  }
}

}  // namespace
}  // namespace remaps::pipeline
