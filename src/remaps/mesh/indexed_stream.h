#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "remaps/base/function_ref.h"
#include "remaps/base/geometry.h"

namespace remaps {

/// Receives a chunk of vertex positions, in file order.
using PositionSink = FunctionRef<void(std::span<const Vec3>)>;
/// Receives a chunk of triangles, in file order. Indices count from 0 and are valid.
using IndexSink = FunctionRef<void(std::span<const Triangle>)>;

/// Where a file has its positions one after the other as they are in memory: an array of Vec3f.
struct PositionArray {
  std::filesystem::path path;
  std::uint64_t offset = 0;
};

/// A triangle mesh in a file, read as two streams. Memory stays bounded whatever the file's size.
/// Each read_* is one pass over the file and may be called again.
class IndexedMeshReader {
 public:
  virtual ~IndexedMeshReader() = default;

  /// Sends all positions in file order, chunk by chunk.
  /// @throws InputError  malformed or truncated data, naming file and offset or line
  virtual void read_positions(PositionSink sink) = 0;

  /// Sends all faces in file order; a polygon arrives as its triangles, one after the other. Every
  /// index is checked against the vertex count before it is sent.
  /// @throws InputError  malformed or truncated data, naming file and offset or line
  virtual void read_triangles(IndexSink sink) = 0;

  /// True when every coordinate in the file is a float (so that storing floats loses nothing).
  virtual bool positions_are_float() const = 0;

  /// True when faces do not share vertices, or not all that they should, so that vertices of equal
  /// position are to be taken for one: STL repeats them for each face, glTF at seams of textures.
  virtual bool is_soup() const { return false; }

  /// The positions as an array in the file, where they are one, so that nobody need copy them to
  /// have them at hand. What read_positions refuses may be among them.
  virtual std::optional<PositionArray> position_array() const { return std::nullopt; }

  /// The fraction of the present pass that is over, 0 to 1: for progress bars. An estimate where
  /// the file does not tell how long its parts are.
  virtual double pass_fraction() const = 0;

  /// Size in bytes of the file, and the offset in it that the present pass has come to.
  virtual std::uint64_t bytes_total() const = 0;
  virtual std::uint64_t bytes_read() const = 0;
  /// Bytes that came from the file since it was opened, in all passes: for reports.
  virtual std::uint64_t bytes_read_total() const = 0;
};

/// A triangle mesh being written as two streams: all positions, then all triangles. The file
/// appears under its final name only when `close` succeeds; destroyed before that, it leaves
/// nothing.
class IndexedMeshWriter {
 public:
  virtual ~IndexedMeshWriter() = default;
  virtual void write_positions(std::span<const Vec3> positions) = 0;
  virtual void write_triangles(std::span<const Triangle> triangles) = 0;
  /// Flushes, checks the counts announced at opening, and renames to the final name.
  /// @throws IoError  a write or the rename failed
  virtual void close() = 0;
};

}  // namespace remaps
