#pragma once

#include <algorithm>
#include <cstdint>

namespace remaps {

/// The bytes that a pass over a file goes through, as well as they are known when it begins.
struct PassRange {
  std::uint64_t begin = 0, end = 0;

  double fraction(std::uint64_t offset) const {
    if (offset <= begin) return 0;
    return offset >= end ? 1 : double(offset - begin) / double(end - begin);
  }
};

}  // namespace remaps
