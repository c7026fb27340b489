#include "remaps/repair/parity_forest.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace remaps::repair {
namespace {

TEST(ParityForest, AgreesWithLabelsThatAreRewrittenAtEachUnion) {
  constexpr std::uint32_t kMembers = 60;
  std::mt19937_64 random(1);
  for (int round = 0; round < 200; ++round) {
    ParityForest forest;
    forest.grow(kMembers);
    std::vector<std::uint32_t> label(kMembers);
    std::vector<bool> turned(kMembers, false);
    for (std::uint32_t x = 0; x < kMembers; ++x) label[x] = x;
    for (int step = 0; step < 80; ++step) {
      const auto a = static_cast<std::uint32_t>(random() % kMembers);
      const auto b = static_cast<std::uint32_t>(random() % kMembers);
      const bool against = random() % 2 != 0;
      const bool agrees = label[a] != label[b] || (turned[a] ^ turned[b]) == against;
      ASSERT_EQ(forest.unite(a, b, against), agrees);
      if (label[a] == label[b]) continue;
      const bool turn = turned[a] ^ turned[b] ^ against;
      const std::uint32_t gone = label[b];
      for (std::uint32_t x = 0; x < kMembers; ++x) {
        if (label[x] != gone) continue;
        label[x] = label[a];
        turned[x] = turned[x] ^ turn;
      }
    }
    for (std::uint32_t a = 0; a < kMembers; ++a) {
      EXPECT_LE(forest.find(a).root, a) << "a root is the lowest of its set";
      for (std::uint32_t b = 0; b < kMembers; ++b) {
        ASSERT_EQ(forest.find(a).root == forest.find(b).root, label[a] == label[b]);
        if (label[a] != label[b]) continue;
        ASSERT_EQ(forest.find(a).turned ^ forest.find(b).turned, turned[a] ^ turned[b]);
      }
    }
  }
}

}  // namespace
}  // namespace remaps::repair
