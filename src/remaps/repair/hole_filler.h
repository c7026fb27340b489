#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/domain_level.h"

namespace remaps::repair {

struct FillOptions {
  std::uint64_t most_edges = 0;  ///< of a hole that is filled
  unsigned threads = 1;
  Progress* progress = nullptr;  ///< optional
};

struct FillCounts {
  std::uint64_t holes = 0;  ///< filled
  std::uint64_t faces = 0;
  std::uint64_t vertices = 0;  ///< in the middle of holes
};

/// A hole: the vertices of a boundary loop, in the order in which the faces that fill it run along
/// it.
struct Hole {
  std::vector<VertexId> vertex;
  std::vector<Vec3f> position;
  /// Pairs of numbers in the loop, lower first, ascending, that are joined by an edge already.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joined;
  bool of_one_face = false;  ///< all around a single triangle
};

/// Triangles of least area in all that close a hole, as numbers in its loop; no side of them is an
/// edge that exists. Empty if there are none, or the hole has more than 128 edges: then it takes a
/// vertex in its middle.
/// Source: Barequet, Sharir, Filling gaps in the boundary of a polyhedron (1995), section 3.
/// Cost: cubic.
std::vector<std::array<std::uint32_t, 3>> triangulate_hole(const Hole& hole);

/// Fills the holes of up to so many edges of a first level that is a manifold. New faces and
/// vertices are appended, with numbers from `first_face` and `first_vertex` on.
/// Memory: 100 B an edge of the boundary. Cost: loads each segment once.
/// @throws BudgetError  the boundary does not fit
FillCounts fill_holes(DomainLevel& level, const FillOptions& options, FaceId first_face,
                      VertexId first_vertex, MemoryBudget& budget);

}  // namespace remaps::repair
