#pragma once

#include <cstdint>
#include <filesystem>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/pipeline/ingest.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/report.h"
#include "remaps/repair/level_repair.h"

namespace remaps::pipeline {

/// What repair does beyond what it must.
struct RepairChoices {
  std::uint64_t min_component = 0;  ///< faces; smaller components are dropped
  std::uint64_t fill_holes = 0;     ///< edges; holes of at most so many are filled

  bool any() const { return min_component > 1 || fill_holes > 0; }
};

/// Memory for the segments of a level that are worked on beside each other.
Reservation reserve_lanes(const DomainLevel& level, const MemoryPlan& plan, MemoryBudget& budget);

/// Finds what keeps the ingested surface from being a manifold, and puts a repaired level in the
/// place of the ingested one; one that cannot be oriented stays as it is. Phase "repair".
/// @param repairs  gets the counts
repair::Findings repair_input(Ingested& ingested, const RepairChoices& choices,
                              const MemoryPlan& plan, const std::filesystem::path& temp_dir,
                              MemoryBudget& budget, Progress& progress, Repairs& repairs);

}  // namespace remaps::pipeline
