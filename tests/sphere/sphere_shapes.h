#pragma once

#include <algorithm>
#include <vector>

#include "support/shapes.h"

namespace remaps::test {

/// Closed ones of genus 0, of 4 to some 2,600 vertices: round, flat, with corners and folds, and
/// one that is twenty times as long as wide.
inline std::vector<Shape> spherical_shapes() {
  Shape needle = icosphere(3);
  needle.name = "needle";
  for (Vec3& p : needle.position) p = {20 * p.x, p.y, p.z};
  return {tetrahedron(), octahedron(), icosphere(2), bipyramid(15),
          cube(6),       drum(4, 12),  needle,       bumpy(icosphere(4), 0.4, 0.005, 3)};
}

/// Triangles, each begun at its least corner, sorted.
inline std::vector<LocalTriangle> normalized(std::vector<LocalTriangle> triangles) {
  for (LocalTriangle& t : triangles)
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace remaps::test
