#include "remaps/generate/random_flips.h"

#include <cstddef>

#include "remaps/generate/hash_mix.h"

namespace remaps {
namespace {

/// Side k of a triangle joins its corners k and k + 1.
constexpr int kSides = 3;

/// The side by which the neighbour across a side sees the common edge.
int side_across(bool down, int side) {
  return (side + (down ? 2 : 1)) % kSides;
}

/// Down triangles have a neighbour in the grid across every side, up triangles not always.
bool has_across(const PatchGrid& grid, const GridTriangle& t, int side) {
  if (t.down) return true;
  if (side == 0) return t.column > 0;
  if (side == 1) return t.strip + 1 < grid.n();
  return t.column < t.strip;
}

GridTriangle across(const GridTriangle& t, int side) {
  GridTriangle other = t;
  other.down = !t.down;
  if (t.down && side == 1) ++other.column;
  if (t.down && side == 2) --other.strip;
  if (!t.down && side == 0) --other.column;
  if (!t.down && side == 1) ++other.strip;
  return other;
}

PatchPoint corner(const GridTriangle& t, int k) {
  const auto [face, r, c, down] = t;
  switch (k % kSides) {
    case 0:
      return {face, r, c};
    case 1:
      return {face, r + 1, down ? c + 1 : c};
    default:
      return {face, down ? r : r + 1, c + 1};
  }
}

}  // namespace

std::array<PatchPoint, 3> RandomFlips::corners(const PatchGrid& grid, const GridTriangle& t) const {
  const int side = best_side(grid, t);
  if (has_across(grid, t, side)) {
    const GridTriangle other = across(t, side);
    const int other_side = side_across(t.down, side);
    const bool flips = best_side(grid, other) == other_side &&
                       unit_interval(mix_bits(priority(grid, t, side))) < fraction_;
    if (flips) return {corner(t, side + 2), corner(t, side), corner(other, other_side + 2)};
  }
  return {corner(t, 0), corner(t, 1), corner(t, 2)};
}

std::uint64_t RandomFlips::priority(const PatchGrid& grid, const GridTriangle& t, int side) const {
  if (!has_across(grid, t, side)) return 0;
  const FaceId down = grid.face(t.down ? t : across(t, side));
  const int down_side = t.down ? side : side_across(t.down, side);
  return mix_bits(seed_ + down * kSides + static_cast<std::uint64_t>(down_side));
}

int RandomFlips::best_side(const PatchGrid& grid, const GridTriangle& t) const {
  std::array<std::uint64_t, kSides> priorities{};
  for (int side = 0; side < kSides; ++side)
    priorities[static_cast<std::size_t>(side)] = priority(grid, t, side);
  const auto [a, b, c] = priorities;
  if (a >= b && a >= c) return 0;
  return b >= c ? 1 : 2;
}

}  // namespace remaps
