#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/formats/byte_sink.h"
#include "remaps/mesh/indexed_stream.h"

namespace remaps {

/// What the writers of all formats share: the sink, and the check that positions, triangles and the
/// rows of their attributes are as many as announced, in order, finite and in range. A format puts
/// chunks that passed the check; one without attributes need not know of them.
class CountedWriter : public IndexedMeshWriter {
 public:
  CountedWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces,
                std::vector<AttributeSpec> attributes = {});

  void write_positions(std::span<const Vec3> positions) final;
  void write_triangles(std::span<const Triangle> triangles) final;
  void write_attributes(AttributePer per, std::span<const std::byte> rows) final;
  void close() final;

 protected:
  /// Every coordinate is finite as a float.
  virtual void put_positions(std::span<const Vec3> positions) = 0;
  /// Every index is below the number of vertices.
  virtual void put_triangles(std::span<const Triangle> triangles) = 0;

  /// With the rows of the vertices' attributes.
  virtual void put_vertices(std::span<const Vec3> positions, std::span<const std::byte>) {
    put_positions(positions);
  }
  /// With the rows of the faces and of their corners, three a face; empty where there are none.
  virtual void put_faces(std::span<const Triangle> triangles, std::span<const std::byte>,
                         std::span<const std::byte>) {
    put_triangles(triangles);
  }

  const std::vector<AttributeSpec>& attributes() const { return attributes_; }
  /// All positions and triangles were put: what a format has at its end, or knows only now.
  virtual void finish() {}

  ByteSink& sink() { return sink_; }
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t faces() const { return faces_; }

 private:
  [[noreturn]] void fail(std::string_view what) const;
  void expect_rows(AttributePer per, std::size_t elements, std::size_t bytes) const;

  ByteSink sink_;
  std::uint64_t vertices_, faces_;
  std::uint64_t vertices_done_ = 0, faces_done_ = 0;
  std::vector<AttributeSpec> attributes_;
  std::size_t row_bytes_[3];                        // by AttributePer
  std::vector<Vec3> waiting_;                       // for their attributes
  std::vector<std::byte> face_rows_, corner_rows_;  // waiting for their triangles
};

}  // namespace remaps
