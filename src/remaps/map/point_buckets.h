#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/map/segment_map.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/store/bucket_file.h"

namespace remaps::map {

/// A surface point that knows who asked: the tag is a vertex id, a sample number, a line of a
/// query.
struct TaggedPoint {
  std::uint64_t tag = 0;
  FacePoint at;
};

/// Where the points that a level carries come from: some for each of its segments.
class PointSupply {
 public:
  virtual ~PointSupply() = default;
  virtual std::size_t segments() const = 0;
  virtual std::uint64_t count(std::size_t segment) const = 0;
  /// Points first ... first + n - 1 of a segment. Safe on several threads.
  virtual void read(std::size_t segment, std::uint64_t first, std::uint64_t n,
                    std::vector<TaggedPoint>& out) const = 0;
  /// Called when the segment's points are not needed any more.
  virtual void release(std::size_t segment) = 0;
};

/// Points on disk, sorted by the segment of the face that they lie on. Records of 25 bytes: tag
/// (5), face (4), u, v (8).
class PointBuckets final : public PointSupply {
 public:
  PointBuckets(const std::filesystem::path& path, std::size_t segments, std::uint64_t buffer_bytes,
               MemoryBudget& budget)
      : file_(path, segments, buffer_bytes, budget) {}

  std::size_t segments() const override { return file_.buckets(); }
  std::uint64_t count(std::size_t segment) const override {
    return file_.bytes(segment) / kRecordBytes;
  }
  void add(std::size_t segment, const TaggedPoint& point);
  /// Reads points first ... first + n - 1 of a segment. Safe on several threads once nothing more
  /// is added.
  void read(std::size_t segment, std::uint64_t first, std::uint64_t n,
            std::vector<TaggedPoint>& out) const override;
  /// Frees the segment's disk space.
  void release(std::size_t segment) override { file_.release(segment); }

 private:
  static constexpr std::size_t kRecordBytes = 25;

  store::BucketFile file_;
};

}  // namespace remaps::map
