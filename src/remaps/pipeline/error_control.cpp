#include "remaps/pipeline/error_control.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace remaps::pipeline {
namespace {

constexpr unsigned kFinest = 14;
constexpr std::uint64_t kFacesPerInputFace = 16;
/// What the error falls to at least, from one level to the next.
constexpr double kSteepest = 8;

double error_of(const ErrorAttempt& attempt, ErrorKind kind) {
  return kind == ErrorKind::kL2 ? attempt.l2 : attempt.max;
}

}  // namespace

std::uint64_t most_faces(const ErrorGoal& goal, std::uint64_t input_faces) {
  return goal.max_faces != 0 ? goal.max_faces : kFacesPerInputFace * input_faces;
}

bool write_within_error(const Bundle& bundle, OutputJob job, const ErrorGoal& goal,
                        const MemoryPlan& plan, MemoryBudget& budget, Progress& progress,
                        Report& report) {
  const std::uint64_t most = most_faces(goal, report.input_faces);
  const std::uint64_t base_faces = bundle.base().triangle.size();
  const auto fits = [&](unsigned level) {
    return level <= kFinest && base_faces <= most >> (2 * level);
  };
  for (unsigned level = 0; fits(level);) {
    job.level = level;
    write_output(bundle, job, plan, budget, progress, report);
    const SurfaceError& error = *report.error;
    report.attempts.push_back({report.base_vertices, level, report.output_faces, error.l2(),
                               std::max(error.max_forward, error.max_backward)});
    const double reached = error_of(report.attempts.back(), goal.kind);
    if (reached <= goal.most) return true;
    const double steps = std::log(reached / goal.most) / std::log(kSteepest);
    level += std::max(1u, static_cast<unsigned>(std::min(steps, double{kFinest})));
  }
  return false;
}

std::string describe_miss(const ErrorGoal& goal, const Report& report) {
  const char* const kind = goal.kind == ErrorKind::kL2 ? "L2" : "largest";
  const std::string asked = fmt::format(
      "no output of at most {} faces has a {} error of {:.3g} of "
      "the diagonal",
      most_faces(goal, report.input_faces), kind, goal.most);
  const auto best = std::min_element(report.attempts.begin(), report.attempts.end(),
                                     [&](const ErrorAttempt& a, const ErrorAttempt& b) {
                                       return error_of(a, goal.kind) < error_of(b, goal.kind);
                                     });
  if (best == report.attempts.end()) {
    return fmt::format("{}: the base alone has {}", asked, report.base_faces);
  }
  return fmt::format(
      "{}: the best has {:.3g}, with {} base vertices and {} faces at level {}; "
      "give --max-faces or --max-error more",
      asked, error_of(*best, goal.kind), best->base_vertices, best->faces, best->level);
}

}  // namespace remaps::pipeline
