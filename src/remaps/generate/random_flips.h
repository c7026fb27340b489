#pragma once

#include <array>
#include <cstdint>

#include "remaps/generate/patch_grid.h"

namespace remaps {

/// Flips edges of a patch grid at random, as a pure function of the triangle.
///
/// Every edge inside a base face has a random priority. Two triangles are a pair when their common
/// edge has the highest priority of the five edges that bound them; no triangle is in two pairs,
/// and about 3 triangles in 5 are in one. A pair is a parallelogram, so either diagonal will do.
/// Edges of the base mesh are never flipped, so the base faces stay visible in the mesh.
class RandomFlips {
 public:
  /// @param seed      well mixed: seeds that differ by little give shifted copies of one sequence
  /// @param fraction  of the pairs that take their other diagonal; 0 to 1
  RandomFlips(std::uint64_t seed, double fraction) : seed_(seed), fraction_(fraction) {}

  /// Corners of a triangle of the mesh after the flips, counter-clockwise. A flipped pair keeps its
  /// two indices.
  std::array<PatchPoint, 3> corners(const PatchGrid& grid, const GridTriangle& t) const;

 private:
  /// Priority of the edge on a side of a triangle; 0 on a base edge.
  std::uint64_t priority(const PatchGrid& grid, const GridTriangle& t, int side) const;
  int best_side(const PatchGrid& grid, const GridTriangle& t) const;

  std::uint64_t seed_;
  double fraction_;
};

}  // namespace remaps
