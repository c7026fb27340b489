#include "remaps/base/geometry.h"

#include <gtest/gtest.h>

namespace remaps {
namespace {

TEST(Box3, IsEmptyUntilTheFirstPoint) {
  Box3 box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(box.diagonal(), 0);
  box.add({1, 2, 3});
  EXPECT_FALSE(box.empty());
  box.add({4, 6, 3});
  EXPECT_DOUBLE_EQ(box.diagonal(), 5);
}

}  // namespace
}  // namespace remaps
