#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/pipeline/bundle.h"

namespace remaps::pipeline {

struct ReplayOptions {
  unsigned threads = 1;  ///< fewer are used where the budget does not hold so many segments
  std::uint64_t buffer_bytes = 0;  ///< write buffers for the faces that one level hands to the next
  std::filesystem::path temp_dir;
};

/// What the replay lets others see on its way, in an order that does not depend on the threads; one
/// call at a time.
struct ReplaySinks {
  std::function<void(std::uint32_t segment, const Tile& tile)> tile;
  std::function<void(const std::vector<VertexId>& removed)> removed;
};

struct ReplayedBundle {
  std::uint64_t records = 0;
  std::uint64_t segments = 0;
  std::uint64_t faces = 0;     ///< of the tiles
  std::vector<Triangle> base;  ///< input indices, in the order of base faces
};

/// Replays the whole bundle from the tiles to the base (see replay_records), and checks how the
/// levels fit together: each surviving face is handed to one face of the next level, whose `origin`
/// names it, and no face of the next level is without; at the last level survivors are the base
/// faces in order. Memory: a segment a thread; faces between levels go through a file.
/// @throws CorruptionError  says what is wrong and where; BudgetError: not one segment fits
ReplayedBundle replay_bundle(const Bundle& bundle, const ReplayOptions& options,
                             MemoryBudget& budget, Progress& progress, const ReplaySinks& sinks);

/// The number of threads for which `available` bytes do, at least one: `bytes_each` a thread, and
/// once more for what waits.
unsigned affordable_threads(unsigned wanted, std::uint64_t bytes_each, std::uint64_t available);

}  // namespace remaps::pipeline
