#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/triangle_stream.h"

namespace remaps {

/// What one pass over a surface tells of it.
struct SurfaceSummary {
  Box3 box;
  double area = 0;  // summed in the order of the stream
  std::uint64_t triangles = 0;
  /// Some of its triangles, evenly spread along the stream: all of them, if no more were asked for.
  std::vector<TrianglePositions> scouts;
};

/// Streams a surface once.
///
/// @param scouts_max  at least 2; the scouts are at most so many, and at least half of it if there
/// are as many
/// @throws GeometryError  no triangles, no area, or a coordinate that is not finite
SurfaceSummary summarise_surface(const TriangleSource& surface, std::size_t scouts_max,
                                 const Progress* progress = nullptr);

/// Points on a surface, by number. Point k < samples lies uniformly in the k-th of `samples` parts
/// of equal area into which the stream is cut, and so in a triangle with a chance in proportion to
/// its area; point samples + 3 t + i is corner i of triangle t, if `corners` is set. Each depends
/// on the surface, the plan and its number only.
struct SamplingPlan {
  std::uint64_t samples = 0;
  std::uint64_t seed = 0;
  bool corners = false;

  std::uint64_t points(const SurfaceSummary& surface) const {
    return samples + (corners ? 3 * surface.triangles : 0);
  }
};

/// A point on one surface and the squared distance to what has been seen of the other.
struct SurfacePoint {
  Vec3 position;
  double distance2 = 0;
  /// The place on a space-filling curve through the box of the surface, times 2, plus 1 for a
  /// corner.
  std::uint64_t key = 0;

  bool is_corner() const { return (key & 1) != 0; }
};

/// Streams a surface once for the points first to last - 1 of a plan.
///
/// @param points  replaced; ordered by key, so that neighbours in space are neighbours in it; their
/// distance infinite
/// @throws GeometryError  the surface is not the one that was summarised
void sample_surface(const TriangleSource& surface, const SurfaceSummary& summary,
                    const SamplingPlan& plan, std::uint64_t first, std::uint64_t last,
                    std::vector<SurfacePoint>& points, const Progress* progress = nullptr);

}  // namespace remaps
