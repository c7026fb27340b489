#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "remaps/base/function_ref.h"

namespace remaps {

/// The queue between the two threads of run_overlapped.
template <class Chunk>
class ChunkQueue {
 public:
  struct Stopped {};
  static constexpr std::size_t kDepth = 4;

  /// Takes the content of a chunk, and leaves that of a used one. Waits while the queue is full.
  /// @throws Stopped  nobody takes any more
  void send(Chunk& chunk) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stopped_ || full_.size() < kDepth; });
    if (stopped_) throw Stopped();
    full_.push_back(std::move(chunk));
    chunk = Chunk();
    if (!used_.empty()) {
      chunk = std::move(used_.back());
      used_.pop_back();
    }
    changed_.notify_all();
  }
  /// Waits for a chunk, and gives the former one back.
  /// @return  false after the last one
  bool receive(Chunk& chunk) {
    std::unique_lock lock(mutex_);
    if (used_.size() < kDepth) used_.push_back(std::move(chunk));
    changed_.wait(lock, [&] { return ended_ || !full_.empty(); });
    if (full_.empty()) return false;
    chunk = std::move(full_.front());
    full_.pop_front();
    changed_.notify_all();
    return true;
  }
  void end() {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  void stop() {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;  // guards everything
  std::condition_variable changed_;
  std::deque<Chunk> full_;
  std::vector<Chunk> used_;
  bool ended_ = false;
  bool stopped_ = false;
};

/// Makes chunks on one thread while they are used on the caller's, in the same order.
///
/// `produce(send)` calls send(chunk) for each; the chunk's content is taken and it may be filled
/// again. `consume(chunk)` runs on the caller's thread. At most ChunkQueue::kDepth + 2 chunks
/// exist. An exception of consume stops produce and is thrown on; one of produce is thrown on after
/// what it sent before was consumed. Without `overlap` all runs on the caller's thread.
template <class Chunk>
void run_overlapped(bool overlap, FunctionRef<void(FunctionRef<void(Chunk&)>)> produce,
                    FunctionRef<void(const Chunk&)> consume) {
  if (!overlap) {
    produce([&](Chunk& chunk) { consume(chunk); });
    return;
  }
  ChunkQueue<Chunk> queue;
  std::exception_ptr error;
  std::jthread producer([&] {
    try {
      produce([&](Chunk& chunk) { queue.send(chunk); });
    } catch (const typename ChunkQueue<Chunk>::Stopped&) {
    } catch (...) {
      error = std::current_exception();
    }
    queue.end();
  });
  try {
    Chunk chunk;
    while (queue.receive(chunk)) consume(chunk);
  } catch (...) {
    queue.stop();
    producer.join();
    throw;
  }
  producer.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace remaps
