#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps::resample {

/// The numbering of a semi-regular mesh: a base mesh whose faces are split 1-to-4 `level` times.
/// Pure arithmetic, so that vertices and faces can be produced in any order and any number.
///
/// A grid point (f, i, j) of base face f has weights (n - i - j, i, j) / n, n = 2^level. Vertices
/// are ordered: base vertices; then the inner points of base edges, edge by edge; then those of
/// base faces, face by face; within an edge or a face coarse levels come first. Faces 4^level f ...
/// 4^level (f + 1) - 1 are the children of base face f, in quadtree order: child 0, 1, 2 at corner
/// 0, 1, 2, child 3 in the middle. Byte-level and numbering details: docs/formats/semi-regular.md.
class DyadicGrid {
 public:
  using BaseTriangle = std::array<std::uint32_t, 3>;

  /// @param base_vertices  number of base vertices
  /// @param base           (f) base faces; at most two faces at an edge, and one edge a pair of
  /// vertices
  /// @param level          0 to 20
  DyadicGrid(std::uint32_t base_vertices, std::span<const BaseTriangle> base, unsigned level);

  unsigned level() const { return level_; }
  std::uint64_t vertices() const;
  std::uint64_t faces() const { return base_.size() * faces_per_base_face(); }
  std::uint64_t faces_per_base_face() const { return std::uint64_t{1} << (2 * level_); }

  /// Number of a grid point. i + j <= 2^level.
  std::uint64_t vertex(std::uint32_t face, std::uint32_t i, std::uint32_t j) const;
  /// Corners of face number `index`.
  Triangle triangle(std::uint64_t index) const;

  /// Calls sample(number, base face, u, v) once for each vertex. Points of edges and corners go
  /// with the first face that has them. Order: base face by base face.
  void for_each_sample(const std::function<void(std::uint64_t number, std::uint32_t face, double u,
                                                double v)>& sample) const;

 private:
  struct EdgeUse {
    std::uint32_t edge;
    bool reversed;  // the face runs from the edge's higher vertex to its lower one
    bool first;     // this face is the first that has the edge
  };

  std::uint64_t edge_point(const EdgeUse& use, std::uint32_t m) const;
  std::uint64_t interior_point(std::uint32_t i, std::uint32_t j) const;

  unsigned level_;
  std::uint32_t n_;
  std::uint32_t base_vertices_;
  std::uint32_t edges_ = 0;
  std::vector<BaseTriangle> base_;
  std::vector<std::array<EdgeUse, 3>> use_;  // (faces) edge k runs from corner k to corner k + 1
  std::vector<std::array<bool, 3>>
      first_at_corner_;  // (faces) this face is the first at that vertex
  std::vector<std::vector<std::uint64_t>>
      row_start_;  // (levels + 1, rows) interior points new at a level, before row j
};

}  // namespace remaps::resample
