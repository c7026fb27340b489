#pragma once

#include <cstdint>
#include <filesystem>

#include "remaps/base/memory_budget.h"
#include "remaps/map/segment_map.h"
#include "remaps/store/bucket_file.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {

/// One record of map.bin.
struct MapRecord {
  std::uint32_t face = 0xFFFFFFFFu;  ///< base face; 0xFFFFFFFF for a vertex that has none
  float u = 0, v = 0;
};
static_assert(sizeof(MapRecord) == 12);

/// Collects where each input vertex lies on the base, in any order, and writes map.bin in input
/// order.
class MapFileWriter {
 public:
  MapFileWriter(const std::filesystem::path& temp_dir, std::uint64_t vertices,
                std::uint64_t buffer_bytes, MemoryBudget& budget);
  /// Vertices beyond the input's, which are copies that repair made, are only counted.
  void add(VertexId vertex, const map::FacePoint& on_base);
  /// Writes the file; vertices that were never added get no face.
  /// @param expected  number of vertices that must have been added
  /// @return  XXH3-64 of the file
  /// @throws CorruptionError  another number was
  std::uint64_t write(const std::filesystem::path& path, std::uint64_t expected);

 private:
  std::uint64_t vertices_;
  std::uint64_t block_;
  std::uint64_t copies_ = 0;
  store::BucketFile file_;
  Reservation reservation_;
};

}  // namespace remaps::pipeline
