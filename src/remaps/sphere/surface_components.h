#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/mesh/patch.h"

namespace remaps::sphere {

/// What one connected part of a surface is.
struct SurfaceComponent {
  std::uint64_t faces = 0, vertices = 0;
  std::uint64_t boundary_loops = 0;
  std::int64_t euler_characteristic = 0;

  /// With its boundaries closed.
  std::int64_t genus() const {
    return (2 - euler_characteristic - static_cast<std::int64_t>(boundary_loops)) / 2;
  }
  bool is_sphere() const { return boundary_loops == 0 && euler_characteristic == 2; }
};

struct SurfaceComponents {
  std::vector<SurfaceComponent> component;  ///< most faces first, then by lowest face
  std::vector<std::uint32_t> of_face;       ///< (f)
};

/// @param vertices  all below this
/// @param triangle  (f) an oriented manifold
/// @throws GeometryError  it is not manifold
/// Cost: about linear.
SurfaceComponents find_components(std::size_t vertices, std::span<const LocalTriangle> triangle);

}  // namespace remaps::sphere
