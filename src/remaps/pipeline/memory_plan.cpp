#include "remaps/pipeline/memory_plan.h"

#include <algorithm>
#include <string>

#include "remaps/base/errors.h"

namespace remaps::pipeline {
namespace {

constexpr std::uint64_t kLeastBudget = std::uint64_t{24} << 20;
constexpr std::uint64_t kBytesPerPoint = 80;  // decoded, carried and packed
/// Faces that are simplified in one piece at most: random access makes larger pieces slower than
/// sweeps, and sweeps cost nothing in quality.
constexpr std::uint64_t kMostInCore = 400'000;
/// Faces of a segment: corners, and links of 16 slots a record, must be numbered in 32 bits.
/// Samples err: cuts may come out some times larger.
constexpr std::uint64_t kMostDomainFaces = std::uint64_t{1} << 26;
constexpr std::uint64_t kCacheSegment = 20'000;  // faces: a segment that stays in a core's cache

}  // namespace

MemoryPlan plan_memory(std::uint64_t budget_bytes, unsigned threads, std::uint64_t domain_buffer,
                       std::uint64_t map_buffer) {
  if (budget_bytes < kLeastBudget) {
    throw BudgetError("--memory " + std::to_string(budget_bytes >> 20) +
                      "M is too little: the least is " + std::to_string(kLeastBudget >> 20) + "M");
  }
  if (domain_buffer > kMostDomainFaces) {
    throw BudgetError("--domain-buffer " + std::to_string(domain_buffer) +
                      " is too much: the most is " + std::to_string(kMostDomainFaces) + " faces");
  }
  MemoryPlan plan;
  plan.budget_bytes = budget_bytes;
  const std::uint64_t domain_share = budget_bytes / 2;
  plan.domain_buffer = domain_buffer != 0 ? domain_buffer
                                          : std::clamp<std::uint64_t>(domain_share / kBytesPerFace,
                                                                      2'000, kMostInCore);
  // Samples err by up to a factor of 2; at least three segments in work and waiting have room.
  const std::uint64_t largest = 2 * kBytesPerFace;
  plan.segment_faces =
      std::min({plan.domain_buffer / 2, domain_share / (4 * largest), kCacheSegment});
  plan.segment_faces = std::max<std::uint64_t>(plan.segment_faces, 500);
  const std::uint64_t fit = domain_share / (largest * plan.segment_faces);
  plan.sweep_threads = static_cast<unsigned>(std::clamp<std::uint64_t>(fit, 2, threads + 1ull) - 1);
  plan.map_buffer = map_buffer != 0 ? map_buffer
                                    : std::clamp<std::uint64_t>(
                                          budget_bytes / 16 / (kBytesPerPoint * (2 * threads + 1)),
                                          2'000, 200'000);
  plan.bucket_bytes = budget_bytes / 8;
  plan.cache_bytes = budget_bytes / 4;
  return plan;
}

}  // namespace remaps::pipeline
