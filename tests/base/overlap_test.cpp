#include "remaps/base/overlap.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace remaps {
namespace {

using Chunk = std::vector<int>;
using Send = FunctionRef<void(Chunk&)>;

/// (overlap)
class RunOverlapped : public testing::TestWithParam<bool> {};

void send_numbers(Send send, int chunks) {
  Chunk chunk;
  for (int i = 0; i < chunks; ++i) {
    chunk.assign(static_cast<std::size_t>(i % 7), i);
    send(chunk);
  }
}

TEST_P(RunOverlapped, KeepsTheOrder) {
  for (const int chunks : {0, 1, 3, 4, 5, 2000}) {
    int next = 0;
    const auto caller = std::this_thread::get_id();
    run_overlapped<Chunk>(
        GetParam(), [&](Send send) { send_numbers(send, chunks); },
        [&](const Chunk& chunk) {
          ASSERT_EQ(std::this_thread::get_id(), caller);
          ASSERT_EQ(chunk, Chunk(static_cast<std::size_t>(next % 7), next));
          ++next;
        });
    EXPECT_EQ(next, chunks);
  }
}

TEST_P(RunOverlapped, StopsTheProducerWhenTheConsumerThrows) {
  int sent = 0;
  EXPECT_THROW(run_overlapped<Chunk>(
                   GetParam(),
                   [&](Send send) {
                     Chunk chunk;
                     while (true) {
                       chunk.assign(1, sent++);
                       send(chunk);
                     }
                   },
                   [&](const Chunk& chunk) {
                     if (chunk[0] == 5) throw std::range_error("five");
                   }),
               std::range_error);
  EXPECT_LE(sent, 5 + 1 + int(ChunkQueue<Chunk>::kDepth) + 1);
}

TEST_P(RunOverlapped, ThrowsWhatTheProducerThrewAfterItsChunks) {
  int seen = 0;
  EXPECT_THROW(run_overlapped<Chunk>(
                   GetParam(),
                   [&](Send send) {
                     send_numbers(send, 10);
                     throw std::range_error("bad input");
                   },
                   [&](const Chunk&) { ++seen; }),
               std::range_error);
  EXPECT_EQ(seen, 10);
}

INSTANTIATE_TEST_SUITE_P(Threads, RunOverlapped, testing::Bool());

}  // namespace
}  // namespace remaps
