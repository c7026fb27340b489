#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/formats/chunk_emitter.h"
#include "remaps/mesh/polygon_cutter.h"

namespace remaps {

/// Turns the corners of a polygon, given one by one, into triangles: by a cutter, which knows where
/// they are, else as a fan from the first corner. Of a fan the polygon may have any length and
/// needs no memory.
class PolygonRun {
 public:
  /// @param cutter  may be null
  PolygonRun(ChunkEmitter<Triangle>& triangles, PolygonCutter* cutter)
      : triangles_(triangles),
        cutter_(cutter),
        kept_(cutter == nullptr ? 0 : PolygonCutter::kMostCorners) {}

  void begin() { corners_ = 0; }
  void corner(VertexId v) {
    if (corners_ < kept_.size()) {
      kept_[static_cast<std::size_t>(corners_++)] = v;
    } else {
      if (corners_ == kept_.size()) fan_kept();
      fan(v);
    }
  }
  void end() {
    if (kept_.empty() || corners_ > kept_.size()) return;
    if (corners_ == 3) {
      triangles_.push({kept_[0], kept_[1], kept_[2]});
    } else {
      const auto corners = std::span(kept_).first(static_cast<std::size_t>(corners_));
      for (const PolygonCorners& t : cutter_->cut(corners))
        triangles_.push({kept_[t[0]], kept_[t[1]], kept_[t[2]]});
    }
  }
  std::uint64_t corners() const { return corners_; }

 private:
  void fan_kept() {
    corners_ = 0;
    for (const VertexId v : kept_) fan(v);
  }
  void fan(VertexId v) {
    if (corners_ == 0) {
      first_ = v;
    } else if (corners_ >= 2) {
      triangles_.push({first_, previous_, v});
    }
    previous_ = v;
    ++corners_;
  }

  ChunkEmitter<Triangle>& triangles_;
  PolygonCutter* cutter_;
  std::vector<VertexId> kept_;  // corners, while they may be for the cutter
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
