#include "remaps/simplify/bucket_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <list>
#include <map>
#include <random>
#include <string>

namespace remaps::simplify {
namespace {

TEST(BucketQueue, BehavesLikeListsByKey) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    constexpr LocalIndex kVertices = 100;
    BucketQueue queue;
    queue.reset(kVertices, -20);
    std::map<std::int32_t, std::list<LocalIndex>> model;
    const auto forget = [&](LocalIndex v) {
      for (auto& [key, list] : model) list.remove(v);
      std::erase_if(model, [](const auto& entry) { return entry.second.empty(); });
    };
    for (int step = 0; step < 5000; ++step) {
      const auto v = static_cast<LocalIndex>(random() % kVertices);
      if (random() % 4 == 0) {
        queue.erase(v);
        forget(v);
      } else {
        const auto wanted = static_cast<std::int32_t>(random() % 1200) - 60;
        const std::int32_t key = std::clamp(wanted, -20, 1003);
        EXPECT_EQ(queue.clamped(wanted), key);
        queue.set(v, wanted);
        const auto at = model.find(key);
        const bool stays = at != model.end() && std::count(at->second.begin(), at->second.end(), v);
        if (!stays) {
          forget(v);
          model[key].push_back(v);
        }
      }
      ASSERT_EQ(queue.empty(), model.empty());
      if (model.empty()) continue;
      ASSERT_EQ(queue.top_key(), model.begin()->first);
      ASSERT_EQ(queue.top(), model.begin()->second.front());
    }
  }
}

TEST(BucketQueue, IsEmptyAfterReset) {
  BucketQueue queue;
  queue.reset(3, 0);
  queue.set(1, 5);
  queue.reset(3, 0);
  EXPECT_TRUE(queue.empty());
  EXPECT_FALSE(queue.contains(1));
}

}  // namespace
}  // namespace remaps::simplify
