#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "remaps/base/function_ref.h"

namespace remaps {

/// Gathers elements into chunks for a sink. `flush` sends the rest; destroyed without, the rest is
/// lost, as it should be when an error ends the pass.
template <class T>
class ChunkEmitter {
 public:
  using Sink = FunctionRef<void(std::span<const T>)>;
  static constexpr std::size_t kChunk = 8192;

  explicit ChunkEmitter(Sink sink) : sink_(sink) { chunk_.reserve(kChunk); }

  void push(const T& element) {
    chunk_.push_back(element);
    if (chunk_.size() == kChunk) flush();
  }
  void flush() {
    if (!chunk_.empty()) sink_(chunk_);
    chunk_.clear();
  }

 private:
  Sink sink_;
  std::vector<T> chunk_;
};

}  // namespace remaps
