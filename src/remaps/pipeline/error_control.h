#pragma once

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/output.h"
#include "remaps/pipeline/report.h"

namespace remaps::pipeline {

/// Faces that the output may have: those asked for, or 16 times the input's.
std::uint64_t most_faces(const ErrorGoal& goal, std::uint64_t input_faces);

/// Writes the output at the lowest level whose measured error meets the goal. Levels are tried from
/// below; those are passed over that would meet it only if the error fell to less than an eighth
/// from one level to the next (it falls to a quarter where the surface is smooth). Each attempt
/// goes into the report, whose output and error are those of the last. Cost: all levels tried
/// together a third more than the last.
/// @return  false if no level of at most so many faces meets it
bool write_within_error(const Bundle& bundle, OutputJob job, const ErrorGoal& goal,
                        const MemoryPlan& plan, MemoryBudget& budget, Progress& progress,
                        Report& report);

/// For people: what was asked, and the best that was reached.
std::string describe_miss(const ErrorGoal& goal, const Report& report);

}  // namespace remaps::pipeline
