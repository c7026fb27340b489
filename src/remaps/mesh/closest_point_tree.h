#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps {

/// The answer of a ClosestPointTree.
struct ClosestPoint {
  LocalIndex triangle = kNoIndex;  // kNoIndex: none within the bound
  double distance2 = std::numeric_limits<double>::infinity();
  std::array<double, 3> weights{};  // barycentric, on the corners of the triangle
};

/// Finds the closest of a set of triangles to a point: a bounding volume hierarchy (Embree) whose
/// boxes are float and whose distances are double.
///
/// The boxes only prune, and with a margin: coordinates are centred and scaled to [-1, 1] before
/// they are rounded to float, and every search radius is enlarged by more than all roundings
/// together. So the triangle found is the closest in double arithmetic; of several equally close
/// ones it is that of the lowest index, and the answer does not depend on the shape of the tree nor
/// on the number of threads that built it.
///
/// Embree sees the triangles as user primitives rather than as its own: then it keeps no float copy
/// of them, and prunes each by its own box instead of four by a common one.
class ClosestPointTree {
 public:
  /// What a tree takes while it is built, its most, with the corners (72) included. Measured; a
  /// test keeps it true.
  static constexpr std::size_t kPeakBytesPerTriangle = 160;

  /// Builds the tree.
  ///
  /// @param triangles  finite; none or more, of any shape
  /// @param threads    that build it; it makes no difference to the answers
  /// @throws GeometryError  a coordinate is not finite
  /// @throws Error  Embree fails, for want of memory for instance
  explicit ClosestPointTree(std::vector<TrianglePositions> triangles, unsigned threads = 1);
  ~ClosestPointTree();
  ClosestPointTree(ClosestPointTree&&) noexcept;
  ClosestPointTree& operator=(ClosestPointTree&&) noexcept;

  /// The closest point to p on the triangles that are no further than bound.
  ///
  /// @param p       finite
  /// @param bound2  squared distance beyond which nothing is wanted: the smaller, the faster
  /// @param hint    a triangle likely to be near, such as the answer for a neighbour of p: never
  /// changes the
  ///                answer, makes it several times faster; kNoIndex for none
  /// Threads: any number on one tree.
  ClosestPoint closest(const Vec3& p, double bound2 = std::numeric_limits<double>::infinity(),
                       LocalIndex hint = kNoIndex) const;

  const std::vector<TrianglePositions>& triangles() const;
  const Box3& box() const;

  /// The most bytes that the tree has held at a time, the corners included.
  std::size_t peak_bytes() const;

  /// Ends the tree and hands its triangles back, so that the memory can serve the next one.
  std::vector<TrianglePositions> release() &&;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace remaps
