#pragma once

#include <cstddef>
#include <functional>

namespace remaps {

/// Runs n independent tasks on worker threads and commits their results in order.
///
/// `work(i, lane)` may run on any thread, in any order; lanes count from 0 to `threads` - 1 and no
/// two tasks run in one lane at a time, so that scratch memory can be kept per lane. It returns a
/// closure that is called, one at a time and in the order of i, to commit the result. At most
/// `threads` + 1 results wait for their turn, so memory is bounded. The first exception (lowest i)
/// of work or commit stops everything and is thrown on. With one thread everything runs on the
/// caller's.
using Commit = std::function<void()>;
void run_ordered(std::size_t n, unsigned threads,
                 const std::function<Commit(std::size_t i, unsigned lane)>& work);

}  // namespace remaps
