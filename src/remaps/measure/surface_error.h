#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "remaps/base/progress.h"
#include "remaps/measure/surface_pieces.h"
#include "remaps/mesh/triangle_stream.h"

namespace remaps {

struct SurfaceErrorOptions {
  std::uint64_t samples = 1'000'000;       // on each surface; 1 or more
  std::uint64_t seed = 1;                  // of the places of the samples
  unsigned threads = 1;                    // makes no difference to the result, not by a bit
  std::uint64_t memory_bytes = 256 << 20;  // for all but what sources hold themselves
  Progress* progress = nullptr;            // phase "measure"; may be null
  std::string original_name = "the original", remesh_name = "the remesh";  // for messages
};

/// How far two surfaces lie apart. Errors are fractions of `diagonal`.
struct SurfaceError {
  double diagonal = 0;  // of the original's bounding box, in its units
  double l2_forward = 0, mean_forward = 0, max_forward = 0;     // from the original to the remesh
  double l2_backward = 0, mean_backward = 0, max_backward = 0;  // from the remesh to the original
  std::uint64_t samples_forward = 0, samples_backward = 0;

  double l2() const { return std::max(l2_forward, l2_backward); }
};

/// Measures the distances from points of each surface to the nearest point of the other: their root
/// mean square and their mean over the area, and the largest.
///
/// Points are sampled in proportion to area and compared in double. A surface whose 3 corners a
/// triangle are no more than the samples has all of them tried too, for the largest distance only:
/// there it is mostly taken on. A larger surface has its samples close enough together without.
///
/// Surfaces may be of any size: the points are held, and the triangles stream past them
/// (docs/design/measure.md). If memory holds all points, the surface of more triangles is streamed
/// twice and the other three times; otherwise again for each part of the points, but then without
/// the pieces that are far from all of them.
///
/// @throws GeometryError  a surface has no triangles or no area, or a coordinate is not finite;
///                        names it
/// @throws BudgetError    memory_bytes is below 1 MiB
/// @throws Cancelled      by way of options.progress
/// Deterministic: the result depends on the surfaces, their pieces, samples and seed; on
/// memory_bytes by rounding of sums only.
/// Cost: 80 ns a triangle of the larger surface, decoding of tiles included, and 0.7 us a sample,
/// where the surfaces lie about as close as their triangles are large. Worse where they do not: at
/// a distance d, boxes of size h cannot tell the nearest triangle from those within about sqrt(h d)
/// of it, all of which are tried, at worst every triangle for every sample. Worse also for a stream
/// in random order: three times.
SurfaceError measure_surface_error(const SurfacePieces& original, const SurfacePieces& remesh,
                                   const SurfaceErrorOptions& options = {});
SurfaceError measure_surface_error(const TriangleSource& original, const TriangleSource& remesh,
                                   const SurfaceErrorOptions& options = {});

}  // namespace remaps
