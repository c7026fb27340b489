#pragma once

#include <filesystem>
#include <optional>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/attributes.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/report.h"

namespace remaps::pipeline {

struct OutputJob {
  std::filesystem::path output;  ///< under its temporary name; level_path tells those of levels
  std::filesystem::path temp_dir;
  unsigned level = 5;                ///< the finest
  std::optional<unsigned> coarsest;  ///< write one mesh a level, from this one on
  unsigned threads = 1;
  bool fit = false;
  bool measure = true;
  std::uint64_t samples = 1'000'000;
  AttributeChoice attributes;  ///< of those that the bundle has
};

/// Resamples a bundle to a mesh file, or one a level, and measures the finest. The surface is
/// resampled once: coarser meshes have some of the finest one's vertices. With `fit` each is fitted
/// by itself. Fills the report's parts on output, error, quality and the seconds of these phases;
/// the paths of its outputs are those of the job.
void write_output(const Bundle& bundle, const OutputJob& job, const MemoryPlan& plan,
                  MemoryBudget& budget, Progress& progress, Report& report);

}  // namespace remaps::pipeline
