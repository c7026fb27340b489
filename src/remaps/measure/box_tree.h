#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "remaps/base/simd.h"

namespace remaps {

struct alignas(16) Float3 {
  float x = 0, y = 0, z = 0, unused = 0;

  static Float3 of(Float4 values) {
    Float3 p;
    store4(&p.x, values);
    return p;
  }
  Float4 all() const { return load4(&x); }
};

/// Axis-aligned box; empty until something is added.
struct FloatBox {
  Float3 low{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
             std::numeric_limits<float>::infinity()};
  Float3 high{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
              -std::numeric_limits<float>::infinity()};

  void add(const FloatBox& box) {
    low = Float3::of(min4(low.all(), box.low.all()));
    high = Float3::of(max4(high.all(), box.high.all()));
  }
  float extent() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

/// Squared distance between two boxes; 0 if they meet.
inline float box_distance2(const FloatBox& a, const FloatBox& b) {
  const float x = std::max({a.low.x - b.high.x, b.low.x - a.high.x, 0.0f});
  const float y = std::max({a.low.y - b.high.y, b.low.y - a.high.y, 0.0f});
  const float z = std::max({a.low.z - b.high.z, b.low.z - a.high.z, 0.0f});
  return x * x + y * y + z * z;
}

/// A hierarchy of float boxes that is made in time proportional to their number.
///
/// The items are put in the order of a space-filling curve, by counting; each 16 neighbours are a
/// group, and each 16 neighbouring groups one of the next level. Boxes of a group lie side by side,
/// so that a point is compared with all of them at once.
class BoxTree {
 public:
  static constexpr unsigned kWidth = 16;

  /// Boxes side by side; those that are not set are infinitely far from everything.
  struct alignas(64) Group {
    std::array<std::array<float, kWidth>, 3> low, high;

    void clear();
    void set(unsigned i, const FloatBox& box);
    /// Sets boxes i to i + 3, and adds them to a sum.
    void set4(unsigned i, const FloatBox& a, const FloatBox& b, const FloatBox& c,
              const FloatBox& d, FloatBox& sum) {
      const Float4 la = a.low.all(), lb = b.low.all(), lc = c.low.all(), ld = d.low.all();
      const Float4 ha = a.high.all(), hb = b.high.all(), hc = c.high.all(), hd = d.high.all();
      sum.low = Float3::of(min4(sum.low.all(), min4(min4(la, lb), min4(lc, ld))));
      sum.high = Float3::of(max4(sum.high.all(), max4(max4(ha, hb), max4(hc, hd))));
      set_rows(la, lb, lc, ld, i, low);
      set_rows(ha, hb, hc, hd, i, high);
    }
    FloatBox box(unsigned i) const {
      return {{low[0][i], low[1][i], low[2][i]}, {high[0][i], high[1][i], high[2][i]}};
    }

   private:
    static void set_rows(Float4 x, Float4 y, Float4 z, Float4 unused, unsigned i,
                         std::array<std::array<float, kWidth>, 3>& to) {
      transpose4(x, y, z, unused);
      store4(&to[0][i], x);
      store4(&to[1][i], y);
      store4(&to[2][i], z);
    }
  };

  /// A box of some level. At level 0 `index` is the number of an item.
  struct Entry {
    std::uint32_t level = 0;
    std::uint32_t index = 0;
  };

  /// @param items   one or more
  /// @param box_of  called with the number of an item, several times; the items are in `around`
  template <class BoxOf>
  void build(std::uint32_t items, const FloatBox& around, const BoxOf& box_of) {
    box_ = around;
    const Cells cells(around, items);
    begin_sort(items, cells);
    for (std::uint32_t i = 0; i < items; ++i) ++past_[cell_[i] = cells.of(box_of(i))];
    end_sort();
    add_level(items, [&](std::uint32_t at) { return box_of(order_[at]); });
    add_upper_levels();
  }

  Entry root() const { return {static_cast<std::uint32_t>(first_.size()), 0}; }
  const FloatBox& box() const { return box_; }

  /// Calls visit(box, entry) for the children of an entry above level 0 that lie within reach of a
  /// box.
  template <class Visit>
  void for_children(Entry entry, const FloatBox& from, float reach2, Visit&& visit) const {
    const Group& group = group_of(entry);
    Distances distances(group, from);
    for (unsigned near = distances.within(reach2); near != 0; near &= near - 1) {
      const auto i = static_cast<unsigned>(std::countr_zero(near));
      visit(group.box(i), child(entry, i));
    }
  }

  /// Looks for items near a point below the entries of a group, nearest boxes first.
  ///
  /// @param entries  of the boxes of the group
  /// @param reach2   squared distance beyond which boxes are passed by, finite; visit may lower it
  /// @param visit    called with the number of an item whose box is within reach
  template <class Visit>
  void search(const Group& group, const Entry* entries, const Float3& p, float& reach2,
              Visit&& visit) const {
    search_group(
        group, [&](unsigned i) { return entries[i]; }, p, reach2, visit);
  }
  /// The same below the root.
  template <class Visit>
  void search(const Float3& p, float& reach2, Visit&& visit) const {
    search_below(root(), p, reach2, visit);
  }

  /// The bytes of a tree of so many items.
  static constexpr std::uint64_t kBytesPerItem = 40;

 private:
  /// Squared distances of the boxes of a group.
  class Distances {
   public:
    Distances(const Group& group, const FloatBox& from) {
      const Float4 low_x = all4(from.low.x), high_x = all4(from.high.x);
      const Float4 low_y = all4(from.low.y), high_y = all4(from.high.y);
      const Float4 low_z = all4(from.low.z), high_z = all4(from.high.z);
      for (unsigned i = 0; i < kWidth; i += 4) {
        const auto gap = [&](Float4 low, Float4 high, unsigned axis) {
          const Float4 above = load4(&group.low[axis][i]) - high;
          const Float4 below = low - load4(&group.high[axis][i]);
          return max4(max4(above, below), all4(0.0f));
        };
        const Float4 x = gap(low_x, high_x, 0), y = gap(low_y, high_y, 1),
                     z = gap(low_z, high_z, 2);
        store4(&value_[i], x * x + y * y + z * z);
      }
    }

    /// Bit i: box i is no further than that.
    unsigned within(float reach2) const {
      unsigned bits = 0;
      for (unsigned i = 0; i < kWidth; i += 4) {
        bits |= at_most4(load4(&value_[i]), all4(reach2)) << i;
      }
      return bits;
    }

    /// The nearest of some.
    unsigned nearest(unsigned bits) const {
      auto best = static_cast<unsigned>(std::countr_zero(bits));
      for (bits &= bits - 1; bits != 0; bits &= bits - 1) {
        const auto i = static_cast<unsigned>(std::countr_zero(bits));
        best = value_[i] < value_[best] ? i : best;
      }
      return best;
    }

   private:
    alignas(16) std::array<float, kWidth> value_;
  };

  template <class EntryOf, class Visit>
  void search_group(const Group& group, EntryOf&& entry_of, const Float3& p, float& reach2,
                    Visit& visit) const {
    const Distances distances(group, {p, p});
    unsigned left = ~0u;
    while (const unsigned near = distances.within(reach2) & left) {
      const unsigned i = distances.nearest(near);
      left &= ~(1u << i);
      search_below(entry_of(i), p, reach2, visit);
    }
  }
  template <class Visit>
  void search_below(Entry entry, const Float3& p, float& reach2, Visit& visit) const {
    if (entry.level == 0) {
      visit(entry.index);
    } else {
      search_group(
          group_of(entry), [&](unsigned i) { return child(entry, i); }, p, reach2, visit);
    }
  }

  const Group& group_of(Entry entry) const {
    return groups_[first_[entry.level - 1] + entry.index];
  }
  Entry child(Entry entry, std::uint32_t i) const {
    const std::uint32_t at = kWidth * entry.index + i;
    return {entry.level - 1, entry.level == 1 ? order_[at] : at};
  }

  /// The cells of the curve.
  class Cells {
   public:
    Cells(const FloatBox& around, std::uint32_t items);
    std::size_t size() const { return std::size_t{1} << 3 * bits_; }
    /// That of the centre of a box, which is half the sum of its corners.
    std::uint32_t of(const FloatBox& box) const {
      const Float3 at = Float3::of((box.low.all() + box.high.all() - low_) * cells_);
      return along(at.x) | along(at.y) << 1 | along(at.z) << 2;
    }

   private:
    std::uint32_t along(float at) const {
      return spread_[std::min(static_cast<unsigned>(at), (1u << bits_) - 1)];
    }

    unsigned bits_;  // of the number of cells along a side
    Float4 low_, cells_;
    std::array<std::uint32_t, 64> spread_;
  };

  void begin_sort(std::uint32_t items, const Cells& cells);
  void end_sort();
  void add_upper_levels();

  /// Groups boxes, and leaves those of the groups in level_box_.
  template <class BoxAt>
  void add_level(std::uint32_t boxes, const BoxAt& box_at) {
    Group* group = begin_level(boxes);
    for (std::uint32_t at = 0; at < boxes; ++group) {
      FloatBox sum;
      unsigned i = 0;
      for (; i < kWidth && at + 4 <= boxes; i += 4, at += 4) {
        group->set4(i, box_at(at), box_at(at + 1), box_at(at + 2), box_at(at + 3), sum);
      }
      for (; i < kWidth && at < boxes; ++i, ++at) {
        const FloatBox box = box_at(at);
        group->set(i, box);
        sum.add(box);
      }
      level_box_.push_back(sum);
    }
  }
  Group* begin_level(std::uint32_t boxes);

  FloatBox box_;
  std::vector<Group> groups_;                 // level by level, the items' first
  std::vector<std::uint32_t> first_, count_;  // of each level, in groups_
  std::vector<std::uint32_t> order_;          // of items along the curve
  std::vector<std::uint32_t> cell_, past_;    // of each item; past the items of each cell
  std::vector<FloatBox> level_box_, below_box_;
};

}  // namespace remaps
