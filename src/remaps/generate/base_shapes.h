#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps {

/// The built-in base meshes.
enum class BaseShape {
  kIcosahedron,  ///< sphere: 12 vertices, 20 faces
  kTorus,        ///< genus 1: 72 vertices, 144 faces
  kDoubleTorus,  ///< genus 2: a rounded slab with two holes, 198 vertices, 400 faces
  kDisk,         ///< one boundary loop: the icosahedron less the star of a vertex
};

/// "icosahedron", "torus", "double-torus" or "disk"; nothing for any other name.
std::optional<BaseShape> base_shape_named(std::string_view name);

/// A small oriented manifold mesh, with or without boundary, to generate a large one from.
struct ShapeMesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  /// True: the smooth surface is the unit sphere; false: the triangles rounded by their normals.
  bool spherical = false;
};

ShapeMesh make_base_mesh(BaseShape shape);

}  // namespace remaps
