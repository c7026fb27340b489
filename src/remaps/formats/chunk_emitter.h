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

  explicit ChunkEmitter(Sink sink) : sink_(sink), chunk_(kChunk) {}

  void push(const T& element) {
    chunk_[filled_] = element;
    keep(1);
  }
  /// Room for at least one element, to be filled from its start and then kept.
  std::span<T> room() { return std::span<T>(chunk_).subspan(filled_); }
  void keep(std::size_t n) {
    filled_ += n;
    if (filled_ == kChunk) flush();
  }
  void flush() {
    if (filled_ > 0) sink_(std::span<const T>(chunk_).first(filled_));
    filled_ = 0;
  }

 private:
  Sink sink_;
  std::vector<T> chunk_;
  std::size_t filled_ = 0;
};

}  // namespace remaps
