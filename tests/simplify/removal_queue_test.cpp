#include "remaps/simplify/removal_queue.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace remaps::simplify {
namespace {

TEST(RemovalQueue, BehavesLikeASortedSet) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    constexpr LocalIndex kVertices = 120;
    RemovalQueue queue;
    queue.reset(kVertices);
    std::set<std::pair<float, LocalIndex>> model;
    std::vector<float> cost(kVertices, -1);
    for (int step = 0; step < 5000; ++step) {
      const auto v = static_cast<LocalIndex>(random() % kVertices);
      if (random() % 4 == 0) {
        queue.erase(v);
        model.erase({cost[v], v});
        cost[v] = -1;
      } else {
        model.erase({cost[v], v});
        cost[v] = static_cast<float>(random() % 30);  // many equal costs
        queue.set(v, cost[v]);
        model.emplace(cost[v], v);
      }
      ASSERT_EQ(queue.size(), model.size());
      ASSERT_EQ(queue.empty(), model.empty());
      ASSERT_EQ(queue.contains(v), cost[v] >= 0);
      if (cost[v] >= 0) {
        ASSERT_EQ(queue.cost(v), cost[v]);
      }
      if (model.empty()) continue;
      ASSERT_EQ(queue.top(), model.begin()->second);
      ASSERT_EQ(queue.top_cost(), model.begin()->first);
    }
    while (!model.empty()) {
      ASSERT_EQ(queue.top(), model.begin()->second);
      queue.erase(queue.top());
      model.erase(model.begin());
    }
    EXPECT_TRUE(queue.empty());
  }
}

TEST(RemovalQueue, StartsEmptyAfterAReset) {
  RemovalQueue queue;
  queue.reset(3);
  queue.set(1, 5);
  queue.reset(2);
  EXPECT_TRUE(queue.empty());
  EXPECT_FALSE(queue.contains(1));
  queue.erase(1);
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace remaps::simplify
