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

  /// Links the records of `log` for one direction. `faces` is the number of face ids in the
  /// segment. The log must outlive the map and every id in it must be below `faces`. Cost: one pass
  /// over the log, 4 B a wedge and a face.
  void build(const RetriangulationLog& log, std::size_t faces, Direction direction);

  /// Carries points through all records in the direction given to build, in place.
  /// Cost: some 5 to 20 steps a point, more where more was removed.
  void carry(std::span<FacePoint> points) const;

  /// Carries one point on from a link: record * 16 + slot, or kNoIndex when no record is left.
  FacePoint carry_from(FacePoint point, std::uint32_t link) const;

 private:
  // A link is record * 16 + slot. next_ has one for each wedge of each record, at the offset of its
  // face id.
  const RetriangulationLog* log_ = nullptr;
  Direction direction_ = Direction::kForward;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> next_;
};

/// Carries a point through one record (a Retriangulation or a RecordView). Requires point.face ==
/// record.face[slot] before (forward), or after (inverse).
/// @return  the slot of the new triangle (forward) or of the wedge (inverse) it falls on
template <class Record>
unsigned apply_forward(const Record& record, unsigned slot, FacePoint& point);
template <class Record>
unsigned apply_inverse(const Record& record, unsigned slot, FacePoint& point);

}  // namespace remaps::map
