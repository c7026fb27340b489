#pragma once

#include <cstdint>

#include "remaps/mesh/patch.h"
#include "remaps/mesh/segment.h"
#include "remaps/simplify/flatten.h"

/// Sharp edges of the input, and what they hold in place. See docs/design/features.md.
///
/// An edge between two faces of the input is a feature when their normals differ by more than an
/// angle, or when their labels differ. A vertex with two feature edges is removed along them only:
/// they become one. A vertex with one, with three or more, or with any on a boundary is a corner
/// and stays.
///
/// A face carries six bits (Segment::feature): bit i says that the edge opposite to its corner i is
/// a feature; bit i + 3 that this is not known, because no segment that the face was at home in had
/// the face across. Such a face has corners in several segments, so it is as it was in the input.
namespace remaps::simplify {

struct FeatureOptions {
  double angle_rad = 0;         ///< least angle between the normals, up to pi; 0: none by angle
  double least_loose = 0;       ///< a chain of features with a loose end that is shorter goes
  double least_per_corner = 0;  ///< connected features with less length a corner go
  /// At the first level loops without a corner go too when they are shorter than least_per_corner
  /// and have fewer edges than this: few edges make noise, the rim of a hole has more.
  unsigned least_loop_edges = 8;
  /// Edges between faces of different Segment::label are features too. What hangs together with one
  /// is no noise; nothing goes after the first level, where labels of few faces are known.
  bool labels = false;
};

struct FeatureCounts {
  std::uint64_t edges = 0;    ///< features with their lesser vertex (by id) in this segment
  std::uint64_t dropped = 0;  ///< of all in the segment, those that went
  std::uint64_t corners = 0;  ///< own vertices that features alone keep from being removed
};

/// Decides which edges of a segment are features, marks them in the patch and locks corners.
/// Requires an unchanged patch. Every segment that has both faces of an edge decides alike.
///
/// @param segment  feature: as loaded; empty at the first level. Out of date afterwards: the marks
///                 of the patch have the same form
/// Cost: linear.
FeatureCounts find_features(const FeatureOptions& options, Patch& patch, Segment& segment);

/// Number of features left in a patch.
std::uint64_t count_features(const Patch& patch);

/// Where a feature runs through the vertex of a star that may be removed.
inline Crease crease_of(const Patch& patch, const Star& star) {
  Crease crease;
  if (!patch.has_features() || star.boundary) return crease;
  for (unsigned i = 0; i < star.wedges; ++i) {
    if (!patch.is_feature(previous_corner(star.corner[i]))) continue;
    (crease.exists() ? crease.to : crease.from) = i;
  }
  return crease;
}

}  // namespace remaps::simplify
