#include "remaps/measure/sample_tree.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

namespace remaps {
namespace {

using Word = std::atomic_ref<std::uint64_t>;

double load(std::uint64_t& word) {
  return std::bit_cast<double>(Word(word).load(std::memory_order_relaxed));
}

/// Distances are not negative: as bits they have the order that they have as numbers.
void lower(std::uint64_t& word, double distance2) {
  const auto wanted = std::bit_cast<std::uint64_t>(distance2);
  std::uint64_t present = Word(word).load(std::memory_order_relaxed);
  while (wanted < present &&
         !Word(word).compare_exchange_weak(present, wanted, std::memory_order_relaxed)) {
  }
}

bool in_order(const SurfacePoint& a, const SurfacePoint& b) {
  if (a.word != b.word) return a.word < b.word;
  const Vec3 &p = a.position, &q = b.position;
  return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
}

/// Box3::add for finite points, without its care for others.
void enclose(const Vec3& p, Box3& box) {
  box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
  box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
}

double gap2(const Vec3& low, const Vec3& high, const Box3& box) {
  const auto gap = [](double a_low, double a_high, double b_low, double b_high) {
    return std::max({a_low - b_high, b_low - a_high, 0.0});
  };
  return norm2({gap(low.x, high.x, box.low.x, box.high.x),
                gap(low.y, high.y, box.low.y, box.high.y),
                gap(low.z, high.z, box.low.z, box.high.z)});
}

}  // namespace

SampleTree::SampleTree(std::vector<SurfacePoint> points, Repeats repeats)
    : points_(std::move(points)) {
  std::sort(points_.begin(), points_.end(), in_order);
  if (repeats == Repeats::drop) {
    const auto same = [](const SurfacePoint& a, const SurfacePoint& b) {
      return a.position == b.position;
    };
    points_.erase(std::unique(points_.begin(), points_.end(), same), points_.end());
  }
  const auto infinite = std::bit_cast<std::uint64_t>(std::numeric_limits<double>::infinity());
  for (SurfacePoint& point : points_) point.word = infinite;

  std::size_t below = points_.size();
  while (below > 1 || (below == 1 && levels_.empty())) {
    const std::size_t n = (below + kWidth - 1) / kWidth;
    std::vector<Node> nodes;
    nodes.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      Box3 box;
      for (std::size_t c = kWidth * i; c < std::min(below, kWidth * (i + 1)); ++c) {
        enclose(levels_.empty() ? points_[c].position : levels_.back()[c].low, box);
        enclose(levels_.empty() ? points_[c].position : levels_.back()[c].high, box);
      }
      nodes.push_back({box.low, box.high, infinite});
    }
    levels_.push_back(std::move(nodes));
    below = n;
  }
}

void SampleTree::bound_by(std::span<const Vec3> scouts, double scale) {
  if (points_.empty()) return;
  Box3 around;
  for (const Vec3& scout : scouts) around.add(scout);
  const FloatFrame frame(0.5 * around.low + 0.5 * around.high, scale);
  BoxTree tree;
  tree.build(static_cast<std::uint32_t>(scouts.size()),
             {frame.to_local(around.low), frame.to_local(around.high)}, [&](std::uint32_t i) {
               const Float3 dot = frame.to_local(scouts[i]);
               return FloatBox{dot, dot};
             });
  const float spread = spread_of(tree.box());
  // A scout may lie beside its triangle by a few roundings.
  const double largest = std::max(norm(around.low), norm(around.high));
  const double slack = 0x1p-46 * largest;

  std::uint32_t nearest = 0;
  for (std::size_t i = 0; i < levels_[0].size(); ++i) {
    Node& leaf = levels_[0][i];
    const Vec3 centre = 0.5 * leaf.low + 0.5 * leaf.high;
    const Float3 q = frame.to_local(centre);
    const float widest = std::max(spread, spread_of(q));
    double best = norm2(centre - scouts[nearest]);
    float reach2 = frame.reach2(best, widest);
    tree.search(q, reach2, [&](std::uint32_t scout) {
      const double distance2 = norm2(centre - scouts[scout]);
      if (distance2 >= best) return;
      best = distance2;
      nearest = scout;
      reach2 = frame.reach2(best, widest);
    });
    double bound = 0;
    for (std::size_t c = kWidth * i; c < std::min(points_.size(), kWidth * (i + 1)); ++c) {
      const double distance = norm(points_[c].position - scouts[nearest]) * (1 + 1e-12) + slack;
      points_[c].word = std::bit_cast<std::uint64_t>(distance * distance);
      bound = std::max(bound, distance * distance);
    }
    leaf.bound = std::bit_cast<std::uint64_t>(bound);
  }
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    const std::vector<Node>& below = levels_[level - 1];
    for (std::size_t i = 0; i < levels_[level].size(); ++i) {
      std::uint64_t bound = 0;
      for (std::size_t c = kWidth * i; c < std::min(below.size(), kWidth * (i + 1)); ++c) {
        bound = std::max(bound, below[c].bound);
      }
      levels_[level][i].bound = bound;
    }
  }
}

/// One piece against the tree.
class SampleTree::Search {
 public:
  Search(SampleTree& tree, const PieceTree& piece, Scratch& scratch)
      : tree_(tree), piece_(piece), scratch_(scratch) {}

  void run() {
    scratch_.found.assign(1, {piece_.boxes().box(), piece_.boxes().root()});
    visit(tree_.levels_.size() - 1, 0, 0, 1);
  }

 private:
  /// Compares a node with the boxes `first` to `last` - 1 that its parent has found.
  void visit(std::size_t level, std::size_t number, std::size_t first, std::size_t last) {
    Node& node = tree_.levels_[level][number];
    const FloatBox box{piece_.frame().to_local(node.low), piece_.frame().to_local(node.high)};
    const float spread = std::max(piece_.spread(), spread_of(box));
    const float reach2 = piece_.frame().reach2(load(node.bound), spread);
    const float fine = 2 * (box.extent() + 2 * std::sqrt(reach2));
    for (std::size_t i = first; i < last; ++i) {
      const Scratch::Found found = scratch_.found[i];
      if (box_distance2(box, found.box) <= reach2) {
        consider(found.box, found.entry, box, reach2, fine);
      }
    }
    const std::size_t end = scratch_.found.size();
    if (end > last) {
      const double bound =
          level == 0 ? visit_points(number, last, end) : visit_children(level, number, last, end);
      Word(node.bound).store(std::bit_cast<std::uint64_t>(bound), std::memory_order_relaxed);
    }
    scratch_.found.resize(last);
  }

  /// Keeps a box that is within reach of the node and no larger than `fine`; of a larger one, such
  /// children.
  void consider(const FloatBox& box, BoxTree::Entry entry, const FloatBox& node, float reach2,
                float fine) {
    if (entry.level == 0 || box.extent() <= fine) {
      scratch_.found.push_back({box, entry});
      return;
    }
    piece_.boxes().for_children(entry, node, reach2,
                                [&](const FloatBox& child, BoxTree::Entry child_entry) {
                                  consider(child, child_entry, node, reach2, fine);
                                });
  }

  /// @return  the largest bound of the children
  double visit_children(std::size_t level, std::size_t number, std::size_t first,
                        std::size_t last) {
    std::vector<Node>& children = tree_.levels_[level - 1];
    double bound = 0;
    for (std::size_t c = kWidth * number; c < std::min(children.size(), kWidth * (number + 1));
         ++c) {
      visit(level - 1, c, first, last);
      bound = std::max(bound, load(children[c].bound));
    }
    return bound;
  }

  /// @return  the largest distance of the points
  double visit_points(std::size_t number, std::size_t first, std::size_t last) {
    auto& groups = scratch_.groups;
    groups.resize((last - first + BoxTree::kWidth - 1) / BoxTree::kWidth);
    groups.back().clear();
    scratch_.entries.clear();
    for (std::size_t i = first; i < last; ++i) {
      const auto at = static_cast<unsigned>(i - first);
      groups[at / BoxTree::kWidth].set(at % BoxTree::kWidth, scratch_.found[i].box);
      scratch_.entries.push_back(scratch_.found[i].entry);
    }
    double bound = 0;
    hint_ = kNoIndex;
    const std::size_t end = std::min(tree_.points_.size(), kWidth * (number + 1));
    for (std::size_t i = kWidth * number; i < end; ++i) {
      bound = std::max(bound, visit_point(tree_.points_[i]));
    }
    return bound;
  }

  double visit_point(SurfacePoint& point) {
    const FloatFrame& frame = piece_.frame();
    const Float3 q = frame.to_local(point.position);
    const float spread = std::max(piece_.spread(), spread_of(q));
    const double before = load(point.word);
    double best = before;
    if (hint_ != kNoIndex) best = std::min(best, piece_.distance2(point.position, hint_));
    float reach2 = frame.reach2(best, spread);
    const BoxTree::Entry* entries = scratch_.entries.data();
    for (const BoxTree::Group& group : scratch_.groups) {
      piece_.boxes().search(group, entries, q, reach2, [&](std::uint32_t triangle) {
        const double distance2 = piece_.distance2(point.position, triangle);
        if (!(distance2 < best)) return;
        best = distance2;
        hint_ = triangle;
        reach2 = frame.reach2(best, spread);
      });
      entries += BoxTree::kWidth;
    }
    if (best < before) lower(point.word, best);
    return best;
  }

  SampleTree& tree_;
  const PieceTree& piece_;
  Scratch& scratch_;
  LocalIndex hint_ = kNoIndex;  // a triangle near the point before
};

void SampleTree::approach(const PieceTree& piece, Scratch& scratch) {
  if (!points_.empty()) Search(*this, piece, scratch).run();
}

bool SampleTree::any_near(const Box3& box) {
  const auto near = [&](const auto& self, std::size_t level, std::size_t number) -> bool {
    Node& node = levels_[level][number];
    if (gap2(node.low, node.high, box) * (1 - 1e-9) > load(node.bound)) return false;
    if (level == 0) return true;
    const std::size_t end = std::min(levels_[level - 1].size(), kWidth * (number + 1));
    for (std::size_t c = kWidth * number; c < end; ++c) {
      if (self(self, level - 1, c)) return true;
    }
    return false;
  };
  return !points_.empty() && !box.empty() && near(near, levels_.size() - 1, 0);
}

}  // namespace remaps
