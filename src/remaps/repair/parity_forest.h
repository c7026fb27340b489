#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace remaps::repair {

/// Disjoint sets whose members are, pair by pair, turned against each other or not: what the edges
/// of a surface tell of its faces' orientations. Memory: 4 B a member. At most 2^31 members.
class ParityForest {
 public:
  struct Place {
    std::uint32_t root = 0;  ///< the lowest member of the set
    bool turned = false;     ///< against the root

    friend bool operator==(const Place&, const Place&) = default;
  };

  std::size_t size() const { return word_.size(); }
  void clear() { word_.clear(); }
  /// Adds members, each a set of its own, up to `size`.
  void grow(std::size_t size) {
    while (word_.size() < size) word_.push_back(static_cast<std::uint32_t>(word_.size()) << 1);
  }

  Place find(std::uint32_t x) {
    bool turned = false;
    while (true) {
      const std::uint32_t word = word_[x];
      const std::uint32_t parent = word >> 1;
      if (parent == x) return {x, turned};
      // Point past the parent, so that paths stay short.
      const std::uint32_t above = word_[parent];
      word_[x] = above ^ (word & 1);
      turned ^= (word_[x] & 1) != 0;
      x = word_[x] >> 1;
    }
  }

  /// Says that a and b are turned against each other, or are not.
  /// @return  false when they are known to be the opposite; nothing changes then
  bool unite(std::uint32_t a, std::uint32_t b, bool turned) {
    Place at_a = find(a);
    Place at_b = find(b);
    const bool between = at_a.turned ^ at_b.turned ^ turned;
    if (at_a.root == at_b.root) return !between;
    if (at_a.root > at_b.root) std::swap(at_a, at_b);
    word_[at_b.root] = at_a.root << 1 | static_cast<std::uint32_t>(between);
    return true;
  }

 private:
  std::vector<std::uint32_t> word_;  // parent, and in the lowest bit whether turned against it
};

}  // namespace remaps::repair
