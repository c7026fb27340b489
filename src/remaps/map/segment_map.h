#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/retriangulation.h"

namespace remaps::map {

/// A point on a face: barycentric weights (1 - u - v, u, v) of the face's corners in their order.
struct FacePoint {
  LocalIndex face = 0;
  double u = 0, v = 0;

  friend bool operator==(const FacePoint&, const FacePoint&) = default;
};

/// The piecewise-linear bijection of one segment's log, from the faces before its first record to
/// those after its last.
///
/// Each record tells, for each face that it touches, which record touches that face next
/// (previously), so a point steps from record to record in constant time. A step computes the point
/// in the plane of the star and chooses the target triangle by exact
/// signs (tie: lowest slot); should rounding have put the point outside the ring, the triangle with
/// the largest least sign takes it and its weights are clamped. A corner stays a corner exactly.
/// Source: [MAPS98] section 3.2; differs: records are kept instead of vertex images, which makes
/// the map exact.
class SegmentMap {
 public:
  enum class Direction { kForward, kInverse };

  /// Copies the records of `log` in a form to walk through, and links them for one direction.
  /// `faces` is the number of face ids in the segment; every id in the log must be below it.
  /// Memory: 4 B a face, some 14 words of 4 B a record. Cost: one pass over the log.
  /// @throws CorruptionError  a record has a face in its star twice
  /// @throws BudgetError      the log is longer than links can name (some 2^25 records)
  void build(const RetriangulationLog& log, std::size_t faces, Direction direction);

  /// Carries points through all records in the direction given to build, in place.
  /// Cost: some 5 to 20 steps a point, more where more was removed; a step takes 10 to 20 ns, since
  /// many points walk at a time.
  void carry(std::span<FacePoint> points) const;

  /// Forward only: where each removed vertex ends, from the origin of its own record.
  /// @param out  (records)
  void carry_removed(std::span<FacePoint> out) const;

  std::size_t records() const { return place_.size(); }
  std::uint64_t bytes() const { return 4 * (path_.size() + first_.size() + place_.size()); }

 private:
  template <Direction direction>
  void link(const RetriangulationLog& log, std::size_t faces);
  template <Direction direction, class Source, class Sink>
  void walk(Source&& source, Sink&& sink) const;

  // A record in path_ takes a multiple of 4 words: k (bits 0-3), boundary (bit 4), apex (8-11),
  // n (16-19) | turns | n ring points | a link for each face that it leaves. A link is 16 * place +
  // slot with place in units of 4 words, or kEnd | face when no record is left.
  std::vector<std::uint32_t> path_;
  std::vector<std::uint32_t> first_;  // (faces) links
  std::vector<std::uint32_t> place_;  // (records)
  Direction direction_ = Direction::kForward;
};

/// Carries a point through one record (a Retriangulation or a RecordView). Requires point.face ==
/// record.face[slot] before (forward), or after (inverse).
/// @return  the slot of the new triangle (forward) or of the wedge (inverse) it falls on
template <class Record>
unsigned apply_forward(const Record& record, unsigned slot, FacePoint& point);
template <class Record>
unsigned apply_inverse(const Record& record, unsigned slot, FacePoint& point);

}  // namespace remaps::map
