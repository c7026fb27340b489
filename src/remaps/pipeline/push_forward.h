#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "remaps/base/memory_budget.h"
#include "remaps/map/level_map.h"
#include "remaps/map/point_buckets.h"
#include "remaps/pipeline/bundle.h"

namespace remaps::pipeline {

struct PushOptions {
  map::CarryOptions carry;
  std::uint64_t buffer_bytes = 0;  ///< for the write buffers of two levels
  std::filesystem::path temp_dir;
};

/// Room for points by segments of a level, ready for push_forward.
std::unique_ptr<map::PointBuckets> make_points(const Bundle& bundle, std::size_t level,
                                               const PushOptions& options, MemoryBudget& budget);

/// Carries points of the input (in buckets of the first level) through all levels to the base: the
/// counterpart of resample::pull_back. `sink` gets them with at.face a base face; one call at a
/// time, in an order that does not depend on the threads. Only segments with points are read.
/// @throws CorruptionError  a log leads to a segment or face that does not exist
void push_forward(const Bundle& bundle, std::unique_ptr<map::PointBuckets> points,
                  const PushOptions& options, MemoryBudget& budget,
                  const std::function<void(const map::TaggedPoint&)>& sink);

}  // namespace remaps::pipeline
