#include "remaps/pipeline/map_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/pipeline/bundle.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

class MapFileTest : public test::TempFiles {
 protected:
  std::vector<MapRecord> records() const {
    const std::string bytes = bytes_of(path());
    std::vector<MapRecord> result(bytes.size() / sizeof(MapRecord));
    std::memcpy(result.data(), bytes.data(), result.size() * sizeof(MapRecord));
    return result;
  }
  std::filesystem::path path() const { return directory() / "map.bin"; }

  MemoryBudget budget_{std::uint64_t{64} << 20};
};

TEST_F(MapFileTest, WritesRecordsInInputOrder) {
  // The least buffers make blocks of 4096 records.
  for (const std::uint64_t vertices : {1u, 4095u, 4096u, 4097u, 20'000u}) {
    SCOPED_TRACE(vertices);
    MapFileWriter writer(directory(), vertices, 1, budget_);
    std::vector<VertexId> order(vertices);
    std::iota(order.begin(), order.end(), VertexId{0});
    std::shuffle(order.begin(), order.end(), std::mt19937_64(vertices));
    std::uint64_t added = 0;
    for (const VertexId v : order) {
      if (v % 10 == 3) continue;
      writer.add(v, {static_cast<LocalIndex>(v / 2), double(v) / 1e5, 0.25});
      ++added;
    }
    const std::uint64_t checksum = writer.write(path(), added);
    EXPECT_EQ(checksum, checksum_file(path()));
    const std::vector<MapRecord> made = records();
    ASSERT_EQ(made.size(), vertices);
    for (std::uint64_t v = 0; v < vertices; ++v) {
      if (v % 10 == 3) {
        ASSERT_EQ(made[v].face, 0xFFFFFFFFu);
        continue;
      }
      ASSERT_EQ(made[v].face, v / 2);
      ASSERT_EQ(made[v].u, static_cast<float>(double(v) / 1e5));
      ASSERT_EQ(made[v].v, 0.25f);
    }
  }
  EXPECT_EQ(entries_in(directory()), 1u);
}

TEST_F(MapFileTest, RefusesAnotherNumberOfVertices) {
  for (const std::uint64_t expected : {2u, 4u}) {
    MapFileWriter writer(directory(), 10, 1, budget_);
    for (VertexId v = 0; v < 3; ++v) writer.add(v, {0, 0, 0});
    EXPECT_THROW(writer.write(path(), expected), CorruptionError);
    EXPECT_FALSE(std::filesystem::exists(path()));
  }
  EXPECT_EQ(entries_in(directory()), 0u);
}

TEST_F(MapFileTest, CountsAVertexThatCameTwiceOnce) {
  MapFileWriter writer(directory(), 10, 1, budget_);
  writer.add(4, {1, 0, 0});
  writer.add(4, {2, 0, 0});
  EXPECT_NO_THROW(writer.write(path(), 1));
}

}  // namespace
}  // namespace remaps::pipeline
