#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps::simplify {

/// Indexed 4-ary min-heap of vertices by cost; equal costs leave in order of index, so that runs
/// are alike.
class RemovalQueue {
 public:
  void reset(std::size_t vertices) {
    heap_.clear();
    place_.assign(vertices, kNoIndex);
  }
  bool empty() const { return heap_.empty(); }
  std::size_t size() const { return heap_.size(); }
  bool contains(LocalIndex v) const { return place_[v] != kNoIndex; }
  LocalIndex top() const { return heap_.front().vertex; }
  float top_cost() const { return heap_.front().cost; }
  float cost(LocalIndex v) const { return heap_[place_[v]].cost; }

  /// Inserts v or changes its cost.
  void set(LocalIndex v, float cost) {
    std::uint32_t at = place_[v];
    if (at == kNoIndex) {
      at = static_cast<std::uint32_t>(heap_.size());
      heap_.push_back({cost, v});
      rise(at);
    } else {
      const bool less = cost < heap_[at].cost;
      heap_[at].cost = cost;
      less ? rise(at) : sink(at);
    }
  }
  void erase(LocalIndex v) {
    const std::uint32_t at = place_[v];
    if (at == kNoIndex) return;
    place_[v] = kNoIndex;
    const Entry last = heap_.back();
    heap_.pop_back();
    if (at == heap_.size()) return;
    heap_[at] = last;
    place_[last.vertex] = at;
    rise(at);
    sink(place_[last.vertex]);
  }

 private:
  struct Entry {
    float cost;
    LocalIndex vertex;
    bool operator<(const Entry& b) const {
      return cost < b.cost || (cost == b.cost && vertex < b.vertex);
    }
  };

  void rise(std::uint32_t at) {
    const Entry entry = heap_[at];
    while (at > 0) {
      const std::uint32_t parent = (at - 1) / 4;
      if (!(entry < heap_[parent])) break;
      move(at, heap_[parent]);
      at = parent;
    }
    move(at, entry);
  }
  void sink(std::uint32_t at) {
    const Entry entry = heap_[at];
    const auto size = static_cast<std::uint32_t>(heap_.size());
    while (true) {
      const std::uint32_t first = 4 * at + 1;
      if (first >= size) break;
      std::uint32_t least = first;
      for (std::uint32_t child = first + 1; child < first + 4 && child < size; ++child) {
        if (heap_[child] < heap_[least]) least = child;
      }
      if (!(heap_[least] < entry)) break;
      move(at, heap_[least]);
      at = least;
    }
    move(at, entry);
  }
  void move(std::uint32_t at, const Entry& entry) {
    heap_[at] = entry;
    place_[entry.vertex] = at;
  }

  std::vector<Entry> heap_;
  std::vector<std::uint32_t> place_;
};

}  // namespace remaps::simplify
