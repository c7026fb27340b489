#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "remaps/mesh/attributes.h"

namespace remaps {

/// Gathers rows of attributes into chunks for a sink; see ChunkEmitter.
class RowEmitter {
 public:
  RowEmitter(std::size_t channels, AttributeSink sink) : sink_(sink) {
    rows_.reserve(kRows * channels);
    most_ = kRows * channels;
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
  /// Few enough that even hundreds of attributes fit.
  static constexpr std::size_t kRows = 512;

  AttributeSink sink_;
  std::size_t most_;
  std::vector<double> rows_;
};

}  // namespace remaps
