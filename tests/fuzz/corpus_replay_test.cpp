#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fuzz_targets.h"
#include "remaps/store/file.h"

namespace remaps::fuzz {
namespace {

/// All files of one target's corpus, in order.
std::vector<std::filesystem::path> corpus(const std::filesystem::path& directory) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void replay(const std::filesystem::path& directory) {
  const std::string target = directory.filename().string();
  const auto files = corpus(directory);
  EXPECT_FALSE(files.empty()) << directory;
  for (const std::filesystem::path& path : files) {
    const std::string bytes = store::read_whole_file(path);
    EXPECT_NO_THROW(run_target(target, std::as_bytes(std::span(bytes)))) << path;
  }
}

TEST(FuzzCorpus, EveryMeshIsReadOrRefusedByTheLaws) {
  for (const auto& directory : corpus(REMAPS_FUZZ_CORPUS)) {
    const std::string name = directory.filename().string();
    if (std::filesystem::is_directory(directory) && name != "sections" && name != "bundle" &&
        name != "archive") {
      replay(directory);
    }
  }
}

TEST(FuzzCorpus, EverySectionIsReadOrRefusedByTheLaws) {
  replay(std::filesystem::path(REMAPS_FUZZ_CORPUS) / "sections");
}

TEST(FuzzCorpus, EveryBundleIsReadOrRefusedByTheLaws) {
  replay(std::filesystem::path(REMAPS_FUZZ_CORPUS) / "bundle");
}

TEST(FuzzCorpus, EveryArchiveIsDecodedOrRefusedByTheLaws) {
  replay(std::filesystem::path(REMAPS_FUZZ_CORPUS) / "archive");
}

/// Cut and changed at many places, the corpus keeps the laws too: a little fuzzing in every build.
TEST(FuzzCorpus, KeepsTheLawsWhenCutShort) {
  for (const auto& directory : corpus(REMAPS_FUZZ_CORPUS)) {
    const std::string name = directory.filename().string();
    if (!std::filesystem::is_directory(directory) || name == "bundle") continue;
    for (const std::filesystem::path& path : corpus(directory)) {
      const std::string bytes = store::read_whole_file(path);
      for (std::size_t i = 1; i < 8; ++i) {
        const auto part = std::as_bytes(std::span(bytes)).first(bytes.size() * i / 8);
        EXPECT_NO_THROW(run_target(name, part)) << path << ", the first " << part.size();
      }
    }
  }
}

}  // namespace
}  // namespace remaps::fuzz
