#pragma once

#include <span>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps::sphere {

/// One vertex of a triangulated sphere with its neighbours, as a function of where the vertex is:
/// how much its triangles stretch the surface that the sphere stands for.
///
/// The energy of a triangle is its surface area times the mean of the squared singular values of
/// the linear map from it to the surface: the L2 stretch of Sander et al. 2001 that Praun, Hoppe
/// 2003 (section 3.3) minimize. With 2 D for the sixfold volume of (centre, triangle), instead of
/// the area of the flat triangle, it grows beyond all bounds where the triangle on the sphere would
/// turn over.
class StarStretch {
 public:
  /// Takes another vertex.
  ///
  /// @param centre   its position on the surface
  /// @param ring     (n) those of its neighbours, counter-clockwise
  /// @param area     a surface triangle counts as if an equilateral one of this area were added to
  ///                 it, that has a share in the energy even if the surface has no area there
  void set_surface(const Vec3& centre, std::span<const Vec3> ring, double area);
  /// @param ring  (n) the neighbours' places on the sphere
  void set_ring(std::span<const Vec3> ring) { ring_.assign(ring.begin(), ring.end()); }

  /// True if all triangles turn counter-clockwise with a margin that rounding to the grid of
  /// SpherePoint does not use up.
  bool is_oriented(const Vec3& x) const;
  /// @return  infinite if a triangle has no area
  double energy(const Vec3& x) const;
  /// A place of less energy, or x, by so many steps of Newton's method on the sphere. From a place
  /// where all triangles are oriented to another one.
  Vec3 improve(const Vec3& x, unsigned steps) const;

 private:
  struct Triangle {
    double area;                         // of the surface
    double across, to_first, to_second;  // squared lengths of edges: opposite to the vertex, to
                                         // ring[i], to ring[i + 1]
  };
  struct Slopes {
    double energy = 0, gu = 0, gv = 0, huu = 0, huv = 0, hvv = 0;
  };
  Slopes slopes(const Vec3& x, const Vec3& u, const Vec3& v) const;
  std::size_t after(std::size_t i) const { return i + 1 == ring_.size() ? 0 : i + 1; }

  std::vector<Triangle> triangle_;
  std::vector<Vec3> ring_;
};

}  // namespace remaps::sphere
