#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/base/geometry.h"
#include "remaps/mesh/attributes.h"
#include "remaps/mesh/polygon_cutter.h"

namespace remaps {

/// Receives a chunk of vertex positions, in file order.
using PositionSink = FunctionRef<void(std::span<const Vec3>)>;
/// Receives a chunk of triangles, in file order. Indices count from 0 and are valid.
using IndexSink = FunctionRef<void(std::span<const Triangle>)>;

/// A corner of a face, and the number of its value in a pool.
struct PoolUse {
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  VertexId vertex = 0;
  std::uint64_t value = kNone;
};
/// Receives a chunk of the corners of triangles, three each.
using PoolUseSink = FunctionRef<void(std::span<const PoolUse>)>;

/// Where a file has its positions one after the other as they are in memory: an array of Vec3f.
struct PositionArray {
  std::filesystem::path path;
  std::uint64_t offset = 0;
};

/// How faces that touch share their vertices in a mesh: what welding has to do.
enum class VertexSharing {
  shared,  ///< by index
  split,   ///< a place may have several vertices
  none     ///< not at all: face f has the vertices 3f, 3f + 1, 3f + 2
};

/// A triangle mesh in a file, read as two streams. Memory stays bounded whatever the file's size.
/// Each read_* is one pass over the file and may be called again.
class IndexedMeshReader {
 public:
  virtual ~IndexedMeshReader() = default;

  /// Sends all positions in file order, chunk by chunk. Of a vertex with a coordinate that is not
  /// finite, or beyond the range of floats, all three are NaN.
  /// @throws InputError  malformed or truncated data, naming file and offset or line
  virtual void read_positions(PositionSink sink) = 0;

  /// Sends all faces in file order; a polygon arrives as its triangles, one after the other. Every
  /// index is checked against the vertex count before it is sent.
  /// @throws InputError  malformed or truncated data, naming file and offset or line
  virtual void read_triangles(IndexSink sink) = 0;

  /// Lets read_triangles hand over polygons of more than three corners to be cut; without, or with
  /// nullptr, or with more than 1024 corners, they become fans. Called on the thread that reads.
  virtual void set_polygon_cutter(PolygonCutter* /*cutter*/) {}

  /// True when every coordinate of the finite vertices is a float (so that storing floats loses
  /// nothing).
  virtual bool positions_are_float() const = 0;

  /// Anything but `shared` calls for welding.
  virtual VertexSharing vertex_sharing() const { return VertexSharing::shared; }

  /// The positions as an array in the file, where they are one, so that nobody need copy them to
  /// have them at hand. Of a vertex that read_positions sends as NaN, one is NaN or infinite there.
  virtual std::optional<PositionArray> position_array() const { return std::nullopt; }

  /// What vertices, faces and corners have beside positions. To be called after read_positions and
  /// read_triangles; may take a further pass where a format does not announce its attributes.
  /// @throws InputError  as the passes do
  virtual std::vector<AttributeSpec> attributes() { return {}; }

  /// Sends the attributes of all vertices, all faces (the triangles of read_triangles, in order) or
  /// all corners (three rows a triangle), chunk by chunk. A row has the components of all
  /// attributes of that element in the order of attributes(), except pooled ones.
  virtual void read_attributes(AttributePer, AttributeSink) {}

  /// Sends the values of a pooled attribute, numbered from 0.
  /// @param number  of the attribute in attributes()
  virtual void read_pool(std::size_t /*number*/, AttributeSink) {}
  /// Sends which value of the pool each corner has, three a triangle, in order.
  virtual void read_pool_uses(std::size_t /*number*/, PoolUseSink) {}

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
///
/// A writer opened with attributes gets their rows beside: each write_positions is followed by
/// write_attributes with the rows of these vertices, and before each write_triangles come those of
/// the faces, then those of the corners, of these triangles, as far as there are such attributes.
class IndexedMeshWriter {
 public:
  virtual ~IndexedMeshWriter() = default;
  virtual void write_positions(std::span<const Vec3> positions) = 0;
  virtual void write_triangles(std::span<const Triangle> triangles) = 0;
  /// Rows as pack_row makes them of the attributes of that element that the writer was opened with.
  virtual void write_attributes(AttributePer per, std::span<const std::byte> rows) = 0;
  /// Flushes, checks the counts announced at opening, and renames to the final name.
  /// @throws IoError  a write or the rename failed
  virtual void close() = 0;
};

}  // namespace remaps
