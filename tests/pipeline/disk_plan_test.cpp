#include "remaps/pipeline/disk_plan.h"

#include <gtest/gtest.h>

#include <string>

#include "remaps/base/errors.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

class DiskPlan : public test::TempFiles {};

TEST_F(DiskPlan, RefusesWhatDoesNotFitAndSaysWhatWould) {
  EXPECT_NO_THROW(check_disk_space(1, directory()));
  try {
    check_disk_space(std::uint64_t{1} << 60, directory());
    FAIL() << "an exbibyte was free";
  } catch (const BudgetError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find(directory().string()), std::string::npos);
    EXPECT_NE(what.find("1099511627776 MiB"), std::string::npos) << what;
    EXPECT_NE(what.find("--temp-dir"), std::string::npos);
  }
}

TEST_F(DiskPlan, LeavesAMissingInputToItsReader) {
  EXPECT_EQ(temporary_bytes_needed(directory() / "missing.ply"), 0u);
}

TEST_F(DiskPlan, CountsTheFilesBesideAGltf) {
  make_file("a.bin", std::string(5000, '\0'));
  const std::string json = R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "a.bin"}]})";
  EXPECT_EQ(temporary_bytes_needed(make_file("a.gltf", json)), 4 * (5000 + json.size()));
  EXPECT_EQ(temporary_bytes_needed(make_file("b.gltf", "{}")), 0u);
}

}  // namespace
}  // namespace remaps::pipeline
