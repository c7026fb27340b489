#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/map/point_buckets.h"
#include "remaps/mesh/attribute_file.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/resample/attribute_mixer.h"
#include "remaps/resample/resampler.h"
#include "remaps/store/row_join.h"
#include "remaps/store/row_spool.h"

namespace remaps::resample {

/// Attributes of input vertices at points of the input surface. Points come tile by tile, their
/// rows are looked up when all are there.
class VertexAttributeSampler {
 public:
  /// @param specs         that are wanted; those of other elements are passed over
  /// @param points        so many will come; their tags are below
  /// @param buffer_bytes  for write buffers while points come
  VertexAttributeSampler(AttributeFile& attributes, std::span<const AttributeSpec> specs,
                         std::uint64_t points, const std::filesystem::path& temp_dir,
                         std::uint64_t buffer_bytes, MemoryBudget& budget);

  void add(const Tile& tile, std::span<const map::TaggedPoint> points);
  /// Rows in the order of tags, as pack_row makes them.
  /// Interpolates with the weights of the point; labels take the corner of the largest weight, the
  /// first vertex of equal ones; normals get length 1. Vertices that repair made of nothing count
  /// for nothing; a point that has no others gets zeros.
  /// @throws CorruptionError  not as many points came as should
  void finish(store::RowSpool& rows, std::uint64_t buffer_bytes, Progress* progress);

 private:
  AttributeFile& attributes_;
  std::uint64_t points_, seen_ = 0;
  AttributeColumns columns_;
  AttributeMixer mixer_;
  store::RowJoin join_;
};

/// Attributes of input faces and their corners, for the faces of a grid.
///
/// A face of the grid gets what the input face under its centre has. A corner gets what its own
/// place has, seen from within the face: so a vertex on a seam has the value of the right side.
/// Where texture coordinates at the corner do not continue those at the centre, the face lies
/// across a seam; there the input face under the centre is continued to the corner
/// (docs/design/attributes.md).
///
/// @param specs                   that are wanted; those of vertices are passed over
/// @param face_rows, corner_rows  filled in the order of the grid's faces; null where there are no
///                                such attributes
void sample_face_attributes(const MapFiles& files, AttributeFile& attributes,
                            std::span<const AttributeSpec> specs, const DyadicGrid& grid,
                            const ResampleOptions& options, MemoryBudget& budget,
                            store::RowSpool* face_rows, store::RowSpool* corner_rows);

}  // namespace remaps::resample
