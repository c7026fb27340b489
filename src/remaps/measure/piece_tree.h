#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/measure/box_tree.h"
#include "remaps/measure/surface_pieces.h"

namespace remaps {

/// Float coordinates about a centre, for boxes that only prune.
///
/// Rounding a coordinate moves it by up to 2^-24 of itself, and each operation on floats errs by as
/// much again. `reach2` makes a distance so much longer that what is within it is never taken for
/// something further away.
class FloatFrame {
 public:
  FloatFrame() = default;
  /// @param scale  a power of two that brings all coordinates of a job, less the centre, to about 1
  FloatFrame(const Vec3& centre, double scale) : centre_(centre), scale_(scale) {}

  Float3 to_local(const Vec3& p) const {
    return {static_cast<float>(scale_ * (p.x - centre_.x)),
            static_cast<float>(scale_ * (p.y - centre_.y)),
            static_cast<float>(scale_ * (p.z - centre_.z))};
  }

  /// The square of a distance in the units of the job, for comparison with those of boxes.
  ///
  /// @param spread  the largest absolute value of any local coordinate that is compared
  float reach2(double distance2, float spread) const {
    const float reach =
        static_cast<float>(scale_ * std::sqrt(distance2)) * (1 + 0x1p-20f) + spread * 0x1p-21f;
    return std::min(reach * reach + kAboveZero, std::numeric_limits<float>::max());
  }

 private:
  static constexpr float kAboveZero = 1e-36f;  // more than what squares lose near zero

  Vec3 centre_;
  double scale_ = 1;
};

/// The largest absolute coordinate.
inline float spread_of(const Float3& p) {
  return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}
inline float spread_of(const FloatBox& box) {
  return std::max(spread_of(box.low), spread_of(box.high));
}

/// The triangles of a piece, for searching.
class PieceTree {
 public:
  /// @param piece  has a triangle; must outlive this
  void build(const SurfacePiece& piece, double scale);

  const FloatFrame& frame() const { return frame_; }
  const BoxTree& boxes() const { return boxes_; }
  float spread() const { return spread_; }

  /// Squared distance from p to a triangle, in double.
  double distance2(const Vec3& p, std::uint32_t triangle) const;

  /// The bytes of a piece, its tree and the areas of its triangles.
  static constexpr std::uint64_t kBytesPerTriangle = 3 * (sizeof(Vec3) + sizeof(Float3)) +
                                                     3 * sizeof(LocalIndex) +
                                                     BoxTree::kBytesPerItem + sizeof(double);

 private:
  const SurfacePiece* piece_ = nullptr;
  FloatFrame frame_;
  float spread_ = 0;
  BoxTree boxes_;
  std::vector<Float3> local_;  // positions
};

}  // namespace remaps
