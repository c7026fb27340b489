#pragma once

#include <algorithm>
#include <filesystem>
#include <thread>

#include "remaps/base/memory_budget.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/query.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {

/// What every question to a bundle needs: the bundle, threads, memory, a place for files.
struct QueryRun {
  explicit QueryRun(const QueryOptions& options)
      : bundle(options.bundle),
        threads(options.threads != 0 ? options.threads
                                     : std::max(1u, std::thread::hardware_concurrency())),
        plan(plan_memory(options.memory_bytes, threads, 0, 0)),
        budget(plan.budget_bytes),
        temp(options.temp_dir.empty() ? std::filesystem::temp_directory_path() : options.temp_dir) {
  }

  const Bundle bundle;
  const unsigned threads;
  const MemoryPlan plan;
  MemoryBudget budget;
  const store::TempDir temp;
};

}  // namespace remaps::pipeline
