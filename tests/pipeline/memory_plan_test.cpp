#include "remaps/pipeline/memory_plan.h"

#include <gtest/gtest.h>

#include <string>

#include "remaps/base/errors.h"

namespace remaps::pipeline {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

TEST(MemoryPlan, RefusesLessThanTheLeastAndSaysIt) {
  EXPECT_NO_THROW(plan_memory(24 * kMiB, 1, 0, 0));
  try {
    plan_memory(24 * kMiB - 1, 1, 0, 0);
    FAIL() << "planned";
  } catch (const BudgetError& error) {
    EXPECT_NE(std::string(error.what()).find("24M"), std::string::npos) << error.what();
  }
}

TEST(MemoryPlan, SharesOutNoMoreThanThereIs) {
  for (const std::uint64_t mib : {24u, 64u, 256u, 4096u, 1u << 20}) {
    for (const unsigned threads : {1u, 2u, 8u, 64u}) {
      const MemoryPlan plan = plan_memory(mib * kMiB, threads, 0, 0);
      EXPECT_EQ(plan.budget_bytes, mib * kMiB);
      EXPECT_LE(2 * plan.bucket_bytes + plan.cache_bytes, plan.budget_bytes / 2);
      EXPECT_GE(plan.domain_buffer, 2'000u);
      EXPECT_GE(plan.map_buffer, 2'000u);
      EXPECT_GT(plan.segment_faces, 0u);
      EXPECT_LE(2 * plan.segment_faces, plan.domain_buffer);
    }
  }
}

TEST(MemoryPlan, CutsAlikeForAnyNumberOfThreads) {
  // Where the surface is cut decides the bytes of the result; threads must not.
  for (const std::uint64_t mib : {24u, 64u, 256u, 4096u}) {
    for (const std::uint64_t domain_buffer : {0u, 2000u, 50'000u}) {
      const MemoryPlan one = plan_memory(mib * kMiB, 1, domain_buffer, 0);
      EXPECT_EQ(one.sweep_threads, 1u);
      for (const unsigned threads : {2u, 3u, 8u, 64u}) {
        const MemoryPlan plan = plan_memory(mib * kMiB, threads, domain_buffer, 0);
        EXPECT_EQ(plan.domain_buffer, one.domain_buffer) << mib << " MiB, " << threads;
        EXPECT_EQ(plan.segment_faces, one.segment_faces) << mib << " MiB, " << threads;
        EXPECT_GE(plan.sweep_threads, 1u);
        EXPECT_LE(plan.sweep_threads, threads);
      }
    }
  }
}

/// Inside a segment corners and links have 32 bits.
TEST(MemoryPlan, RefusesADomainBufferBeyondLocalIndices) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 26;
  EXPECT_EQ(plan_memory(1024 * kMiB, 1, kMost, 0).domain_buffer, kMost);
  EXPECT_THROW(plan_memory(1024 * kMiB, 1, kMost + 1, 0), BudgetError);
  EXPECT_THROW(plan_memory(1024 * kMiB, 1, std::uint64_t{1} << 40, 0), BudgetError);
}

TEST(MemoryPlan, TakesTheBuffersThatTheUserStates) {
  const MemoryPlan plan = plan_memory(256 * kMiB, 2, 400'000, 10'000);
  EXPECT_EQ(plan.domain_buffer, 400'000u);
  EXPECT_EQ(plan.map_buffer, 10'000u);
}

}  // namespace
}  // namespace remaps::pipeline
