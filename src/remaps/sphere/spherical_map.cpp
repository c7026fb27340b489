#include "remaps/sphere/spherical_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "remaps/base/errors.h"

namespace remaps::sphere {
namespace {

/// Rounding to the grid moves a point by less.
constexpr double kOffSphere = 1e-11;

/// Integrals over a surface of how its map to the sphere distorts it: midpoint rule on triangles
/// that are split until they are small as seen from the centre.
class StretchIntegral {
 public:
  /// @param scale  of areas, from the surface to the sphere
  explicit StretchIntegral(double scale) : scale_(scale) {}

  /// @param corner  on the sphere
  /// @param m, n    edges of the surface from the first corner to the others
  void add(const std::array<Vec3, 3>& corner, const Vec3& m, const Vec3& n) {
    mm_ = dot(m, m);
    mn_ = dot(m, n);
    nn_ = dot(n, n);
    own_ = norm(cross(m, n));
    edge_ = {corner[1] - corner[0], corner[2] - corner[0]};
    if (own_ > 0) split(corner, 0.5 * own_, 0);
  }

  double stretch() const { return stretch_; }
  double area_distortion() const { return areas_; }
  double angle_distortion() const { return angles_; }

 private:
  static constexpr double kSmall = 0.03;
  static constexpr unsigned kMostSplits = 8;

  void split(const std::array<Vec3, 3>& p, double area, unsigned depth) {
    const Vec3 &a = p[0], &b = p[1], &c = p[2];
    const Vec3 middle = 1.0 / 3 * (a + b + c);
    const double longest = std::max({norm2(b - a), norm2(c - b), norm2(a - c)});
    if (depth == kMostSplits || longest < kSmall * kSmall * norm2(middle)) {
      take(middle, area);
      return;
    }
    const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    for (const auto& part : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) {
      split(part, 0.25 * area, depth + 1);
    }
  }

  /// The map at a point of the flat triangle: its two metrics, and from them the singular values.
  void take(const Vec3& point, double area) {
    const double length2 = norm2(point);
    const double du = dot(edge_[0], point), dv = dot(edge_[1], point);
    const double uu = (norm2(edge_[0]) - du * du / length2) / length2;
    const double uv = (dot(edge_[0], edge_[1]) - du * dv / length2) / length2;
    const double vv = (norm2(edge_[1]) - dv * dv / length2) / length2;
    const double det = uu * vv - uv * uv;  // of the sphere's; positive
    if (!(det > 0)) return;
    const double squares = scale_ * (mm_ * vv - 2 * mn_ * uv + nn_ * uu) / det;  // s1^2 + s2^2
    const double ratio = scale_ * own_ / std::sqrt(det);                         // s1 s2
    stretch_ += area * 0.5 * squares;
    areas_ += area * 0.5 * (ratio + 1 / ratio);
    angles_ += area * 0.5 * squares / ratio;
  }

  double scale_;
  double mm_ = 0, mn_ = 0, nn_ = 0, own_ = 0;  // of the surface triangle
  std::array<Vec3, 2> edge_;                   // of the flat one
  double stretch_ = 0, areas_ = 0, angles_ = 0;
};

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
    for (const LocalIndex v : t) {
      if (std::fabs(norm(to_vector(place_[v])) - 1) < kOffSphere) continue;
      throw GeometryError("vertex " + std::to_string(v) + " is not on the unit sphere");
    }
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
  double area = 0;
  for (LocalIndex f = 0; f < component_.size(); ++f) {
    if (component_[f] != component) continue;
    const LocalTriangle t = patch_.face(f);
    area += 0.5 * norm(cross(position[t[1]] - position[t[0]], position[t[2]] - position[t[0]]));
  }
  StretchIntegral integral(4 * std::numbers::pi / area);
  for (LocalIndex f = 0; f < component_.size(); ++f) {
    if (component_[f] != component) continue;
    const LocalTriangle t = patch_.face(f);
    integral.add({to_vector(place_[t[0]]), to_vector(place_[t[1]]), to_vector(place_[t[2]])},
                 position[t[1]] - position[t[0]], position[t[2]] - position[t[0]]);
  }
  return {area / integral.stretch(), integral.area_distortion() / area,
          integral.angle_distortion() / area};
}

}  // namespace remaps::sphere
