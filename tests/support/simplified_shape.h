#pragma once

#include <cstdint>
#include <vector>

#include "remaps/mesh/segment_log.h"
#include "remaps/simplify/simplifier.h"
#include "support/shapes.h"

namespace remaps::test {

/// A shape simplified in one segment.
struct SimplifiedShape {
  Segment segment;  ///< triangle: those of the input
  Patch patch;      ///< what is left
  RetriangulationLog log;
  std::vector<LocalIndex> removed;
  std::size_t left = 0;
};

simplify::SimplifyOptions simplify_options(std::size_t target);
/// @param locked  empty: none
/// @param feature_angle_rad  0: no features
SimplifiedShape simplify_shape(const Shape& shape, const simplify::SimplifyOptions& options,
                               const std::vector<std::uint8_t>& locked = {}, bool draft = false,
                               double feature_angle_rad = 0);

/// What a sweep would write of it: level 0, the survivors handed to `next` segments of a next level
/// in turn (0: this is the last level).
SegmentLog segment_log_of(const SimplifiedShape& simplified, std::uint32_t next);

/// Scan-like shapes of some thousand vertices, with and without boundary, in one piece and two.
std::vector<Shape> scan_shapes();

}  // namespace remaps::test
