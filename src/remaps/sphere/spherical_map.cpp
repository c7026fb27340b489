#include "remaps/sphere/spherical_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "remaps/base/errors.h"

namespace remaps::sphere {
namespace {

/// Solid angle of a triangle (van Oosterom, Strackee 1983).
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 2 * std::atan2(dot(a, cross(b - a, c - a)), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

}  // namespace

SphericalMap::SphericalMap(std::vector<SpherePoint> place, std::span<const LocalTriangle> triangle,
                           std::vector<std::uint32_t> component)
    : place_(std::move(place)), component_(std::move(component)) {
  if (patch_.build(place_.size(), place_.size(), triangle).kind != ManifoldDefect::Kind::kNone) {
    throw GeometryError("the surface on the sphere is not manifold");
  }
  for (LocalIndex f = 0; f < component_.size(); ++f) {
    const std::uint32_t c = component_[f];
    if (c == kNoIndex) continue;
    if (c >= first_face_.size()) first_face_.resize(c + 1, kNoIndex);
    if (first_face_[c] == kNoIndex) first_face_[c] = f;
  }
  check();
}

/// Faces that all turn the same way cover a sphere so many times as their solid angles say, and
/// once means one to one.
void SphericalMap::check() const {
  std::vector<double> angle(first_face_.size());
  for (LocalIndex f = 0; f < component_.size(); ++f) {
    if (component_[f] == kNoIndex) continue;
    const LocalTriangle t = patch_.face(f);
    if (orientation(place_[t[0]], place_[t[1]], place_[t[2]]) <= 0) {
      throw GeometryError("face " + std::to_string(f) + " is turned over on the sphere");
    }
    for (LocalIndex slot = 0; slot < 3; ++slot) {
      if (patch_.opposite(corner_of(f, slot)) == kNoIndex) {
        throw GeometryError("face " + std::to_string(f) +
                            " is at a boundary, but is said to be on a sphere");
      }
    }
    angle[component_[f]] +=
        solid_angle(to_vector(place_[t[0]]), to_vector(place_[t[1]]), to_vector(place_[t[2]]));
  }
  for (std::size_t c = 0; c < angle.size(); ++c) {
    const double times = angle[c] / (4 * std::numbers::pi);
    if (!(std::fabs(times - 1) < 0.01)) {
      throw GeometryError("component " + std::to_string(c) + " covers its sphere " +
                          std::to_string(times) + " times");
    }
  }
}

Vec3 SphericalMap::direction(const FaceWeights& point) const {
  const LocalTriangle t = patch_.face(point.face);
  const Vec3 a = to_vector(place_[t[0]]), b = to_vector(place_[t[1]]), c = to_vector(place_[t[2]]);
  const Vec3 sum = a + point.u * (b - a) + point.v * (c - a);
  return 1 / norm(sum) * sum;
}

/// @return  whether x is in the face; then result is set. Otherwise result.face is the neighbour
///          across the edge that x is farthest beyond.
bool SphericalMap::weights(LocalIndex face, const SpherePoint& x, FaceWeights& result) const {
  const LocalTriangle t = patch_.face(face);
  std::array<double, 3> volume{};
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Int128 exact = orientation(x, place_[t[(i + 1) % 3]], place_[t[(i + 2) % 3]]);
    inside = inside && exact >= 0;
    volume[i] = static_cast<double>(exact);
  }
  if (inside) {
    const double sum = volume[0] + volume[1] + volume[2];
    result = {face, volume[1] / sum, volume[2] / sum};
    return sum > 0;
  }
  LocalIndex slot = 0;
  double most = 0;
  for (LocalIndex i = 0; i < 3; ++i) {
    const Vec3 edge = to_vector(place_[t[(i + 2) % 3]]) - to_vector(place_[t[(i + 1) % 3]]);
    const double beyond = -volume[i] / norm(edge);
    if (beyond > most) {
      most = beyond;
      slot = i;
    }
  }
  result.face = face_of(patch_.opposite(corner_of(face, slot)));
  return false;
}

FaceWeights SphericalMap::locate(const Vec3& direction, LocalIndex near) const {
  const SpherePoint x = to_sphere_point(direction);
  FaceWeights result{near, 0, 0};
  // Walks in triangulations that are not Delaunay may go round in circles.
  const auto limit =
      static_cast<std::size_t>(20 + 4 * std::sqrt(static_cast<double>(component_.size())));
  for (std::size_t step = 0; step < limit; ++step) {
    if (weights(result.face, x, result)) return result;
  }
  for (LocalIndex f = 0; f < component_.size(); ++f) {
    if (component_[f] == component_[near] && weights(f, x, result)) return result;
  }
  throw GeometryError("a direction is in no face of the sphere");
}

SphericalQuality SphericalMap::quality(std::span<const Vec3> position,
                                       std::uint32_t component) const {
  double area = 0, flat_area = 0, stretch = 0, ratios = 0, inverse_ratios = 0, angles = 0;
  for (LocalIndex f = 0; f < component_.size(); ++f) {
    if (component_[f] != component) continue;
    const LocalTriangle t = patch_.face(f);
    // Squared edges opposite to the corners, on the sphere and on the surface.
    std::array<double, 3> e{}, m{};
    for (std::size_t i = 0; i < 3; ++i) {
      const LocalIndex p = t[(i + 1) % 3], q = t[(i + 2) % 3];
      e[i] = norm2(to_vector(place_[q]) - to_vector(place_[p]));
      m[i] = norm2(position[q] - position[p]);
    }
    const Vec3 origin = to_vector(place_[t[0]]);
    const double flat =
        0.5 * norm(cross(to_vector(place_[t[1]]) - origin, to_vector(place_[t[2]]) - origin));
    const double own =
        0.5 * norm(cross(position[t[1]] - position[t[0]], position[t[2]] - position[t[0]]));
    double trace = 0;  // s1^2 + s2^2
    for (std::size_t i = 0; i < 3; ++i) trace += m[i] * (e[(i + 1) % 3] + e[(i + 2) % 3] - e[i]);
    trace /= 8 * flat * flat;
    area += own;
    flat_area += flat;
    stretch += 0.5 * own * trace;
    if (!(own > 0)) continue;
    ratios += own * own / flat;
    inverse_ratios += flat;
    angles += 0.5 * trace * flat;  // own (s1 / s2 + s2 / s1) / 2 = own trace / (2 s1 s2)
  }
  const double scale = flat_area / area;  // of areas: from the surface to the sphere
  SphericalQuality result;
  result.stretch_efficiency = area / (stretch * scale);
  result.area_distortion = 0.5 * (ratios * scale / area + inverse_ratios / (scale * area));
  result.angle_distortion = angles / area;
  return result;
}

}  // namespace remaps::sphere
