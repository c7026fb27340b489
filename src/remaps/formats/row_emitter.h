#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "remaps/mesh/attributes.h"

namespace remaps {

/// Gathers rows of attributes into chunks for a sink; see ChunkEmitter.
class RowEmitter {
 public:
  RowEmitter(std::size_t channels, AttributeSink sink) : sink_(sink) {
    most_ =
        std::clamp<std::size_t>(kMostValues / std::max<std::size_t>(channels, 1), 1, kMostRows) *
        channels;
    rows_.reserve(most_);
  }

  void push(std::span<const double> row) {
    rows_.insert(rows_.end(), row.begin(), row.end());
    if (rows_.size() >= most_) flush();
  }
  void flush() {
    if (!rows_.empty()) sink_(rows_);
    rows_.clear();
  }

 private:
  static constexpr std::size_t kMostRows = 4096;
  static constexpr std::size_t kMostValues = 1 << 14;

  AttributeSink sink_;
  std::size_t most_;
  std::vector<double> rows_;
};

}  // namespace remaps
