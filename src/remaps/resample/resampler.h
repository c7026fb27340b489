#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/map/level_map.h"
#include "remaps/mesh/base_mesh.h"
#include "remaps/mesh/indexed_stream.h"
#include "remaps/resample/dyadic_grid.h"
#include "remaps/store/section_file.h"

namespace remaps::resample {

struct ResampleOptions {
  map::CarryOptions carry;
  std::uint64_t buffer_bytes =
      32 << 20;  ///< for the write buffers of one stage and one output block; at most half the
                 ///< budget that is left beside the segments in work
  std::filesystem::path temp_dir;  ///< holds 25 bytes a point at a time, 28 bytes a result (16)
  bool as_floats = false;          ///< positions are rounded to floats on the way
  Vec3 origin;                     ///< added to the positions of the tiles
};

/// The sealed files of a map, first level first.
struct MapFiles {
  std::vector<const store::SectionFile*> logs;
  const store::SectionFile* tiles = nullptr;
};

/// Fills points in: called once with a function that adds a point of the base mesh.
using PointProducer = std::function<void(const std::function<void(const map::TaggedPoint&)>& add)>;
/// Receives, tile by tile, the points that lie on it: at.face and at.u, at.v refer to the tile. One
/// thread at a time.
using TileSink = std::function<void(std::uint32_t number, const Tile& tile,
                                    std::span<const map::TaggedPoint> points)>;

/// Pulls points of the base mesh back to the input, through all levels in reverse.
/// Cost: a pass over the points a level; every log and tile that is touched is read once.
/// @throws BudgetError  the map's largest segment does not fit; says what would do
void pull_back(const MapFiles& files, const PointProducer& points, const ResampleOptions& options,
               MemoryBudget& budget, const TileSink& sink);

/// Looks over the shoulder of resample_positions: what else there is to know of the points.
class SampleObserver {
 public:
  virtual ~SampleObserver() = default;
  /// Before the first point.
  /// @param buffer_bytes  that it may take for write buffers
  virtual void begin(std::uint64_t buffer_bytes) = 0;
  /// As a TileSink: tags are numbers of vertices.
  virtual void see(const Tile& tile, std::span<const map::TaggedPoint> points) = 0;
  /// After the last point, before the first position; the memory of the map is free again.
  virtual void end() = 0;
};

/// Resamples the surface: finds every vertex of `grid` on the input and sends the positions in the
/// order of the grid. The output may be larger than memory. The points are made where they are
/// first needed and pass through the disk once a level.
/// @param observer  may be null
/// @throws BudgetError  the map's largest segment does not fit; says what would do
void resample_positions(const MapFiles& files, const DyadicGrid& grid,
                        const ResampleOptions& options, MemoryBudget& budget, PositionSink sink,
                        SampleObserver* observer = nullptr);

/// Sends the faces of a grid in order: pure arithmetic.
void stream_faces(const DyadicGrid& grid, Progress* progress, IndexSink sink);

/// Position of a point on a tile, relative to the tile's origin.
Vec3 position_on_tile(const Tile& tile, const map::FacePoint& at);

}  // namespace remaps::resample
