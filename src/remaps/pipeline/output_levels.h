#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "remaps/mesh/indexed_stream.h"
#include "remaps/resample/dyadic_grid.h"
#include "remaps/store/disk_usage.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {

/// Where the mesh of a level goes when there is one for each: "out.ply" and 3 give "out-l3.ply".
std::filesystem::path level_path(const std::filesystem::path& output, unsigned level);

/// The positions of an output on disk, as floats in the order of their numbers, for what comes
/// after the file is written: coarser levels, and the measurement where the file's format is not
/// one that is read.
class OutputPositions {
 public:
  /// @param path  of the temporary file
  explicit OutputPositions(std::filesystem::path path);
  ~OutputPositions();
  OutputPositions(const OutputPositions&) = delete;
  OutputPositions& operator=(const OutputPositions&) = delete;

  void append(std::span<const Vec3> positions);
  PositionArray array() const { return {path_, 0}; }

 private:
  std::filesystem::path path_;
  store::File file_;
  store::DiskShare disk_;
  std::uint64_t count_ = 0;
  std::vector<Vec3f> chunk_;
};

/// Sends the positions of a coarser level from those of the finest: a pass over these.
void send_coarse_positions(const resample::DyadicGrid& finest, unsigned level,
                           const PositionArray& positions, PositionSink sink);

/// A semi-regular mesh whose positions lie on disk; its faces are arithmetic.
std::unique_ptr<IndexedMeshReader> make_grid_reader(const resample::DyadicGrid& grid,
                                                    PositionArray positions);

}  // namespace remaps::pipeline
