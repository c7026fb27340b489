#include "remaps/generate/smooth_base.h"

#include <utility>

namespace remaps {
namespace {

/// How far points move from the flat triangle to the tangent planes of its corners; the value of
/// the source.
constexpr double kRounding = 0.75;

Vec3 combine(const Vec3& weights, const Vec3& a, const Vec3& b, const Vec3& c) {
  return weights.x * a + weights.y * b + weights.z * c;
}

/// The projection of p onto the plane through origin with a unit normal.
Vec3 project(const Vec3& p, const Vec3& origin, const Vec3& normal) {
  return p - dot(p - origin, normal) * normal;
}

Vec3 normalized(const Vec3& v) {
  const double length = norm(v);
  return length > 0 ? 1 / length * v : Vec3{0, 0, 1};
}

}  // namespace

SmoothBase::SmoothBase(ShapeMesh mesh) : mesh_(std::move(mesh)), normals_(mesh_.positions.size()) {
  Box3 box;
  for (const Vec3& p : mesh_.positions) box.add(p);
  diagonal_ = box.diagonal();

  for (const Triangle& t : mesh_.triangles) {
    const Vec3& a = mesh_.positions[t[0]];
    const Vec3 area = cross(mesh_.positions[t[1]] - a, mesh_.positions[t[2]] - a);
    for (const VertexId v : t) normals_[v] = normals_[v] + area;
  }
  for (Vec3& normal : normals_) normal = normalized(normal);
}

SurfaceFrame SmoothBase::frame(std::uint64_t face, const Vec3& weights) const {
  const auto [i, j, k] = mesh_.triangles[face];
  const Vec3& a = mesh_.positions[i];
  const Vec3& b = mesh_.positions[j];
  const Vec3& c = mesh_.positions[k];
  const Vec3 flat = combine(weights, a, b, c);
  if (mesh_.spherical) {
    const Vec3 p = normalized(flat);
    return {p, p};
  }
  const Vec3 round = combine(weights, project(flat, a, normals_[i]), project(flat, b, normals_[j]),
                             project(flat, c, normals_[k]));
  return {(1 - kRounding) * flat + kRounding * round,
          normalized(combine(weights, normals_[i], normals_[j], normals_[k]))};
}

double SmoothBase::mean_edge() const {
  double sum = 0;
  for (const Triangle& t : mesh_.triangles) {
    for (std::size_t k = 0; k < 3; ++k)
      sum += norm(mesh_.positions[t[(k + 1) % 3]] - mesh_.positions[t[k]]);
  }
  return sum / static_cast<double>(3 * mesh_.triangles.size());
}

}  // namespace remaps
