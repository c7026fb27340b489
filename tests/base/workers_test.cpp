#include "remaps/base/workers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace remaps {
namespace {

using namespace std::chrono_literals;

/// Tasks of very different lengths, so that they finish out of order.
void idle(std::size_t i) {
  std::mt19937_64 random(i);
  std::this_thread::sleep_for(std::chrono::microseconds(random() % 300));
}

TEST(RunOrdered, CommitsEachTaskOnceInOrder) {
  for (const unsigned threads : {0u, 1u, 2u, 3u, 4u}) {
    for (const std::size_t n : {0u, 1u, 2u, 5u, 200u}) {
      SCOPED_TRACE(std::to_string(threads) + " threads, n = " + std::to_string(n));
      std::vector<std::size_t> committed;
      std::atomic<std::size_t> worked = 0;
      run_ordered(n, threads, [&](std::size_t i, unsigned) -> Commit {
        idle(i);
        ++worked;
        return [&, i] { committed.push_back(i); };
      });
      EXPECT_EQ(worked, n);
      ASSERT_EQ(committed.size(), n);
      for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(committed[i], i);
    }
  }
}

TEST(RunOrdered, RunsOneTaskAtATimeInALane) {
  for (const unsigned threads : {1u, 2u, 3u, 4u}) {
    std::vector<std::atomic<int>> in_lane(threads);
    std::atomic<bool> shared = false;
    std::atomic<unsigned> highest = 0;
    run_ordered(300, threads, [&](std::size_t i, unsigned lane) -> Commit {
      if (lane > highest) highest = lane;
      if (lane >= threads || ++in_lane[lane] != 1) shared = true;
      idle(i);
      if (lane < threads) --in_lane[lane];
      return [] {};
    });
    EXPECT_FALSE(shared) << threads << " threads";
    EXPECT_LT(highest, threads);
  }
}

TEST(RunOrdered, RunsAsManyTasksAtATimeAsThreads) {
  // Each task waits for the others to have started: this ends only if all run at once.
  std::atomic<int> started = 0;
  run_ordered(4, 4, [&](std::size_t, unsigned) -> Commit {
    ++started;
    while (started < 4) std::this_thread::yield();
    return [] {};
  });
  EXPECT_EQ(started, 4);
}

TEST(RunOrdered, CommitsOneAtATime) {
  std::atomic<int> committing = 0;
  std::atomic<bool> overlapped = false;
  run_ordered(100, 4, [&](std::size_t i, unsigned) -> Commit {
    idle(i);
    return [&, i] {
      if (++committing != 1) overlapped = true;
      idle(i);
      --committing;
    };
  });
  EXPECT_FALSE(overlapped);
}

TEST(RunOrdered, KeepsAtMostThreadsPlusOneResultsWaiting) {
  for (const unsigned threads : {2u, 3u, 4u}) {
    std::atomic<std::size_t> committed = 0;
    std::atomic<std::size_t> farthest = 0;
    run_ordered(120, threads, [&](std::size_t i, unsigned) -> Commit {
      const std::size_t ahead = i - std::min<std::size_t>(committed, i);
      std::size_t before = farthest;
      while (ahead > before && !farthest.compare_exchange_weak(before, ahead)) {
      }
      if (i % 20 == 0) std::this_thread::sleep_for(3ms);  // the others run ahead as far as they may
      return [&] { ++committed; };
    });
    EXPECT_EQ(committed, 120u);
    EXPECT_LE(farthest, threads + 1u) << threads << " threads";
  }
}

TEST(RunOrdered, ForgetsACommitOnceItRan) {
  const auto held = std::make_shared<int>(0);
  std::atomic<long> most = 0;
  run_ordered(60, 3, [&](std::size_t, unsigned) -> Commit {
    most = std::max<long>(most, held.use_count());
    return [held] {};
  });
  EXPECT_EQ(held.use_count(), 1);
  EXPECT_LE(most, 12);
}

TEST(RunOrdered, ThrowsTheLowestExceptionOfWork) {
  for (const unsigned threads : {1u, 2u, 3u, 4u}) {
    for (const std::size_t thrower : {0u, 1u, 17u, 39u}) {
      SCOPED_TRACE(std::to_string(threads) + " threads, thrower " + std::to_string(thrower));
      std::vector<std::size_t> committed;
      const auto run = [&] {
        run_ordered(40, threads, [&](std::size_t i, unsigned) -> Commit {
          if (i > thrower) idle(0);
          if (i == thrower) std::this_thread::sleep_for(2ms);  // later ones throw before it does
          if (i >= thrower) throw std::runtime_error(std::to_string(i));
          return [&, i] { committed.push_back(i); };
        });
      };
      try {
        run();
        ADD_FAILURE() << "nothing was thrown";
      } catch (const std::runtime_error& error) {
        EXPECT_EQ(error.what(), std::to_string(thrower));
      }
      EXPECT_EQ(committed.size(), thrower);
    }
  }
}

TEST(RunOrdered, ThrowsTheExceptionOfACommitAndCommitsNothingAfterIt) {
  for (const unsigned threads : {1u, 2u, 3u, 4u}) {
    std::vector<std::size_t> committed;
    std::atomic<std::size_t> worked = 0;
    const auto run = [&] {
      run_ordered(1000, threads, [&](std::size_t i, unsigned) -> Commit {
        ++worked;
        return [&, i] {
          if (i == 12) throw std::runtime_error("twelve");
          committed.push_back(i);
        };
      });
    };
    EXPECT_THROW(run(), std::runtime_error);
    EXPECT_EQ(committed.size(), 12u);
    EXPECT_LE(worked, 13u + threads + 1) << "work went on after the failure";
  }
}

TEST(RunOrdered, StaysOnTheCallersThreadWithOneThread) {
  const auto caller = std::this_thread::get_id();
  bool elsewhere = false;
  run_ordered(5, 1, [&](std::size_t, unsigned lane) -> Commit {
    elsewhere |= std::this_thread::get_id() != caller || lane != 0;
    return [&] { elsewhere |= std::this_thread::get_id() != caller; };
  });
  EXPECT_FALSE(elsewhere);
}

}  // namespace
}  // namespace remaps
