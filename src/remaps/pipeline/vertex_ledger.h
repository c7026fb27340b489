#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/map/segment_map.h"
#include "remaps/mesh/base_mesh.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/store/bucket_file.h"

namespace remaps::pipeline {

/// A point on the flat triangle of a base face.
Vec3 position_on_base(const BaseMesh& base, const map::FacePoint& at);

/// Checks that numbers 0 ... count - 1 come once each, in any order: through a file, by blocks.
class NumberCensus {
 public:
  NumberCensus(const std::filesystem::path& path, std::uint64_t count, std::uint64_t buffer_bytes,
               MemoryBudget& budget);
  /// @throws CorruptionError  not below count; names `what`
  void add(std::uint64_t number, const char* what);
  /// @param absent  so many do not come
  /// @throws CorruptionError  names the first number that is missing or came twice
  void finish(const char* what, std::uint64_t absent = 0);

 private:
  std::uint64_t count_;
  store::BucketFile file_;
};

/// What the comparison of all entries found, as fractions of the diagonal.
struct LedgerResult {
  std::uint64_t vertices = 0;  ///< with a face
  std::uint64_t absent = 0;    ///< in no tile, and without a place in map.bin
  double round_trip_max = 0, round_trip_sum = 0;
  double map_file_max = 0;
  Box3 box;
};

/// Collects, in any order, everything that is said of each input vertex in different places of a
/// bundle, and compares it vertex by vertex: through a file, by blocks of ids.
class VertexLedger {
 public:
  VertexLedger(const std::filesystem::path& temp_dir, const Bundle& bundle,
               std::uint64_t buffer_bytes, MemoryBudget& budget);

  /// Every vertex of a tile: its position, whether it is the tile's own, whether a face of the tile
  /// uses it.
  void add_tile(const Tile& tile);
  void add_removed(VertexId vertex);
  void add_base(VertexId vertex, std::uint32_t base_vertex);
  /// Where following the log took the vertex.
  void add_on_base(VertexId vertex, const map::FacePoint& at);
  /// Where it came back to, in the coordinates of the tiles.
  void add_returned(VertexId vertex, const Vec3& position);

  /// Compares all entries with each other and with map.bin.
  ///
  /// Each vertex is some tile's own, once, and has one position everywhere; it is removed once, or
  /// once a base vertex and then at that position in base.ply, or has no face anywhere and none in
  /// map.bin; each vertex with a face was carried to where map.bin says, and returned.
  /// @throws CorruptionError  names the vertex and what is wrong
  LedgerResult compare(unsigned threads, Progress& progress);

 private:
  struct Block;

  Block take_block(std::size_t number);
  void append(VertexId vertex, std::uint8_t kind, store::ByteSpan rest);

  const Bundle& bundle_;
  MemoryBudget& budget_;
  std::uint64_t vertices_;
  std::uint64_t block_;
  store::File map_file_;
  store::BucketFile file_;
};

}  // namespace remaps::pipeline
