#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/repair/parity_forest.h"
#include "remaps/store/bucket_file.h"

namespace remaps::repair {

/// A part of a segment's faces that edges join, with how many of its home faces run like its first
/// one and how many are turned against it.
struct OrientedPart {
  std::uint64_t straight = 0, turned = 0;
};

/// A face that several segments see, as one of them does.
struct SharedFace {
  FaceId face = 0;
  std::uint32_t part = 0;  ///< of the segment, from 0
  bool turned = false;     ///< against the first of its part
};

/// Joins the parts of all segments where they have faces in common, and finds which of them to
/// turn so that all faces of a component agree: as few faces as can be, of equal numbers those that
/// run like the first part stay.
/// Memory: 20 B a part; what the segments share goes through a bucket file.
class OrientationJoin {
 public:
  OrientationJoin(const std::filesystem::path& path, std::uint64_t faces,
                  std::uint64_t buffer_bytes, MemoryBudget& budget);

  /// Adds a segment's parts.
  /// @return  number of the first of them
  std::uint32_t add(std::span<const OrientedPart> parts, std::span<const SharedFace> shared);

  /// Joins what was added. To be called once.
  /// @return  a face at which the orientations do not agree, whatever is turned
  std::optional<FaceId> finish();

  // After finish:
  /// Whether the faces of a part that run like its first one are to be turned (and not the others).
  bool turns(std::uint32_t part) const { return turn_[part]; }
  /// Home faces of the whole component that a part belongs to.
  std::uint64_t component_faces(std::uint32_t part) const {
    return parts_[part].straight + parts_[part].turned;
  }
  /// Components of fewer faces.
  std::uint64_t components_below(std::uint64_t faces);

 private:
  MemoryBudget& budget_;
  std::vector<Reservation> reservations_;
  std::uint64_t reserved_parts_ = 0;
  store::BucketFile file_;
  ParityForest forest_;
  std::vector<OrientedPart> parts_;  // after finish: of the whole component
  std::vector<bool> turn_;
};

}  // namespace remaps::repair
