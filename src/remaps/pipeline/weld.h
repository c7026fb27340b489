#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/indexed_stream.h"

namespace remaps::pipeline {

struct WeldOptions {
  /// In file units. 0: vertices of exactly equal position become one (-0 equals 0). More: each
  /// vertex is joined to the lowest-numbered one within this distance, that one to its own, and so
  /// on; it takes the position where this ends.
  double distance = 0;
  std::filesystem::path directory;  ///< for temporary files
  std::uint64_t memory_bytes = 0;   ///< taken from the budget while welding
};

/// A mesh whose vertices were welded. Its vertices are numbered in the order in which they first
/// occur; its faces are those of the input, in their order, also those that welding made
/// degenerate.
class WeldedMesh : public IndexedMeshReader {
 public:
  /// Vertices that are no more.
  virtual std::uint64_t welded_vertices() const = 0;
  /// From now on this mesh has the attributes of the one that was welded (weld_attributes.h), which
  /// it reads again for them.
  /// @param source  that one
  virtual void carry_attributes(std::unique_ptr<IndexedMeshReader> source) = 0;
};

/// Welds the vertices of a mesh of any size, out of core. The result is in temporary files that
/// live as long as it; `mesh` is read here, once for positions and, unless its faces share no
/// vertices, once for triangles, and is needed afterwards for attributes only. The files take 12
/// bytes a vertex (24 where the input is not of floats), 12 a face and 4 a vertex before welding
/// (8 and 24 where numbers are beyond 2^32), while they are made some 60 a corner more.
///
/// Cost: two or three bucket sorts of the vertices. Deterministic; the result does not depend on
/// the memory. One thread.
/// @throws InputError   as from `mesh`
/// @throws BudgetError  too little memory, or a distance so large that much of the mesh is in one
/// place
std::unique_ptr<WeldedMesh> weld_vertices(IndexedMeshReader& mesh, const WeldOptions& options,
                                          MemoryBudget& budget, Progress& progress);

}  // namespace remaps::pipeline
