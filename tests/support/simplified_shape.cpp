#include "support/simplified_shape.h"

#include <gtest/gtest.h>

#include "remaps/simplify/draft_simplifier.h"
#include "remaps/simplify/feature_edges.h"
#include "remaps/simplify/sampling_load.h"
#include "support/cut_shape.h"

namespace remaps::test {

simplify::SimplifyOptions simplify_options(std::size_t target) {
  simplify::SimplifyOptions options;
  options.target_vertices = target;
  return options;
}

SimplifiedShape simplify_shape(const Shape& shape, const simplify::SimplifyOptions& options,
                               const std::vector<std::uint8_t>& locked, bool draft,
                               double feature_angle_rad) {
  SimplifiedShape result;
  result.segment = whole_segment(shape);
  if (!locked.empty()) result.segment.locked = locked;
  const ManifoldDefect defect =
      result.patch.build(shape.position.size(), result.segment.own_vertices, shape.triangle);
  EXPECT_EQ(defect.kind, ManifoldDefect::Kind::kNone);
  if (feature_angle_rad > 0) {
    simplify::FeatureOptions features;
    features.angle_rad = feature_angle_rad;
    simplify::find_features(features, result.patch, result.segment);
  }
  simplify::initialize_loads(result.patch, diagonal_of(shape), result.segment);
  const auto run = [&](auto simplifier) {
    result.left = simplifier.run(options, result.segment, result.patch, shape.position.size(),
                                 result.log, result.removed);
  };
  draft ? run(simplify::DraftSimplifier()) : run(simplify::Simplifier());
  return result;
}

SegmentLog segment_log_of(const SimplifiedShape& simplified, std::uint32_t next) {
  SegmentLog log;
  log.faces = simplified.segment.home_faces;
  log.records = simplified.log;
  for (const LocalIndex v : simplified.removed) log.removed.push_back(v);
  std::vector<LocalIndex> used(next + 1, 0);
  for (LocalIndex f = 0; f < log.faces; ++f) {
    if (!simplified.patch.face_alive(f)) continue;
    const std::uint32_t segment = next == 0 ? 0 : f % next;
    log.survivor.push_back(f);
    log.next.push_back({segment, used[segment]++});
  }
  return log;
}

std::vector<Shape> scan_shapes() {
  return {bumpy(icosphere(4), 0.08, 0.005, 1), bumpy(torus(60, 30), 0.05, 0.004, 2),
          bumpy(disk(20), 0.1, 0.01, 3), bumpy(annulus(60, 15), 0.1, 0.004, 4),
          bumpy(together(icosphere(3), disk(12)), 0.05, 0.004, 5)};
}

}  // namespace remaps::test
