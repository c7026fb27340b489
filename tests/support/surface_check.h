#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "remaps/mesh/patch.h"
#include "remaps/mesh/topology.h"

namespace remaps::test {

/// What a set of triangles is, counted from scratch and without any of the library's adjacency.
/// Vertices may have any numbers. `defect` is empty when it is an oriented manifold.
struct CountedSurface {
  Topology topology;
  std::string defect;
};
CountedSurface count_surface(std::span<const Triangle> triangles);

std::vector<Triangle> alive_faces(const Patch& patch);

/// Recomputes the adjacency of a patch and compares: opposite corners, first corners (through star
/// and neighbours), valences, boundary flags, what is alive.
/// @return  the first difference, in words; empty when there is none
std::string patch_defect(const Patch& patch);

}  // namespace remaps::test
