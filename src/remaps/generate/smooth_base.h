#pragma once

#include <cstdint>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/generate/base_shapes.h"

namespace remaps {

struct SurfaceFrame {
  Vec3 position;
  Vec3 normal;  ///< unit length, outward
};

/// The smooth surface that a base mesh stands for: the unit sphere, or its Phong tessellation. Two
/// faces agree along their common edge.
/// Source: Boubekeur, Alexa, Phong Tessellation, SIGGRAPH Asia 2008.
class SmoothBase {
 public:
  explicit SmoothBase(ShapeMesh mesh);

  /// The surface over a point of a base face.
  /// @param weights  barycentrics; sum to 1
  SurfaceFrame frame(std::uint64_t face, const Vec3& weights) const;

  const ShapeMesh& mesh() const { return mesh_; }
  /// Of the bounding box of the base vertices.
  double diagonal() const { return diagonal_; }
  double mean_edge() const;

 private:
  ShapeMesh mesh_;
  std::vector<Vec3> normals_;
  double diagonal_ = 0;
};

}  // namespace remaps
