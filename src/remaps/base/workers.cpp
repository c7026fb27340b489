#include "remaps/base/workers.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace remaps {
namespace {

/// The state that the lanes of one run share. The mutex guards everything.
class OrderedRun {
 public:
  OrderedRun(std::size_t n, unsigned threads,
             const std::function<Commit(std::size_t, unsigned)>& work)
      : n_(n), window_(threads + std::size_t{1}), work_(work) {}

  void lane(unsigned lane) {
    std::unique_lock lock(mutex_);
    while (true) {
      turn_.wait(lock, [&] { return failed() || next_ == n_ || next_ < committed_ + window_; });
      if (failed() || next_ == n_) return;
      const std::size_t i = next_++;
      lock.unlock();
      Commit commit;
      std::exception_ptr error;
      try {
        commit = work_(i, lane);
      } catch (...) {
        error = std::current_exception();
      }
      lock.lock();
      ready_.emplace(i, std::make_pair(std::move(commit), error));
      commit_ready(lock);
    }
  }

  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  bool failed() const { return error_ != nullptr; }

  /// Commits what is next in order, one lane at a time.
  void commit_ready(std::unique_lock<std::mutex>& lock) {
    if (committing_) return;
    committing_ = true;
    while (!failed() && !ready_.empty() && ready_.begin()->first == committed_) {
      auto [commit, error] = std::move(ready_.begin()->second);
      ready_.erase(ready_.begin());
      lock.unlock();
      try {
        if (error) std::rethrow_exception(error);
        commit();
        commit = nullptr;
      } catch (...) {
        error = std::current_exception();
      }
      lock.lock();
      if (error) error_ = error;
      ++committed_;
      turn_.notify_all();
    }
    committing_ = false;
    if (failed()) turn_.notify_all();
  }

  const std::size_t n_;
  const std::size_t window_;
  const std::function<Commit(std::size_t, unsigned)>& work_;
  std::mutex mutex_;
  std::condition_variable turn_;
  std::size_t next_ = 0;
  std::size_t committed_ = 0;
  bool committing_ = false;
  std::map<std::size_t, std::pair<Commit, std::exception_ptr>> ready_;
  std::exception_ptr error_;
};

}  // namespace

void run_ordered(std::size_t n, unsigned threads,
                 const std::function<Commit(std::size_t, unsigned)>& work) {
  const auto lanes = static_cast<unsigned>(std::min<std::size_t>(std::max(threads, 1u), n));
  if (lanes <= 1) {
    for (std::size_t i = 0; i < n; ++i) work(i, 0)();
    return;
  }
  OrderedRun run(n, lanes, work);
  {
    std::vector<std::jthread> helpers;
    for (unsigned lane = 1; lane < lanes; ++lane)
      helpers.emplace_back([&, lane] { run.lane(lane); });
    run.lane(0);
  }
  run.rethrow();
}

}  // namespace remaps
