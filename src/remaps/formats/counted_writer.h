#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "remaps/formats/byte_sink.h"
#include "remaps/mesh/indexed_stream.h"

namespace remaps {

/// What the writers of all formats share: the sink, and the check that positions and triangles are
/// as many as announced, in order, finite and in range. A format puts chunks that passed the check.
class CountedWriter : public IndexedMeshWriter {
 public:
  CountedWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces)
      : sink_(path), vertices_(vertices), faces_(faces) {}

  void write_positions(std::span<const Vec3> positions) final;
  void write_triangles(std::span<const Triangle> triangles) final;
  void close() final;

 protected:
  /// Every coordinate is finite as a float.
  virtual void put_positions(std::span<const Vec3> positions) = 0;
  /// Every index is below the number of vertices.
  virtual void put_triangles(std::span<const Triangle> triangles) = 0;

  /// All positions and triangles were put: what a format has at its end, or knows only now.
  virtual void finish() {}

  ByteSink& sink() { return sink_; }
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t faces() const { return faces_; }

 private:
  [[noreturn]] void fail(std::string_view what) const;

  ByteSink sink_;
  std::uint64_t vertices_, faces_;
  std::uint64_t vertices_done_ = 0, faces_done_ = 0;
};

}  // namespace remaps
