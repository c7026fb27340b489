#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "remaps/base/geometry.h"
#include "remaps/formats/ply_header.h"

/// Runs of binary records of the usual shapes, decoded straight from the bytes of a buffer. A run
/// ends before the first record that is cut off, of another shape, not finite, or would be refused:
/// the general walk through the records takes that one, and words the error.
namespace remaps {

/// Records of a fixed size in which x, y and z follow each other, all floats or all doubles.
class PlyPointRuns {
 public:
  /// Nothing if the records are of another shape.
  static std::optional<PlyPointRuns> of(const PlyElement& element, bool big_endian);

  struct Decoded {
    std::size_t records;
    bool all_float;  // of these records
  };
  /// Decodes as many records as `bytes` has, at most as many as `out` takes.
  Decoded decode(std::string_view bytes, std::span<Vec3> out) const;

  std::size_t record_bytes() const { return stride_; }

 private:
  using Decode = Decoded (*)(const char* first, std::size_t stride, std::span<Vec3> out);

  PlyPointRuns(std::size_t stride, std::size_t offset, Decode how)
      : stride_(stride), offset_(offset), decode_(how) {}

  std::size_t stride_, offset_;
  Decode decode_;
};

/// Records that are one list of corners with a count of one byte, perhaps among values of fixed
/// size. Only triangles of valid vertices are decoded.
class PlyTriangleRuns {
 public:
  /// Nothing if the records are of another shape.
  static std::optional<PlyTriangleRuns> of(const PlyElement& element, const PlyProperty& corners,
                                           bool big_endian);

  /// Decodes as many records as `bytes` has, at most as many as `out` takes.
  /// @param vertices  what every index must be below
  std::size_t decode(std::string_view bytes, std::uint64_t vertices, std::span<Triangle> out) const;

  std::size_t record_bytes() const { return stride_; }

 private:
  using Decode = std::size_t (*)(const char* first, std::size_t stride, std::uint64_t vertices,
                                 std::span<Triangle> out);

  PlyTriangleRuns(std::size_t stride, std::size_t offset, Decode how)
      : stride_(stride), offset_(offset), decode_(how) {}

  std::size_t stride_, offset_;
  Decode decode_;
};

}  // namespace remaps
