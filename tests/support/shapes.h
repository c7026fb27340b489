#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/patch.h"

namespace remaps::test {

/// A small mesh to try things on, and what it is known to be.
struct Shape {
  std::string name;
  std::vector<Vec3> position;
  std::vector<LocalTriangle> triangle;
  int euler_characteristic = 2;
  int components = 1;
  int boundary_loops = 0;
  /// Vertices left when nothing can be removed any more without changing what it is: the least, and
  /// the most that an unlucky order may leave.
  int least_vertices = 4;
  int most_vertices = 4;
};

Shape tetrahedron();
Shape octahedron();
/// An icosahedron divided 1-to-4 so many times: 10 * 4^level + 2 vertices on the unit sphere.
Shape icosphere(unsigned level);
/// m x n vertices, both at least 3.
Shape torus(unsigned m, unsigned n);
/// Rings of six, twelve, ... vertices about a centre.
Shape disk(unsigned rings);
/// `around` x (`across` + 1) vertices between two circles.
Shape annulus(unsigned around, unsigned across);
/// A ring of `valence` vertices joined to two poles.
Shape bipyramid(unsigned valence);
/// A ring of `valence` vertices joined to one pole: a disk.
Shape cone(unsigned valence);
/// The surface of [-1, 1]^3, each side a grid of n x n squares: twelve sharp edges, eight corners.
Shape cube(unsigned n);
/// A closed cylinder of radius and height 1, its lids `rings` rings wide: two sharp rims, no
/// corner.
Shape drum(unsigned rings, unsigned across);
/// Both at once, the second moved aside.
Shape together(const Shape& a, const Shape& b);

/// One of each.
std::vector<Shape> all_shapes();

/// Moves each vertex by up to `amount` in each coordinate. The same seed gives the same shape.
void add_noise(Shape& shape, double amount, std::uint64_t seed);
/// A bumpy shape that is not alike everywhere: waves along the radius, then noise.
Shape bumpy(Shape shape, double waves, double noise, std::uint64_t seed);
double diagonal_of(const Shape& shape);

}  // namespace remaps::test
