#pragma once

#include <filesystem>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/attributes.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/report.h"

namespace remaps::pipeline {

struct OutputJob {
  std::filesystem::path output;  ///< under its temporary name
  std::filesystem::path temp_dir;
  unsigned level = 5;
  unsigned threads = 1;
  bool fit = false;
  bool measure = true;
  std::uint64_t samples = 1'000'000;
  AttributeChoice attributes;  ///< of those that the bundle has
};

/// Resamples a bundle to a mesh file and measures it. Fills the report's parts on output, error,
/// quality and the seconds of these phases.
void write_output(const Bundle& bundle, const OutputJob& job, const MemoryPlan& plan,
                  MemoryBudget& budget, Progress& progress, Report& report);

}  // namespace remaps::pipeline
