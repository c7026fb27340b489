#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps {

/// A point of the n x n grid of a base face ABC. Row r runs from edge AB (column 0) to edge AC
/// (column r); row 0 is A, row n the edge BC. Barycentrics: (n - row, row - column, column) / n.
struct PatchPoint {
  std::uint64_t face = 0, row = 0, column = 0;

  friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
};

/// A triangle of the grid of a base face. Strip r lies between rows r and r + 1. Up triangle c of
/// it has corners (r, c), (r+1, c), (r+1, c+1), 0 <= c <= r; down triangle c has (r, c), (r+1,
/// c+1), (r, c+1), 0 <= c < r.
struct GridTriangle {
  std::uint64_t face = 0, strip = 0, column = 0;
  bool down = false;
};

/// The index arithmetic of a base mesh whose every face is divided into n x n triangles.
///
/// Vertices and triangles are numbered base face by base face, row by row, so that what is near on
/// the surface is mostly near in both orders. A vertex on a base edge or at a base vertex is
/// numbered with the first base face that has it, its owner. Nothing that grows with n is stored.
class PatchGrid {
 public:
  /// @throws GeometryError  base is not an oriented manifold, or leaves a vertex unused, or n is so
  ///                        large that counts do not fit 62 bits
  PatchGrid(std::span<const Triangle> base, std::uint64_t base_vertices, std::uint64_t n);

  /// The n that brings the number of vertices nearest to a target; at least 1.
  static std::uint64_t nearest_n(std::span<const Triangle> base, std::uint64_t base_vertices,
                                 std::uint64_t target);

  std::uint64_t n() const { return n_; }
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t faces() const { return blocks_.size() * n_ * n_; }

  /// A vertex in the grid of the face that owns it. v < vertices().
  PatchPoint point(VertexId v) const;
  /// The vertex at a grid point, given in any face that has it.
  VertexId vertex(const PatchPoint& p) const;

  /// f < faces().
  GridTriangle triangle(FaceId f) const;
  FaceId face(const GridTriangle& t) const;

 private:
  /// Edges of a face are numbered by their first corner: 0 = AB, 1 = BC, 2 = CA.
  struct EdgeOwner {
    std::uint64_t face = 0;
    int edge = 0;
  };
  struct Block {
    VertexId first = 0;
    std::array<bool, 3> owns_corner{};
    std::array<bool, 3> owns_edge{};
    std::array<VertexId, 3> corner{};
    std::array<EdgeOwner, 3> edge_owner{};
  };

  void find_edge_owners(std::span<const Triangle> base);
  void number_vertices(std::span<const Triangle> base, std::uint64_t base_vertices);
  VertexId row_start(const Block& block, std::uint64_t row) const;
  VertexId owned_vertex(const PatchPoint& p) const;
  VertexId edge_vertex(std::uint64_t face, int edge, std::uint64_t steps) const;
  PatchPoint edge_point(std::uint64_t face, int edge, std::uint64_t steps) const;

  std::uint64_t n_;
  std::uint64_t vertices_ = 0;
  std::vector<Block> blocks_;
};

}  // namespace remaps
