#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/patch.h"
#include "remaps/sphere/sphere_point.h"

namespace remaps::sphere {

/// A point of a face of the base, of weights (1 - u - v, u, v).
struct FaceWeights {
  LocalIndex face = kNoIndex;
  double u = 0, v = 0;
};

/// How far a map of a surface to the sphere is from an isometry, both scaled to the same area. All
/// are 1 for an isometry.
struct SphericalQuality {
  /// 1 / mean over the surface of (s1^2 + s2^2) / 2, with the singular values s1, s2 of the map
  /// from the sphere to it. At most 1. Source: [Praun, Hoppe 2003] section 3.3.
  double stretch_efficiency = 0;
  double area_distortion = 0;   ///< mean over the surface of (r + 1 / r) / 2, r = s1 s2
  double angle_distortion = 0;  ///< mean over the surface of (q + 1 / q) / 2, q = s1 / s2
};

/// One or more closed surfaces of genus 0, each of them triangulated on a sphere of its own, as a
/// two-way map: a point of a face with weights w is in the direction of the weighted sum of its
/// corners' places.
class SphericalMap {
 public:
  /// @param place      (v) those of vertices that no component has are not read
  /// @param triangle   (f)
  /// @param component  (f) which sphere a face is on, from 0 on, or kNoIndex
  /// @throws GeometryError  a place is not on the unit sphere, a face is turned over, or a sphere
  /// is not covered once
  /// Cost: linear. Memory: about 80 bytes a face.
  SphericalMap(std::vector<SpherePoint> place, std::span<const LocalTriangle> triangle,
               std::vector<std::uint32_t> component);

  std::uint32_t components() const { return static_cast<std::uint32_t>(first_face_.size()); }
  std::uint32_t component_of(LocalIndex face) const { return component_[face]; }
  /// The face of a component with the lowest number.
  LocalIndex first_face(std::uint32_t component) const { return first_face_[component]; }

  /// Where a point of a face is, of length 1. The face must be on a sphere.
  Vec3 direction(const FaceWeights& point) const;
  /// What is in a direction, on the sphere that the face `near` is on. Exact: which face it is, is
  /// decided in integers, for the direction as it is rounded to the grid.
  ///
  /// @param direction  of length 1
  /// Cost: the number of faces between `near` and the result.
  FaceWeights locate(const Vec3& direction, LocalIndex near) const;

  /// @param position  (v) places of the vertices on the surface
  SphericalQuality quality(std::span<const Vec3> position, std::uint32_t component) const;

 private:
  void check() const;
  bool weights(LocalIndex face, const SpherePoint& x, FaceWeights& result) const;

  std::vector<SpherePoint> place_;
  Patch patch_;
  std::vector<std::uint32_t> component_;
  std::vector<LocalIndex> first_face_;
};

}  // namespace remaps::sphere
