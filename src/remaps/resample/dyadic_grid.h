#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/base/geometry.h"
#include "remaps/map/point_buckets.h"

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
  /// Corners of face number `index` as grid points (i, j) of its base face.
  std::array<std::array<std::uint32_t, 2>, 3> corners(std::uint64_t index) const;
  /// Corners of face number `index`.
  Triangle triangle(std::uint64_t index) const;
  /// Corners of the faces first, first + 1, ...: a few instructions a face where `first` is a
  /// multiple of 256.
  void triangles(std::uint64_t first, std::span<Triangle> out) const;

  /// The vertices that the mesh of a coarser level has too, in the order of that mesh, as runs of
  /// numbers of this one.
  /// @param level  at most that of this grid
  void coarse_vertices(unsigned level,
                       FunctionRef<void(std::uint64_t first, std::uint64_t count)> run) const;

  /// All vertices with their places on the base, in an order of its own, of which this gives
  /// samples first, first + 1, ...: base vertices, edges, then the inner points of each face in
  /// square blocks. Neighbours take nearly the same way through the records of the map, which
  /// caches and branch prediction reward. Points of edges and corners go with the first face that
  /// has them. The tag is the vertex number.
  /// @throws CorruptionError  a base vertex has no face
  void samples(std::uint64_t first, std::span<map::TaggedPoint> out) const;

 private:
  /// Faces of this many levels are numbered together.
  static constexpr unsigned kBlockLevels = 4;
  /// Side of the blocks of inner samples.
  static constexpr std::uint32_t kSampleBlock = 16;

  struct GridPoint {
    std::uint32_t i, j;
  };
  struct EdgeUse {
    std::uint32_t edge;
    bool reversed;  // the face runs from the edge's higher vertex to its lower one
  };
  /// A corner of a face, or the edge from it to the next.
  struct Corner {
    std::uint32_t face = kNoIndex;
    std::uint32_t number = 0;
  };

  void build_block();
  std::uint64_t first_inner_point() const;
  std::uint64_t edge_point(const EdgeUse& use, std::uint32_t m) const;
  std::uint64_t inner_point(std::uint32_t i, std::uint32_t j) const;
  void inner_samples(std::uint64_t index, std::span<map::TaggedPoint> out) const;
  map::TaggedPoint corner_sample(std::uint64_t vertex) const;
  map::TaggedPoint edge_sample(std::uint64_t index) const;

  unsigned level_;
  std::uint32_t n_;
  std::uint32_t base_vertices_;
  std::vector<BaseTriangle> base_;
  std::vector<std::array<EdgeUse, 3>> use_;  // (faces) edge k runs from corner k to corner k + 1
  std::vector<Corner> corner_of_;            // (base vertices) in the first face that has it
  std::vector<Corner> edge_of_;              // (edges) likewise
  std::vector<std::vector<std::uint64_t>>
      row_start_;  // (levels + 1, rows) interior points new at a level, before row j
  /// A face split block_level_ times: its grid points, as multiples of its edge vectors, and the
  /// corners of the parts among them.
  unsigned block_level_ = 0;
  std::vector<GridPoint> block_point_;
  std::vector<std::array<std::uint16_t, 3>> block_face_;
};

}  // namespace remaps::resample
