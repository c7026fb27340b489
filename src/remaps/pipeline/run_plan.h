#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/base/progress.h"
#include "remaps/pipeline/memory_plan.h"

/// The phases that a run will have and how long each takes relative to the others, so that the time
/// left of the whole run can be told. Weights are nanoseconds of the machine that they were
/// measured on.
namespace remaps::pipeline {

/// Vertices of a mesh file, from its size alone: before it is read.
std::uint64_t guess_vertices(const std::filesystem::path& path);

PlannedPhase expect_ingest(std::uint64_t vertices);
/// "attributes": storing them, where there are any.
PlannedPhase expect_attributes(std::uint64_t vertices);
PlannedPhase expect_repair(std::uint64_t vertices);
PlannedPhase expect_count(std::uint64_t vertices);

/// "sweep N" of this level and those after it, "last sweep", "map".
/// @param vertices        of this level
/// @param input_vertices  that the map carries
/// @param levels_before   that were swept already
/// @param keep            the fraction of its vertices that a level of so many keeps
std::vector<PlannedPhase> expect_sweeps(std::uint64_t vertices, std::uint64_t input_vertices,
                                        unsigned levels_before, const MemoryPlan& plan,
                                        FunctionRef<double(std::uint64_t)> keep);

struct ExpectedOutput {
  std::uint64_t input_vertices = 0;
  std::uint64_t vertices = 0;
  bool fit = false;
  bool measure = false;
  std::uint64_t samples = 0;  ///< of the measurement, each way
};

/// "resample" and, if asked for, "fit" and "measure".
std::vector<PlannedPhase> expect_output(const ExpectedOutput& output);

}  // namespace remaps::pipeline
