#pragma once

#include <cstdint>

#include "remaps/base/geometry.h"

namespace remaps::sphere {

/// Direction of a point of the square [-1, 1]^2, x to the right and y up: the sphere as an
/// octahedron, cut open along the four edges at its lowest corner (0, 0, -1) and laid out flat. The
/// middle of the square is (0, 0, 1), its corners are all (0, 0, -1); each side is folded at its
/// middle, so that points at equal distances from that are one. Seen from outside x, y and the
/// outward normal are right-handed. All
/// areas are in one ratio, pi.
/// Source: Praun, Hoppe 2003, section 4 (the layout); Clarberg, Fast Equal-Area Mapping of the
/// (Hemi)Sphere using SIMD (JGT 13, 2008), for the map in it.
/// @return  of length 1
Vec3 octahedral_direction(double x, double y);

/// Samples at the corners of a grid of (size - 1)^2 cells over the square, rows from the top.
class OctahedralGrid {
 public:
  /// @param size  odd, at least 3: so that sides and middle lines are sampled
  explicit OctahedralGrid(std::uint32_t size) : size_(size) {}

  std::uint32_t size() const { return size_; }
  Vec3 direction(std::uint32_t row, std::uint32_t column) const {
    const double n = size_ - 1;
    return octahedral_direction(2 * column / n - 1, 1 - 2 * row / n);
  }
  /// The first of the samples that are the same point: itself, but for those at the sides.
  std::uint64_t first_same(std::uint32_t row, std::uint32_t column) const {
    const std::uint32_t last = size_ - 1;
    const bool side = row == 0 || row == last, flank = column == 0 || column == last;
    if (side && flank) return 0;
    if (side && column > last / 2) column = last - column;
    if (flank && row > last / 2) row = last - row;
    return std::uint64_t{row} * size_ + column;
  }

 private:
  std::uint32_t size_;
};

}  // namespace remaps::sphere
