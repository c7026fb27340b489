#pragma once

#include <algorithm>
#include <cstdint>

#include "remaps/base/geometry.h"

namespace remaps {

/// Puts two zero bits before each of the lowest 20 bits.
inline std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | (x << 32)) & 0x001F00000000FFFFu;
  x = (x | (x << 16)) & 0x001F0000FF0000FFu;
  x = (x | (x << 8)) & 0x100F00F00F00F00Fu;
  x = (x | (x << 4)) & 0x10C30C30C30C30C3u;
  return (x | (x << 2)) & 0x1249249249249249u;
}

/// Places on the Morton curve of a cube about a box, of 2^bits cells along each side.
class MortonCurve {
 public:
  MortonCurve(const Box3& box, int bits)
      : low_(box.low), last_(static_cast<double>((1u << bits) - 1)) {
    const double side =
        std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
    cells_ = side > kLeastSide ? static_cast<double>(1u << bits) / side : 0;
  }

  std::uint64_t place(const Vec3& p) const {
    return spread_bits(cell(p.x - low_.x)) | spread_bits(cell(p.y - low_.y)) << 1 |
           spread_bits(cell(p.z - low_.z)) << 2;
  }

 private:
  static constexpr double kLeastSide = 1e-290;

  std::uint64_t cell(double offset) const {
    return static_cast<std::uint64_t>(std::clamp(offset * cells_, 0.0, last_));
  }

  Vec3 low_;
  double last_;
  double cells_;
};

}  // namespace remaps
