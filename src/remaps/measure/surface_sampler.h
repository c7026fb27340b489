#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/progress.h"
#include "remaps/measure/surface_pieces.h"

namespace remaps {

/// What one pass over a surface tells of it.
struct SurfaceSummary {
  struct Piece {
    Box3 box;                // of its triangles
    double area_before = 0;  // of all pieces before it
    std::uint64_t triangles_before = 0;
  };

  Box3 box;
  double area = 0;  // summed up within pieces, then over them
  std::uint64_t triangles = 0;
  std::uint64_t largest_piece = 0;  // triangles
  std::vector<Piece> pieces;
  /// Points on the surface, about as many in every part of it as its area is of the whole.
  std::vector<Vec3> scouts;
};

/// Streams a surface once.
///
/// @param scouts_max  the scouts are at most so many, and at most 512 a piece
/// @throws GeometryError  no triangles, no area, or a coordinate that is not finite
SurfaceSummary summarise_surface(const SurfacePieces& surface, std::size_t scouts_max,
                                 unsigned threads, const Progress* progress = nullptr);

/// A part of the points on a surface, by number. Sample k of `samples` lies uniformly in the k-th
/// of `samples` parts of equal area into which the stream is cut, and so in a triangle with a
/// chance in proportion to its area. Corner 3 t + i is corner i of triangle t. Each depends on the
/// surface, the seed, `samples` and its number only.
struct SamplingPlan {
  std::uint64_t samples = 0;
  std::uint64_t seed = 0;
  std::uint64_t first_sample = 0, last_sample = 0;  // the last is the first that is not wanted
  std::uint64_t first_corner = 0, last_corner = 0;
};

/// A point on one surface and, later, the squared distance to what has been seen of the other.
struct SurfacePoint {
  Vec3 position;
  std::uint64_t word = 0;  // a place on a space-filling curve; then the bits of the distance

  double distance2() const { return std::bit_cast<double>(word); }
};

/// What a plan makes of a surface. The words of the points are places on a curve through its box.
struct SurfacePoints {
  std::vector<SurfacePoint> samples;
  std::vector<SurfacePoint> corners;  // several times those that triangles share
};

/// Makes the points of a plan that lie on a piece.
///
/// Threads: any number at a time.
class SurfaceSampler {
 public:
  SurfaceSampler(const SurfaceSummary& summary, const SamplingPlan& plan);

  /// Whether there are any.
  bool touches(std::size_t piece) const;
  /// @param areas   scratch
  /// @param points  replaced
  void sample(std::size_t number, const SurfacePiece& piece, std::vector<double>& areas,
              SurfacePoints& points) const;

 private:
  double area_position(std::uint64_t k) const;
  std::uint64_t first_from(double area) const;

  const SurfaceSummary& summary_;
  const SamplingPlan plan_;
  const std::uint64_t seed_;
};

}  // namespace remaps
