#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"

namespace remaps::pipeline {

/// A set of vertices as runs of successive numbers: scanners leave gaps of many. 16 bytes a run.
class VertexRuns {
 public:
  /// @param v  above all before
  /// @param budget  of the memory beyond 1 MiB
  /// @throws BudgetError  the runs do not fit the budget
  void add(VertexId v, MemoryBudget& budget) {
    ++size_;
    if (!runs_.empty() && runs_.back().end == v) {
      ++runs_.back().end;
      return;
    }
    if (runs_.size() == runs_.capacity() && runs_.size() >= kFree) {
      Reservation larger = budget.reserve(2 * runs_.size() * sizeof(Run),
                                          "the list of vertices that are not finite");
      runs_.reserve(2 * runs_.size());
      reservation_ = std::move(larger);
    }
    runs_.push_back({v, v + 1});
  }

  bool contains(VertexId v) const {
    const auto after = std::upper_bound(runs_.begin(), runs_.end(), v,
                                        [](VertexId x, const Run& run) { return x < run.first; });
    return after != runs_.begin() && v < std::prev(after)->end;
  }
  std::uint64_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  /// The lowest ones, at most n.
  std::vector<VertexId> first(std::size_t n) const {
    std::vector<VertexId> found;
    for (const Run& run : runs_) {
      for (VertexId v = run.first; v < run.end && found.size() < n; ++v) found.push_back(v);
      if (found.size() == n) break;
    }
    return found;
  }

 private:
  struct Run {
    VertexId first, end;
  };
  static constexpr std::size_t kFree = std::size_t{1} << 16;  // runs in 1 MiB

  std::vector<Run> runs_;
  std::uint64_t size_ = 0;
  Reservation reservation_;
};

}  // namespace remaps::pipeline
