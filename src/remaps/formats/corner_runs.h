#pragma once

#include <cstdint>

#include "remaps/base/geometry.h"
#include "remaps/formats/chunk_emitter.h"

namespace remaps {

/// Turns the corners of a polygon, given one by one, into a fan from the first corner. A polygon of
/// any length needs no memory. (The shorter diagonal of a quad would need positions, which may be
/// far away.)
class PolygonFan {
 public:
  explicit PolygonFan(ChunkEmitter<Triangle>& triangles) : triangles_(triangles) {}

  void begin() { corners_ = 0; }
  void corner(VertexId v) {
    if (corners_ == 0) {
      first_ = v;
    } else if (corners_ >= 2) {
      triangles_.push({first_, previous_, v});
    }
    previous_ = v;
    ++corners_;
  }
  std::uint64_t corners() const { return corners_; }

 private:
  ChunkEmitter<Triangle>& triangles_;
  VertexId first_ = 0, previous_ = 0;
  std::uint64_t corners_ = 0;
};

/// Turns triangle strips, corner by corner, into triangles of one orientation: every second one is
/// turned round. Strips repeat corners to change direction; the triangles this makes are dropped.
class StripUnroller {
 public:
  explicit StripUnroller(ChunkEmitter<Triangle>& triangles) : triangles_(triangles) {}

  void restart() { corners_ = 0; }
  void corner(VertexId v) {
    if (corners_ >= 2 && before_ != last_ && before_ != v && last_ != v) {
      triangles_.push(corners_ % 2 == 0 ? Triangle{before_, last_, v}
                                        : Triangle{last_, before_, v});
    }
    before_ = last_;
    last_ = v;
    ++corners_;
  }

 private:
  ChunkEmitter<Triangle>& triangles_;
  VertexId before_ = 0, last_ = 0;
  std::uint64_t corners_ = 0;
};

}  // namespace remaps
