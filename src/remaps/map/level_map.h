#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "remaps/base/progress.h"
#include "remaps/map/point_buckets.h"
#include "remaps/map/segment_map.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/store/section_file.h"

namespace remaps::map {

/// One segment of a level's log, linked for one direction.
struct LoadedSegment {
  SegmentLog log;
  SegmentMap map;
  /// (faces) where each face is on the far side: at the next level (forward; meaningless for
  /// dropped faces), or at the level before (inverse; itself at level 0).
  std::vector<FaceLink> link;

  /// Carries points through the segment; their faces stay local. link says where they lead.
  /// @throws CorruptionError  a point starts on no face, or ends on one that was dropped
  void carry(std::span<FacePoint> points) const;
  std::uint64_t bytes() const;
};

/// The map of one level, from its sealed log file.
class LevelMap {
 public:
  explicit LevelMap(const store::SectionFile& log) : log_(&log) {}

  std::size_t segments() const { return log_->sections() / 2; }
  /// @throws CorruptionError  the sections are damaged, or a link leads to a face that does not
  /// exist
  std::shared_ptr<const LoadedSegment> load(std::size_t segment,
                                            SegmentMap::Direction direction) const;
  /// About the memory that the loaded segment will take.
  std::uint64_t expected_bytes(std::size_t segment) const;

 private:
  const store::SectionFile* log_;
};

struct CarryOptions {
  unsigned threads = 1;
  std::size_t map_buffer = 100'000;  ///< points in memory a worker thread
  Progress* progress = nullptr;      ///< optional; checked for cancellation
};

/// Receives points at the far side of a level, with the segment of each; called on one thread at a
/// time, in an order that does not depend on the number of threads.
using PointSink = std::function<void(const FaceLink& link, const TaggedPoint& point)>;

/// Carries all points of `in` through a level and sends them to `sink`. The points are by
/// segment of the level on the near side; each segment is released when done.
void carry_points(const LevelMap& level, SegmentMap::Direction direction, PointSupply& in,
                  const CarryOptions& options, const PointSink& sink);

}  // namespace remaps::map
