#include "remaps/simplify/sampling_load.h"

#include <algorithm>
#include <vector>

namespace remaps::simplify {
namespace {

struct Point {
  double x, y;
};

/// A convex polygon with room for a triangle cut by the lines of one fan.
struct Polygon {
  std::array<Point, kMaxRing + 3> p;
  unsigned size = 0;

  double doubled_area() const {
    double sum = 0;
    for (unsigned i = 1; i + 1 < size; ++i) {
      sum += (p[i].x - p[0].x) * (p[i + 1].y - p[0].y) - (p[i].y - p[0].y) * (p[i + 1].x - p[0].x);
    }
    return sum;
  }
};

/// Keeps the part of `polygon` on the left of the line a -> b; returns twice the area of what was
/// cut off on the right.
double cut_right(GridPoint a, GridPoint b, Polygon& polygon, double whole) {
  std::array<double, kMaxRing + 3> side;
  bool any_left = false;
  bool any_right = false;
  for (unsigned i = 0; i < polygon.size; ++i) {
    side[i] = (b.x - a.x) * (polygon.p[i].y - a.y) - (b.y - a.y) * (polygon.p[i].x - a.x);
    any_left |= side[i] > 0;
    any_right |= side[i] < 0;
  }
  if (!any_left) {
    polygon.size = 0;
    return whole;
  }
  if (!any_right) return 0;
  Polygon left;
  for (unsigned i = 0; i < polygon.size; ++i) {
    const unsigned k = i + 1 == polygon.size ? 0 : i + 1;
    if (side[i] >= 0) left.p[left.size++] = polygon.p[i];
    if ((side[i] > 0 && side[k] < 0) || (side[i] < 0 && side[k] > 0)) {
      const double t = side[i] / (side[i] - side[k]);
      left.p[left.size++] = {polygon.p[i].x + t * (polygon.p[k].x - polygon.p[i].x),
                             polygon.p[i].y + t * (polygon.p[k].y - polygon.p[i].y)};
    }
  }
  polygon = left;
  return std::max(0.0, whole - left.doubled_area());
}

Vec3 vector_between(const Segment& s, LocalIndex from, LocalIndex to) {
  return widen(s.position[to]) - widen(s.position[from]);
}

/// Squared curvature a face: mean over its edges of (change of the vertex normals / edge length)^2.
double squared_curvature(const Segment& s, const LocalTriangle& t,
                         const std::array<Vec3, 3>& normal) {
  double sum = 0;
  for (unsigned i = 0; i < 3; ++i) {
    const unsigned k = (i + 1) % 3;
    const double length2 = norm2(vector_between(s, t[i], t[k]));
    if (length2 > 0) sum += norm2(normal[k] - normal[i]) / length2;
  }
  return sum / 3;
}

Vec3 doubled_normal(const Segment& s, const LocalTriangle& t) {
  return cross(vector_between(s, t[0], t[1]), vector_between(s, t[0], t[2]));
}

Vec3 unit(const Vec3& v) {
  const double length = norm(v);
  return length > 0 ? (1 / length) * v : v;
}

/// The normal at a corner of the faces around its vertex that no feature parts from its face.
Vec3 normal_between_features(const Patch& patch, const Segment& s, LocalIndex corner) {
  Vec3 sum = doubled_normal(s, s.triangle[face_of(corner)]);
  const auto open = [&](LocalIndex side) {
    return patch.is_feature(side) ? kNoIndex : patch.opposite(side);
  };
  for (LocalIndex c = corner;;) {
    const LocalIndex across = open(next_corner(c));
    if (across == kNoIndex) break;
    c = next_corner(across);
    if (c == corner) return unit(sum);
    sum = sum + doubled_normal(s, s.triangle[face_of(c)]);
  }
  for (LocalIndex c = corner;;) {
    const LocalIndex across = open(previous_corner(c));
    if (across == kNoIndex) break;
    c = previous_corner(across);
    sum = sum + doubled_normal(s, s.triangle[face_of(c)]);
  }
  return unit(sum);
}

/// Vertices with a feature.
std::vector<std::uint8_t> at_features(const Patch& patch, const Segment& s) {
  std::vector<std::uint8_t> result(s.vertex_id.size(), 0);
  for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
    for (LocalIndex i = 0; i < 3; ++i) {
      if (!patch.is_feature(corner_of(f, i))) continue;
      result[s.triangle[f][(i + 1) % 3]] = result[s.triangle[f][(i + 2) % 3]] = 1;
    }
  }
  return result;
}

/// Squared curvature of each face.
std::vector<double> curvatures(const Patch& patch, const Segment& s,
                               std::span<const Vec3> vertex_normal) {
  std::vector<double> result(s.triangle.size());
  std::vector<std::uint8_t> at_feature;
  if (patch.has_features()) at_feature = at_features(patch, s);
  for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
    const LocalTriangle& t = s.triangle[f];
    std::array<Vec3, 3> normal{vertex_normal[t[0]], vertex_normal[t[1]], vertex_normal[t[2]]};
    for (LocalIndex i = 0; i < 3 && !at_feature.empty(); ++i) {
      if (at_feature[t[i]]) normal[i] = normal_between_features(patch, s, corner_of(f, i));
    }
    result[f] = squared_curvature(s, t, normal);
  }
  return result;
}

/// Holds boundaries and features in place: each gets the planes through it that are upright on its
/// faces.
void add_edge_planes(const Patch& patch, Segment& s, LocalIndex f, const Vec3& unit_normal) {
  for (LocalIndex i = 0; i < 3; ++i) {
    const LocalIndex c = corner_of(f, i);
    if (patch.opposite(c) != kNoIndex && !(patch.has_features() && patch.is_feature(c))) continue;
    const LocalIndex a = s.triangle[f][(i + 1) % 3];
    const LocalIndex b = s.triangle[f][(i + 2) % 3];
    const Vec3 edge = vector_between(s, a, b);
    const double length2 = norm2(edge);
    if (!(length2 > 0)) continue;
    const Vec3 across = (1 / std::sqrt(length2)) * cross(edge, unit_normal);
    for (const LocalIndex v : {a, b}) {
      if (v < s.own_vertices) s.quadric[v].add_plane(across, 0, length2);
    }
  }
}

}  // namespace

void initialize_loads(const Patch& patch, double diagonal, Segment& s) {
  const std::size_t faces = s.triangle.size();
  s.quadric.assign(s.vertex_id.size(), {});
  s.load.assign(faces, 0);
  std::vector<Vec3> normal(s.vertex_id.size());
  std::vector<double> area(faces);
  for (LocalIndex f = 0; f < faces; ++f) {
    const LocalTriangle& t = s.triangle[f];
    const Vec3 doubled = doubled_normal(s, t);
    const double length = norm(doubled);
    area[f] = 0.5 * length;
    for (const LocalIndex v : t) normal[v] = normal[v] + doubled;
    if (!(length > 0)) continue;
    const Vec3 upright = (1 / length) * doubled;
    for (const LocalIndex v : t) {
      if (v < s.own_vertices) s.quadric[v].add_plane(upright, 0, area[f] / 3);
    }
    add_edge_planes(patch, s, f, upright);
  }
  for (Vec3& n : normal) n = unit(n);

  const double least = 1 / (diagonal * diagonal);
  const std::vector<double> curvature = curvatures(patch, s, normal);
  for (LocalIndex f = 0; f < faces; ++f) {
    double sum = curvature[f] * area[f];
    double weight = area[f];
    for (LocalIndex i = 0; i < 3; ++i) {
      const LocalIndex across = patch.opposite(corner_of(f, i));
      if (across == kNoIndex) continue;
      if (patch.has_features() && patch.is_feature(corner_of(f, i))) continue;
      sum += curvature[face_of(across)] * area[face_of(across)];
      weight += area[face_of(across)];
    }
    const double smooth = weight > 0 ? sum / weight : 0;
    s.load[f] = static_cast<float>((smooth + least) * area[f] * area[f] * area[f]);
  }
}

double carry_loads(const FlatStar& star, unsigned apex, std::span<const float> wedge_load,
                   std::span<double> fan_load) {
  const unsigned n = star.ring_size();
  const auto wrap = [n](unsigned slot) { return slot >= n ? slot - n : slot; };
  const GridPoint w = star.ring[apex];
  std::array<double, kMaxRing> fan_area;
  for (unsigned j = 0; j + 2 < n; ++j) {
    fan_area[j] = orientation(w, star.ring[wrap(apex + 1 + j)], star.ring[wrap(apex + 2 + j)]);
    fan_load[j] = 0;
  }
  for (unsigned i = 0; i < star.wedges; ++i) {
    const GridPoint a = star.ring[i];
    const GridPoint b = star.ring[wrap(i + 1)];
    const double area = orientation(a, b);
    const double scale = wedge_load[i] / (area * area * area);
    Polygon rest;
    rest.p[0] = {0, 0};
    rest.p[1] = {double(a.x), double(a.y)};
    rest.p[2] = {double(b.x), double(b.y)};
    rest.size = 3;
    double left = area;
    for (unsigned j = 0; j + 3 < n && rest.size > 0; ++j) {
      const double part = cut_right(w, star.ring[wrap(apex + 2 + j)], rest, left);
      fan_load[j] += scale * part * fan_area[j] * fan_area[j];
      left -= part;
    }
    if (rest.size > 0) fan_load[n - 3] += scale * left * fan_area[n - 3] * fan_area[n - 3];
  }
  double sum = 0;
  for (unsigned j = 0; j + 2 < n; ++j) sum += fan_load[j];
  return sum;
}

}  // namespace remaps::simplify
