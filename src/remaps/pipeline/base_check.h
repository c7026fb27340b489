#pragma once

#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/base_mesh.h"
#include "remaps/mesh/topology.h"

namespace remaps::pipeline {

/// Counts a small mesh in memory, from its triangles alone.
/// @throws CorruptionError  it is not an oriented manifold, names a vertex that does not exist, or
///                          has one without a face
Topology count_base(const BaseMesh& base);

/// Finds which input vertex each base vertex is: triangle f of the base has, corner by corner,
/// those of replayed[f].
/// @return  (v) input indices, all different
/// @throws CorruptionError  there is no such renumbering
std::vector<VertexId> match_base(const BaseMesh& base, const std::vector<Triangle>& replayed);

}  // namespace remaps::pipeline
