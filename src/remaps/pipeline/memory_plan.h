#pragma once

#include <cstdint>

namespace remaps::pipeline {

/// Memory that simplifying takes a face of a segment: the segment, its patch and queue, the log and
/// its packed copy. Measured, with some reserve.
inline constexpr std::uint64_t kBytesPerFace = 300;

/// How a run's memory is shared out. All sizes follow from the budget; --domain-buffer and
/// --map-buffer overrule theirs. What decides the bytes of the result (domain_buffer,
/// segment_faces) does not depend on the number of threads.
struct MemoryPlan {
  std::uint64_t budget_bytes = 0;
  std::uint64_t domain_buffer = 0;  ///< faces: the largest segment; a level that fits is the last
  std::uint64_t map_buffer = 0;     ///< points a worker thread
  std::uint64_t segment_faces =
      0;                           ///< what cuts aim at, well below domain_buffer since samples err
  std::uint64_t bucket_bytes = 0;  ///< write buffers of one stage
  std::uint64_t cache_bytes = 0;   ///< vertex cache while faces are joined
  unsigned sweep_threads = 1;      ///< threads whose segments fit beside each other
};

/// @param domain_buffer, map_buffer  0: chosen here
/// @throws BudgetError  says the least budget that would do
MemoryPlan plan_memory(std::uint64_t budget_bytes, unsigned threads, std::uint64_t domain_buffer,
                       std::uint64_t map_buffer);

}  // namespace remaps::pipeline
