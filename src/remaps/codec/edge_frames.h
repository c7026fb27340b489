#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "remaps/base/geometry.h"
#include "remaps/codec/subdivision_hierarchy.h"

namespace remaps::codec {

/// Axes at an edge: along the normal of its faces, along the edge, and across it. Orthonormal.
struct EdgeFrame {
  Vec3 normal{1, 0, 0}, along{0, 1, 0}, across{0, 0, 1};

  Vec3 to_local(const Vec3& v) const { return {dot(v, normal), dot(v, along), dot(v, across)}; }
  Vec3 to_global(const Vec3& v) const { return v.x * normal + v.y * along + v.z * across; }
};

/// The frame of an edge on a coarse surface; that of the coordinates where there is no normal.
inline EdgeFrame frame_of_edge(const SubdivisionLevel& level, std::uint32_t edge,
                               std::span<const Vec3> x) {
  const Side side = level.side[edge], twin = level.twin_of(side);
  const Vec3 &a = x[level.from(side)], &b = x[level.to(side)];
  const Vec3 along = b - a;
  const Vec3 normal =
      cross(along, x[level.opposite(side)] - (twin.none() ? a : x[level.opposite(twin)]));
  const double length2 = norm2(along), normal2 = norm2(normal);
  if (!(normal2 > 1e-12 * length2 * length2)) return {};
  EdgeFrame frame;
  frame.normal = 1 / std::sqrt(normal2) * normal;
  frame.along = 1 / std::sqrt(length2) * along;
  frame.across = cross(frame.normal, frame.along);
  return frame;
}

}  // namespace remaps::codec
