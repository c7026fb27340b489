#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/formats/record_spool.h"

namespace remaps {

/// Gives vertices whose corners have different values a copy for each value, for formats that have
/// values of vertices alone. A vertex itself has the value that comes first; copies are numbered
/// behind all vertices, as they come. Values are floats; where all differ by no more than
/// `kSame` they count as one, which is the first.
///
/// Memory: a cache of 512 KiB; the values wait on disk.
class CornerSplitter {
 public:
  /// Far more than rounding makes of corners in one chart, far less than a texel.
  static constexpr float kSame = 0x1p-16F;

  /// @param numbers  of a value, at least 1
  CornerSplitter(const std::filesystem::path& target, std::uint64_t vertices, std::size_t numbers);

  /// The vertex or copy for a corner at vertex v.
  std::uint64_t split(std::uint64_t v, std::span<const float> value);

  std::uint64_t copies() const { return copies_; }
  /// Reads a vertex's or a copy's value, zeros if it has no corner; returns the vertex that it is,
  /// or is a copy of.
  std::uint64_t read(std::uint64_t number, std::span<float> value);

 private:
  struct Link {
    std::uint64_t original = 0;
    std::uint64_t next = 0;  ///< the copy after it, counted from 1
    std::uint64_t taken = 0;
  };

  std::uint64_t vertices_;
  std::uint64_t copies_ = 0;
  RecordSpool records_;  // link and value
};

}  // namespace remaps
