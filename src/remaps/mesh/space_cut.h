#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps {

/// Cuts space into segments: a k-d tree over a sample of positions, in axes turned differently for
/// every level, so that the borders of one level lie inside the segments of the next. The segment
/// of a vertex is a pure function of its position. Why not ranges of a space-filling curve:
/// docs/design/cuts.md.
class SpaceCut {
 public:
  /// One segment: all of space.
  SpaceCut() = default;

  /// @param sample    (m) positions spread like the vertices; reordered
  /// @param segments  at least 1; each gets about the same share of the sample
  /// @param level     chooses the axes
  /// Cost: m log segments.
  SpaceCut(std::span<Vec3f> sample, std::size_t segments, unsigned level);

  std::size_t segments() const { return segments_; }
  /// Cost: log2(segments) comparisons.
  std::uint32_t segment_of(const Vec3f& p) const;

 private:
  struct Node {
    std::uint32_t axis = 0;  // 3: leaf
    float threshold = 0;     // left of it: below
    std::uint32_t right =
        0;  // index of the right child, the left one follows its parent; at a leaf the segment
  };

  void split(std::span<Vec3f> turned, std::size_t first_segment, std::size_t count);
  Vec3f turn(const Vec3f& p) const;

  std::array<Vec3f, 3> axes_{Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}};
  std::vector<Node> nodes_{{3, 0, 0}};
  std::size_t segments_ = 1;
};

/// Every k-th of a stream of positions, k doubling whenever `capacity` is reached: a sample of a
/// stream of unknown length that depends on nothing but the stream.
class PositionSample {
 public:
  explicit PositionSample(std::size_t capacity) : capacity_(capacity) {}
  void add(const Vec3f& p) {
    if (seen_++ % stride_ != 0) return;
    kept_.push_back(p);
    if (kept_.size() >= capacity_) thin();
  }
  std::uint64_t seen() const { return seen_; }
  std::span<Vec3f> kept() { return kept_; }

 private:
  void thin();

  std::size_t capacity_;
  std::uint64_t seen_ = 0;
  std::uint64_t stride_ = 1;
  std::vector<Vec3f> kept_;
};

}  // namespace remaps
