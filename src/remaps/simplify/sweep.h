#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/base_mesh.h"
#include "remaps/mesh/domain_level.h"
#include "remaps/mesh/topology.h"
#include "remaps/store/section_file.h"

namespace remaps::simplify {

/// The surface is no manifold.
class NotManifold : public GeometryError {
 public:
  using GeometryError::GeometryError;
};

struct SweepOptions {
  double keep =
      0.1;  ///< fraction of each segment's free vertices to keep; not used by the last sweep
  std::uint64_t base_vertices = 200;  ///< where the last sweep stops
  bool draft = false;                 ///< rank removals by estimate; never in the last sweep
  double diagonal = 1;                ///< of the input's bounding box
  double feature_angle_rad = 0;       ///< see feature_edges.h; the same at every level
  bool feature_labels = false;        ///< features between labels of faces; the level has them
  unsigned threads = 1;
  std::string input_name;        ///< for messages about the surface
  Progress* progress = nullptr;  ///< optional
};

/// Where a sweep writes.
struct SweepOutput {
  store::SectionFileWriter* log =
      nullptr;  ///< two sections a segment, see SegmentLog; not sealed here
  store::SectionFileWriter* tiles = nullptr;  ///< level 0: one section a segment
  TopologyCounter* topology = nullptr;        ///< level 0
  DomainLevel* next = nullptr;       ///< where the remaining mesh goes; null in the last sweep
  PositionSample* sample = nullptr;  ///< of the next level's vertices; with next
  BaseMesh* base = nullptr;          ///< last sweep: the base mesh
};

struct SweepCounts {
  std::uint64_t faces_in = 0;
  std::uint64_t faces_out = 0;
  std::uint64_t vertices_out = 0;
  std::uint64_t segments = 0;
  std::uint64_t records = 0;
  std::uint64_t unreferenced_vertices = 0;  ///< level 0: vertices without a face
  std::uint64_t feature_edges = 0;          ///< before: found, or left by the level before
  std::uint64_t dropped_features = 0;       ///< of them, those of short chains with a loose end
  std::uint64_t corners = 0;                ///< vertices that features alone kept
  std::uint64_t base_feature_edges = 0;     ///< last sweep
  /// Last sweep: what features let it come down to, where that is more than asked for; else 0.
  std::uint64_t least_vertices = 0;
};

/// Simplifies all segments of a level: loads each, removes vertices, appends its log and hands what
/// is left to the next level. The level is consumed. Segments are tasks of worker threads; results
/// are committed in order of segments, so the bytes written do not depend on the number of threads.
/// A level of one segment is the last: it goes to the base.
///
/// @throws NotManifold  level 0: names the first offending elements
/// Source: [AGL06] section 3; differs: segments are cut by place, the log replaces the map file of
/// every level.
SweepCounts run_sweep(DomainLevel& level, const SweepOptions& options, const SweepOutput& output);

}  // namespace remaps::simplify
