#include "remaps/base/errors.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <stdexcept>

namespace remaps {
namespace {

TEST(Narrow, KeepsValuesThatFit) {
  EXPECT_EQ(narrow<std::uint8_t>(std::uint64_t{255}), 255);
  EXPECT_EQ(narrow<std::int8_t>(-128), -128);
  EXPECT_EQ(narrow<std::uint32_t>(std::int64_t{0xFFFFFFFF}), 0xFFFFFFFFu);
}

TEST(Narrow, ThrowsForValuesThatDoNotFit) {
  EXPECT_THROW(narrow<std::uint8_t>(256), std::range_error);
  EXPECT_THROW(narrow<std::uint64_t>(-1), std::range_error);
  EXPECT_THROW(narrow<std::int8_t>(128u), std::range_error);
  EXPECT_THROW(narrow<std::int32_t>(std::uint32_t{0x80000000}), std::range_error);
  EXPECT_THROW(narrow<std::uint32_t>(std::numeric_limits<std::uint64_t>::max()), std::range_error);
}

}  // namespace
}  // namespace remaps
