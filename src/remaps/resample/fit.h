#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/triangle_stream.h"

namespace remaps::resample {

struct FitOptions {
  unsigned rounds = 2;
  double samples_per_vertex = 10;  ///< of the original, for each vertex of the mesh
  unsigned iterations = 30;        ///< of the conjugate gradients of a round, at most
  double stiffness = 0.4;          ///< of a vertex against moving, in units of one sample
  unsigned threads = 1;
  Progress* progress = nullptr;  ///< optional
};

/// Moves the vertices of a mesh so that its faces approximate the original in the least-squares
/// sense, instead of its vertices lying on it. Each round projects samples of the original to the
/// mesh, then solves for the displacements that bring the foot points to their samples: a mass
/// matrix of the linear elements, assembled a face, solved by conjugate gradients.
///
/// @param triangles  (f) of the mesh
/// @param original   the surface, streamed once a round and once for its area
/// @param positions  (v) moved in place; same frame as the original
/// @throws BudgetError  mesh, tree and matrix (about 270 B a face) do not fit
/// Cost a round: a closest-point query a sample, 2 passes over the faces an iteration.
/// Deterministic for any number of threads.
/// Source: Hoppe et al., Mesh Optimization, SIGGRAPH 93, section 4.1, with fixed connectivity.
void fit_vertices(std::span<const std::array<std::uint32_t, 3>> triangles,
                  const TriangleSource& original, const FitOptions& options, MemoryBudget& budget,
                  std::vector<Vec3>& positions);

}  // namespace remaps::resample
