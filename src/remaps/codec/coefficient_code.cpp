#include "remaps/codec/coefficient_code.h"

#include <algorithm>
#include <bit>

#include "remaps/codec/binary_coder.h"
#include "remaps/codec/bit_predictor.h"

namespace remaps::codec {
namespace {

constexpr unsigned kGroups = 2;  // normal, tangential
constexpr std::size_t kMostLevels = SubdivisionHierarchy::kMostLevels + 1;

/// One traversal for both directions: with an encoder `target` says the bits, with a decoder they
/// come from it.
template <class Coder>
class BitplaneCoder {
 public:
  BitplaneCoder(const SubdivisionHierarchy& hierarchy, Coder& coder, Coefficients& known,
                const Coefficients* target, unsigned planes)
      : hierarchy_(hierarchy),
        coder_(coder),
        known_(known),
        target_(target),
        significance_({kMostLevels * kGroups * 96, kMostLevels * kGroups * 256,
                       hierarchy.base().size() * kGroups * 4, 4096},
                      kMostLevels * kGroups),
        tree_({kMostLevels * kGroups * 96, kMostLevels * kGroups * 256,
               hierarchy.base().size() * kGroups * 4},
              kMostLevels * kGroups),
        sign_({9 * kGroups, kMostLevels * 9}, kGroups),
        refinement_({kMostLevels * kGroups * 6, 64 * kGroups}, kGroups),
        base_bit_({32 * 4}, 1) {
    known_.resize(hierarchy.vertices());
    for (auto& p : known_.plane) p.fill(static_cast<std::uint8_t>(planes));
    open_.assign(hierarchy.vertices(), 0);
    if (target != nullptr) find_tops(*target);
    if (hierarchy.levels() > 0) {
      for (unsigned g = 0; g < kGroups; ++g) {
        for (std::uint32_t v = hierarchy.vertices(0); v < hierarchy.vertices(1); ++v) {
          active_[g][1].push_back(v);
        }
      }
    }
  }

  void run(unsigned planes) {
    for (plane_ = planes; plane_-- > 0;) {
      if (!code_base()) return;
      for (unsigned m = 1; m <= hierarchy_.levels(); ++m) {
        for (unsigned g = 0; g < kGroups; ++g) {
          if (!code_level(m, g)) return;
        }
      }
    }
  }

 private:
  static unsigned first_component(unsigned group) { return group == 0 ? 0 : 1; }
  static unsigned last_component(unsigned group) { return group == 0 ? 1 : 3; }

  /// What is known of a magnitude, in units of the plane.
  std::uint32_t seen(std::uint32_t v, unsigned c) const { return known_.magnitude[v][c] >> plane_; }
  std::uint32_t seen(std::uint32_t v, unsigned from, unsigned to) const {
    std::uint32_t most = 0;
    for (unsigned c = from; c < to; ++c) most = std::max(most, seen(v, c));
    return most;
  }

  bool code_base() {
    for (std::uint32_t v = 0; v < hierarchy_.vertices(0); ++v) {
      for (unsigned c = 0; c < 3; ++c) {
        const std::uint32_t so_far = seen(v, c);
        const std::size_t context = std::min<std::size_t>(plane_, 31) * 4 + std::min(so_far, 3u);
        const bool bit = base_bit_.code(coder_, target_bit(v, c), {context}, 0);
        if (coder_.ended()) return false;
        if (bit && so_far == 0) {
          const bool negative = coder_.code(target_sign(v, c), 1 << 15);
          if (coder_.ended()) return false;
          set_sign(v, c, negative);
        }
        take(v, c, bit);
      }
    }
    return true;
  }

  bool code_level(unsigned m, unsigned g) {
    level_ = m;
    group_ = g;
    auto& list = active_[g][m];
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (!code_vertex(list[i])) return false;
    }
    return true;
  }

  bool code_vertex(std::uint32_t v) {
    look_around(v);
    for (unsigned c = first_component(group_); c < last_component(group_); ++c) {
      if (!code_component(v, c)) return false;
    }
    if (level_ == hierarchy_.levels() || (open_[v] >> group_ & 1) != 0) return true;
    const std::size_t own = std::min(seen(v, first_component(group_), last_component(group_)), 3u);
    const std::size_t lg = level_ * kGroups + group_;
    const bool bit =
        tree_.code(coder_, tree_bit(v),
                   {(lg * 16 + own * 4 + std::min<std::size_t>(parent_, 3)) * 6 + around_class_,
                    lg * 256 + own * 64 + open_around_ * 8 + parent_class_ * 2 + (other_ != 0),
                    (base_face_ * kGroups + group_) * 4 + own},
                   lg);
    if (coder_.ended()) return false;
    if (bit) {
      open_[v] |= static_cast<std::uint8_t>(1 << group_);
      activate_children(v);
    }
    return true;
  }

  bool code_component(std::uint32_t v, unsigned c) {
    const std::uint32_t so_far = seen(v, c);
    const std::size_t lg = level_ * kGroups + group_;
    if (so_far != 0) {
      const bool bit = refinement_.code(
          coder_, target_bit(v, c),
          {lg * 6 + around_class_,
           ((std::min<std::size_t>(so_far / 2, 3) * 4 + std::min<std::size_t>(parent_, 3)) * 4 +
            std::min<std::size_t>(strongest_, 3)) *
                   kGroups +
               group_},
          group_);
      if (coder_.ended()) return false;
      take(v, c, bit);
      return true;
    }
    const std::size_t sibling = group_ == 0 ? 0 : std::min(seen(v, 3 - c), 1u) + 2 * (c - 1);
    const bool bit = significance_.code(
        coder_, target_bit(v, c),
        {(lg * 16 + parent_class_ * 4 + sibling) * 6 + around_class_,
         lg * 256 + std::min<std::size_t>(near_[0], 3) * 64 +
             std::min<std::size_t>(near_[1], 3) * 16 + std::min<std::size_t>(near_[2], 3) * 4 +
             std::min<std::size_t>(near_[3], 3),
         (base_face_ * kGroups + group_) * 4 + std::min<std::size_t>(level_ - 1, 3),
         (history_[group_] & 255) * 16 + std::min<std::size_t>(other_, 3) * 4 +
             std::min<std::size_t>(grandparent_, 3)},
        lg);
    if (coder_.ended()) return false;
    history_[group_] = history_[group_] << 1 | (bit ? 1u : 0u);
    if (bit) {
      const std::size_t signs = sign_around(c) * 3 + (level_ > 1 ? sign_of(parent_vertex_, c) : 0);
      const bool negative = sign_.code(coder_, target_sign(v, c),
                                       {signs * kGroups + group_, level_ * 9 + signs}, group_);
      if (coder_.ended()) return false;
      set_sign(v, c, negative);
    }
    take(v, c, bit);
    return true;
  }

  /// The contexts of a vertex: what is known of its parent and of the four edges of its two faces.
  void look_around(std::uint32_t v) {
    const SubdivisionLevel& level = hierarchy_.level(level_ - 1);
    const std::uint32_t e = v - level.vertices;
    const Side side = level.side[e], twin = level.twin_of(side);
    base_face_ = side.face() >> (2 * (level_ - 1));
    const unsigned from = first_component(group_), to = last_component(group_);
    const auto vertex_at = [&](Side s) {
      return level.vertices + level.edge[s.face()][s.corner()];
    };
    neighbour_[0] = vertex_at(side.next());
    neighbour_[1] = vertex_at(side.previous());
    neighbour_[2] = twin.none() ? neighbour_[0] : vertex_at(twin.next());
    neighbour_[3] = twin.none() ? neighbour_[1] : vertex_at(twin.previous());
    std::uint32_t sum = 0;
    strongest_ = 0;
    open_around_ = 0;
    for (unsigned i = 0; i < 4; ++i) {
      near_[i] = seen(neighbour_[i], from, to);
      sum += std::min(near_[i], 8u);
      strongest_ = std::max(strongest_, near_[i]);
      open_around_ += (static_cast<unsigned>(open_[neighbour_[i]]) >> group_) & 1u;
    }
    around_class_ = sum == 0 ? 0 : sum == 1 ? 1 : sum == 2 ? 2 : sum <= 4 ? 3 : sum <= 8 ? 4 : 5;
    parent_vertex_ = parent_of(e);
    parent_ = level_ > 1 ? seen(parent_vertex_, from, to) : 0;
    parent_class_ = parent_ == 0 ? 0 : parent_ == 1 ? 1 : parent_ <= 3 ? 2 : 3;
    grandparent_ = 0;
    if (level_ > 2) {
      --level_;
      const std::uint32_t grand = parent_of(parent_vertex_ - hierarchy_.level(level_ - 1).vertices);
      ++level_;
      grandparent_ = seen(grand, from, to);
    }
    other_ = group_ == 0 ? seen(v, 1, 3) : seen(v, 0, 1);
  }

  /// The vertex on the edge that edge e of level - 1 is a child of; level 1 has none.
  std::uint32_t parent_of(std::uint32_t e) const {
    if (level_ < 2) return 0;
    const SubdivisionLevel& coarser = hierarchy_.level(level_ - 2);
    const std::uint32_t halves = 2 * coarser.edges();
    if (e < halves) return coarser.vertices + e / 2;
    const std::uint32_t inner = e - halves;
    return coarser.vertices + coarser.edge[inner / 3][inner % 3];
  }

  template <class Visit>
  void for_children(std::uint32_t v, unsigned m, Visit&& visit) const {
    const SubdivisionLevel& level = hierarchy_.level(m - 1);
    const std::uint32_t e = v - level.vertices, first = hierarchy_.vertices(m);
    const Side side = level.side[e], twin = level.twin_of(side);
    visit(first + 2 * e);
    visit(first + 2 * e + 1);
    const std::uint32_t inner = first + 2 * level.edges();
    visit(inner + 3 * side.face() + side.corner());
    if (!twin.none()) visit(inner + 3 * twin.face() + twin.corner());
  }

  void activate_children(std::uint32_t v) {
    for_children(v, level_,
                 [&](std::uint32_t child) { active_[group_][level_ + 1].push_back(child); });
  }

  /// 0: none yet, 1: negative, 2: positive.
  std::size_t sign_of(std::uint32_t v, unsigned c) const {
    if (known_.magnitude[v][c] == 0) return 0;
    return (known_.negative[v] >> c & 1) != 0 ? 1 : 2;
  }
  /// That of most neighbours.
  std::size_t sign_around(unsigned c) const {
    int sum = 0;
    for (const std::uint32_t n : neighbour_) {
      const std::size_t sign = sign_of(n, c);
      sum += sign == 0 ? 0 : sign == 1 ? -1 : 1;
    }
    return sum == 0 ? 0 : sum < 0 ? 1 : 2;
  }

  bool target_bit(std::uint32_t v, unsigned c) const {
    return target_ != nullptr && (target_->magnitude[v][c] >> plane_ & 1) != 0;
  }
  bool target_sign(std::uint32_t v, unsigned c) const {
    return target_ != nullptr && (target_->negative[v] >> c & 1) != 0;
  }
  bool tree_bit(std::uint32_t v) const { return target_ != nullptr && top_[v][group_] > plane_; }
  void set_sign(std::uint32_t v, unsigned c, bool negative) {
    if (negative) known_.negative[v] |= static_cast<std::uint8_t>(1 << c);
  }
  void take(std::uint32_t v, unsigned c, bool bit) {
    if (bit) known_.magnitude[v][c] |= 1u << plane_;
    known_.plane[v][c] = static_cast<std::uint8_t>(plane_);
  }

  /// The number of planes that the descendants of each vertex have something in.
  void find_tops(const Coefficients& target) {
    top_.assign(hierarchy_.vertices(), {});
    for (unsigned m = hierarchy_.levels(); m-- > 1;) {
      for (std::uint32_t v = hierarchy_.vertices(m - 1); v < hierarchy_.vertices(m); ++v) {
        for_children(v, m, [&](std::uint32_t child) {
          for (unsigned g = 0; g < kGroups; ++g) {
            std::uint32_t all = 0;
            for (unsigned c = first_component(g); c < last_component(g); ++c) {
              all |= target.magnitude[child][c];
            }
            top_[v][g] = std::max(
                {top_[v][g], top_[child][g], static_cast<std::uint8_t>(std::bit_width(all))});
          }
        });
      }
    }
  }

  const SubdivisionHierarchy& hierarchy_;
  Coder& coder_;
  Coefficients& known_;
  const Coefficients* target_;
  std::vector<std::array<std::uint8_t, kGroups>> top_;
  std::vector<std::uint8_t> open_;  // bit g: descendants are significant in group g
  std::array<std::array<std::vector<std::uint32_t>, kMostLevels + 1>, kGroups> active_;

  MixedBit<4> significance_;
  MixedBit<3> tree_;
  MixedBit<2> sign_;
  MixedBit<2> refinement_;
  MixedBit<1> base_bit_;

  unsigned plane_ = 0, level_ = 0, group_ = 0;
  std::array<std::uint32_t, kGroups> history_{};
  std::array<std::uint32_t, 4> neighbour_{};
  std::array<std::uint32_t, 4> near_{};
  std::uint32_t base_face_ = 0, parent_vertex_ = 0, parent_ = 0, grandparent_ = 0, other_ = 0;
  std::uint32_t strongest_ = 0;
  std::size_t around_class_ = 0, parent_class_ = 0, open_around_ = 0;
};

}  // namespace

store::Bytes encode_coefficients(const SubdivisionHierarchy& hierarchy,
                                 const Coefficients& coefficients, unsigned planes) {
  store::Bytes code;
  BinaryEncoder encoder(code);
  Coefficients known;
  BitplaneCoder<BinaryEncoder>(hierarchy, encoder, known, &coefficients, planes).run(planes);
  encoder.finish();
  return code;
}

void decode_coefficients(const SubdivisionHierarchy& hierarchy, store::ByteSpan code,
                         unsigned planes, Coefficients& coefficients) {
  BinaryDecoder decoder(code);
  BitplaneCoder<BinaryDecoder>(hierarchy, decoder, coefficients, nullptr, planes).run(planes);
}

}  // namespace remaps::codec
