#pragma once

#include <cstdint>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/codec/subdivision_hierarchy.h"

namespace remaps::codec {

/// What a signal on a mesh means.
enum class SignalKind : std::uint8_t {
  kColour = 1,  ///< red, green, blue from 0 to 1
  kNormal = 2,  ///< unit vectors
};

/// A function on the vertices of a mesh.
struct Signal {
  SignalKind kind = SignalKind::kColour;
  std::vector<Vec3> value;  ///< (vertices of the finest level)
};

/// A mesh with subdivision connectivity, in the numbering of SubdivisionHierarchy.
struct SemiRegularMesh {
  std::uint32_t base_vertices = 0;
  std::vector<Face> base;
  unsigned levels = 0;
  std::vector<Vec3> position;  ///< (vertices of the finest level)
  std::vector<Signal> signals;
};

/// The mesh with its base in the order in which it is coded (order_base).
/// @throws GeometryError  the base is not an oriented manifold
SemiRegularMesh in_coding_order(SemiRegularMesh mesh, MemoryBudget& budget);

}  // namespace remaps::codec
