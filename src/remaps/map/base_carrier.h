#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/map/level_map.h"

namespace remaps::map {

/// Receives vertices on the base; called on one thread at a time, in an order that does not depend
/// on the number of threads.
using BaseSink = std::function<void(VertexId vertex, const FacePoint& on_base)>;

/// Carries what the sweeps removed to the base, each vertex through all levels at once.
///
/// The vertices that one segment removed lie close together, and so do the segments of the next
/// levels that they pass through: those that were used last are kept in memory. Nothing goes
/// through files between levels.
class BaseCarrier {
 public:
  /// @param logs         (levels) sealed, first level first; must outlive the carrier
  /// @param cache_bytes  memory for segments of the levels above the first, reserved from the
  /// budget. The segments in use are kept whatever it says
  BaseCarrier(std::span<const store::SectionFile* const> logs, std::uint64_t cache_bytes,
              MemoryBudget& budget);

  /// Sends every removed vertex to the sink.
  /// @throws CorruptionError  a log is damaged, or leads to what does not exist
  /// Cost: each level is read once and then as often as a segment falls out of the cache; a step
  /// through a record for each record that touches the vertex's face.
  void carry_removed(const CarryOptions& options, const BaseSink& sink);

 private:
  struct Vertex {
    FaceLink at;
    double u, v;
    VertexId id;
  };
  struct Entry {
    std::size_t level, segment;
    std::uint64_t used;
    std::shared_ptr<const LoadedSegment> loaded;
  };

  std::shared_ptr<const LoadedSegment> get(std::size_t level, std::size_t segment);
  void carry_on(std::size_t level, std::span<Vertex> vertices);
  std::vector<Vertex> carry_segment(std::size_t level, std::size_t segment);

  std::vector<LevelMap> levels_;
  std::uint64_t cache_bytes_;
  Reservation reservation_;
  std::mutex mutex_;  // guards what follows
  std::uint64_t clock_ = 0;
  std::uint64_t held_bytes_ = 0;
  std::vector<Entry> cache_;
};

}  // namespace remaps::map
