#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/mesh/domain_level.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/vertex_spool.h"
#include "remaps/store/bucket_file.h"

namespace remaps::pipeline {

/// Segments of a range of vertices: 2 bytes each, 4 where there are too many segments.
class SegmentTable {
 public:
  static std::uint64_t bytes_per_vertex(std::size_t segments) {
    return segments <= (std::size_t{1} << 16) ? 2 : 4;
  }

  void reset(std::size_t segments, std::size_t vertices);
  void set(std::size_t i, std::uint32_t segment) {
    narrow_ ? void(two_[i] = static_cast<std::uint16_t>(segment)) : void(four_[i] = segment);
  }
  std::uint32_t operator[](std::size_t i) const { return narrow_ ? two_[i] : four_[i]; }

 private:
  bool narrow_ = true;
  std::vector<std::uint16_t> two_;
  std::vector<std::uint32_t> four_;
};

/// Brings faces in any order to the segments of their corners, with memory for the segments of one
/// range of vertices at a time: docs/design/ingest.md.
///
/// Ranges are worked through in order. A face waits in the bucket of the lowest range that has a
/// corner of unknown segment, so that it is written once for each range it needs but the first. The
/// positions that faces need in segments foreign to them are fetched afterwards, range by range.
class FaceJoin {
 public:
  /// Loads the first range.
  /// @param add_vertices  adds the vertices of each range to their segments when it is loaded
  FaceJoin(const VertexSpool& spool, DomainLevel& level, bool add_vertices, const MemoryPlan& plan,
           const std::filesystem::path& directory, MemoryBudget& budget);

  /// Ranges that a join needs: with one, no face waits.
  static std::uint64_t ranges(std::uint64_t vertices, std::size_t segments, const MemoryPlan& plan);

  void add(const Triangle& t, FaceId face, FaceLabel label = kNoLabel);
  /// Works through what waits. `progress` gets fractions and may throw.
  void finish(const std::function<void(double)>& progress);

 private:
  struct Waiting {
    Triangle corner;
    FaceId face = 0;
    FaceLabel label = kNoLabel;
    std::array<std::uint32_t, 3> segment_code{};  // 0: unknown, else the segment + 1
  };

  void load_range(std::uint64_t range);
  void advance(Waiting& waiting);
  void route(const std::array<RoutedVertex, 3>& corner, FaceId face, FaceLabel label);
  void put(std::uint64_t range, const Waiting& waiting);
  void work_through(std::uint64_t range);
  void add_foreign(std::uint64_t range);

  const VertexSpool& spool_;
  DomainLevel& level_;
  bool add_vertices_;
  std::uint64_t ranges_;
  std::uint64_t range_size_;
  std::uint64_t fetch_size_;  // vertices whose positions are in memory together
  Reservation reservation_;
  SegmentTable table_;
  std::uint64_t present_ = 0;  // range in the table
  std::unique_ptr<store::BucketFile> waiting_;
  store::BucketFile foreign_;
};

}  // namespace remaps::pipeline
