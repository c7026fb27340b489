#include "remaps/pipeline/run_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

std::vector<std::string> names(const std::vector<PlannedPhase>& phases) {
  std::vector<std::string> result;
  for (const PlannedPhase& phase : phases) {
    EXPECT_GT(phase.weight, 0) << phase.name;
    result.push_back(phase.name);
  }
  return result;
}

TEST(RunPlan, ExpectsASweepForEachLevelThatDoesNotFit) {
  MemoryPlan plan;
  plan.domain_buffer = 400'000;
  plan.segment_faces = 20'000;
  const auto keep = [](std::uint64_t) { return 0.1; };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names(expect_sweeps(100'000, 100'000, 0, plan, keep)), (Names{"last sweep", "map"}));
  EXPECT_EQ(names(expect_sweeps(1'400'000, 1'400'000, 0, plan, keep)),
            (Names{"sweep 1", "sweep 2", "last sweep", "map"}));
  EXPECT_EQ(names(expect_sweeps(220'000, 1'400'000, 1, plan, keep)),
            (Names{"sweep 2", "last sweep", "map"}));
  // Whatever the buffers are, it ends.
  plan.domain_buffer = 10;
  plan.segment_faces = 1;
  EXPECT_LE(names(expect_sweeps(1ULL << 40, 1ULL << 40, 0, plan, keep)).size(), 40u);
}

TEST(RunPlan, ExpectsOfTheOutputWhatIsAskedFor) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(names(expect_output({1000, 1000, false, false, 0})), (Names{"resample"}));
  EXPECT_EQ(names(expect_output({1000, 1000, true, true, 10})),
            (Names{"resample", "fit", "measure"}));
}

class RunPlanTest : public test::TempFiles {};

/// In a real run each phase is one that the plan expected, and the run goes forward, without leaps
/// in the phases that have few steps.
TEST_F(RunPlanTest, HasEachPhaseOfARun) {
  const auto input = directory() / "in.ply";
  test::write_lists(test::scan(BaseShape::kIcosahedron, 20'000), input);
  RemeshOptions options = test::remesh_options(directory(), input);
  options.domain_buffer = 6000;
  options.measure = true;
  options.samples = 10'000;
  options.fit = true;
  options.memory_bytes = 64 << 20;
  std::vector<std::string> begun;
  Progress* running = nullptr;
  double before = -1;
  Progress progress([&](std::string_view phase, double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1 + 1e-12);
    const std::optional<RunShares> shares = running->run();
    ASSERT_TRUE(shares);
    EXPECT_GT(shares->present, 0) << phase;
    if (begun.empty() || begun.back() != phase) {
      begun.emplace_back(phase);
      before = -1;
    }
    EXPECT_GE(fraction, before) << phase;
    if (phase == "last sweep" || phase == "measure") {
      EXPECT_LT(fraction - std::max(before, 0.0), 0.5) << phase;
    }
    before = fraction;
    if (phase == "measure") {
      EXPECT_EQ(shares->later, 0);
    }
  });
  running = &progress;
  remesh(options, progress);
  ASSERT_GE(begun.size(), 7u);
  EXPECT_EQ(begun[0], "ingest");
  EXPECT_EQ(begun[1], "sweep 1");
  EXPECT_EQ((std::vector<std::string>(begun.end() - 5, begun.end())),
            (std::vector<std::string>{"last sweep", "map", "resample", "fit", "measure"}));
}

}  // namespace
}  // namespace remaps::pipeline
