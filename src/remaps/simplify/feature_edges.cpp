#include "remaps/simplify/feature_edges.h"

#include <cmath>
#include <vector>

namespace remaps::simplify {
namespace {

constexpr std::uint8_t kNothingKnown = 0b111000;

Vec3 doubled_normal(const Segment& s, const LocalTriangle& t) {
  const Vec3 a = widen(s.position[t[0]]);
  return cross(widen(s.position[t[1]]) - a, widen(s.position[t[2]]) - a);
}

/// Calls visit(corner, corner across) once for each edge with two faces.
template <class Visit>
void for_each_edge(const Patch& patch, Visit&& visit) {
  for (LocalIndex f = 0; f < patch.face_slots(); ++f) {
    if (!patch.face_alive(f)) continue;
    for (LocalIndex i = 0; i < 3; ++i) {
      const LocalIndex c = corner_of(f, i);
      const LocalIndex across = patch.opposite(c);
      if (across != kNoIndex && c < across) visit(c, across);
    }
  }
}

/// What a face knows of one of its edges.
class EdgeBits {
 public:
  EdgeBits(Segment& s, LocalIndex corner)
      : bits_(s.feature[face_of(corner)]), slot_(slot_of(corner)) {}

  bool known() const { return (unsigned{bits_} >> (slot_ + 3) & 1u) == 0; }
  bool feature() const { return (unsigned{bits_} >> slot_ & 1u) != 0; }
  void set(bool feature) {
    const unsigned cleared = unsigned{bits_} & ~(9u << slot_);
    bits_ = static_cast<std::uint8_t>(cleared | (feature ? 1u << slot_ : 0u));
  }

 private:
  std::uint8_t& bits_;
  unsigned slot_;
};

/// An edge between two faces that belong to different things.
bool parts_labels(const Segment& s, LocalIndex f, LocalIndex g) {
  return !s.label.empty() && s.label[f] != s.label[g] && s.label[f] != kNoLabel &&
         s.label[g] != kNoLabel;
}

void decide_edges(double angle_rad, const Patch& patch, Segment& s) {
  if (s.feature.empty()) s.feature.assign(s.triangle.size(), kNothingKnown);
  const double cosine = std::cos(angle_rad);
  const auto is_sharp = [&](LocalIndex f, LocalIndex g) {
    if (parts_labels(s, f, g)) return true;
    if (angle_rad <= 0) return false;
    const Vec3 a = doubled_normal(s, s.triangle[f]);
    const Vec3 b = doubled_normal(s, s.triangle[g]);
    return dot(a, b) < cosine * std::sqrt(norm2(a) * norm2(b));
  };
  for_each_edge(patch, [&](LocalIndex c, LocalIndex across) {
    EdgeBits a(s, c);
    EdgeBits b(s, across);
    const bool feature = a.known()   ? a.feature()
                         : b.known() ? b.feature()
                                     : is_sharp(face_of(c), face_of(across));
    a.set(feature);
    b.set(feature);
  });
}

/// The features of a segment as a graph.
class FeatureGraph {
 public:
  FeatureGraph(Patch& patch, Segment& s) : patch_(patch), s_(s) {
    start_.assign(s.vertex_id.size() + 1, 0);
    const auto each = [&](auto&& visit) {
      for_each_edge(patch, [&](LocalIndex c, LocalIndex) {
        if (!patch.is_feature(c)) return;
        visit(c, patch.corner_vertex(next_corner(c)), patch.corner_vertex(previous_corner(c)));
      });
    };
    each([&](LocalIndex, LocalIndex a, LocalIndex b) {
      ++start_[a];
      ++start_[b];
    });
    degree_.assign(start_.begin(), start_.end());
    std::uint32_t end = 0;
    for (std::uint32_t& start : start_) start = end += start;
    arc_.resize(end);
    each([&](LocalIndex c, LocalIndex a, LocalIndex b) {
      arc_[--start_[a]] = {b, c};
      arc_[--start_[b]] = {a, c};
    });
  }

  std::uint64_t count_own() const {
    std::uint64_t count = 0;
    for (LocalIndex v = 0; v < s_.own_vertices; ++v) {
      for (std::uint32_t i = start_[v]; i < start_[v + 1]; ++i)
        count += s_.vertex_id[v] < s_.vertex_id[arc_[i].to];
    }
    return count;
  }

  /// Takes away chains with a loose end that are shorter than `least`.
  /// @return  number of edges taken
  std::uint64_t drop_loose(double least) {
    std::uint64_t dropped = 0;
    for (LocalIndex v = 0; v < s_.own_vertices; ++v) {
      LocalIndex end = v;
      while (is_loose(end) && follow(end, least)) {
        dropped += chain_.size();
        end = drop_chain();
      }
    }
    return dropped;
  }

  /// Takes away connected features that have less than `least` of length for each of their corners;
  /// loops that are shorter, if they have fewer than `loop_edges`.
  /// @return  number of edges taken
  std::uint64_t drop_poor(double least, std::size_t loop_edges) {
    std::uint64_t dropped = 0;
    std::vector<std::uint8_t> seen(degree_.size(), 0);
    std::vector<LocalIndex> connected;
    for (LocalIndex v = 0; v < s_.own_vertices; ++v) {
      if (seen[v] || degree_[v] == 0) continue;
      connected.assign(1, v);
      seen[v] = 1;
      double length = 0;
      std::uint64_t corners = 0;
      bool whole = true;
      for (std::size_t i = 0; i < connected.size(); ++i) {
        const LocalIndex from = connected[i];
        whole = whole && is_free(from);
        corners += is_corner(from);
        for_each_arc(from, [&](const Arc& arc) {
          whole = whole && !is_border(arc);
          length += 0.5 * arc_length(from, arc);
          if (seen[arc.to]) return;
          seen[arc.to] = 1;
          connected.push_back(arc.to);
        });
      }
      const bool poor = corners != 0 ? length < least * double(corners)
                                     : length < least && connected.size() < loop_edges;
      if (!whole || !poor) continue;
      for (const LocalIndex from : connected) {
        for_each_arc(from, [&](const Arc& arc) {
          patch_.clear_feature(arc.corner);
          ++dropped;
        });
        degree_[from] = 0;
      }
    }
    return dropped;
  }

  std::uint64_t lock_corners() {
    std::uint64_t corners = 0;
    for (LocalIndex v = 0; v < s_.own_vertices; ++v) {
      if (s_.locked[v] || !is_corner(v)) continue;
      s_.locked[v] = 1;
      ++corners;
    }
    return corners;
  }

 private:
  struct Arc {
    LocalIndex to;
    LocalIndex corner;  // opposite to the edge
  };

  /// Features at v that are left.
  template <class Visit>
  void for_each_arc(LocalIndex v, Visit&& visit) const {
    for (std::uint32_t i = start_[v]; i < start_[v + 1]; ++i) {
      if (patch_.is_feature(arc_[i].corner)) visit(arc_[i]);
    }
  }
  double arc_length(LocalIndex from, const Arc& arc) const {
    return norm(widen(s_.position[arc.to]) - widen(s_.position[from]));
  }
  bool is_border(const Arc& arc) const {
    return parts_labels(s_, face_of(arc.corner), face_of(patch_.opposite(arc.corner)));
  }
  bool is_corner(LocalIndex v) const {
    return degree_[v] != 0 && (degree_[v] != 2 || patch_.on_boundary(v));
  }
  bool is_free(LocalIndex v) const { return v < s_.own_vertices && !s_.locked[v]; }
  bool is_loose(LocalIndex v) const {
    return degree_[v] == 1 && is_free(v) && !patch_.on_boundary(v);
  }

  /// Lists the chain that begins at v in chain_.
  /// @return  true when it ends within `least`, at a vertex that no other segment knows more of
  bool follow(LocalIndex v, double least) {
    chain_.clear();
    double length = 0;
    while (true) {
      Arc next{};
      for_each_arc(v, [&](const Arc& arc) {
        if (chain_.empty() || chain_.back().corner != arc.corner) next = arc;
      });
      if (is_border(next)) return false;
      length += arc_length(v, next);
      chain_.push_back(next);
      v = next.to;
      if (!(length < least) || !is_free(v)) return false;
      if (is_corner(v)) return true;
    }
  }

  /// @return  the vertex at its end
  LocalIndex drop_chain() {
    for (const Arc& arc : chain_) {
      --degree_[patch_.corner_vertex(next_corner(arc.corner))];
      --degree_[patch_.corner_vertex(previous_corner(arc.corner))];
      patch_.clear_feature(arc.corner);
    }
    return chain_.back().to;
  }

  Patch& patch_;
  Segment& s_;
  std::vector<std::uint32_t> start_;   // (vertices + 1) of the arcs that leave each
  std::vector<std::uint32_t> degree_;  // (vertices) features that are left
  std::vector<Arc> arc_;
  std::vector<Arc> chain_;
};

}  // namespace

FeatureCounts find_features(const FeatureOptions& options, Patch& patch, Segment& segment) {
  FeatureCounts counts;
  const bool first_level = segment.feature.empty();
  decide_edges(options.angle_rad, patch, segment);
  patch.mark_features(segment.feature);
  FeatureGraph graph(patch, segment);
  counts.edges = graph.count_own();
  if (first_level || !options.labels) {
    counts.dropped = graph.drop_loose(options.least_loose);
    counts.dropped +=
        graph.drop_poor(options.least_per_corner, first_level ? options.least_loop_edges : 0);
  }
  counts.corners = graph.lock_corners();
  return counts;
}

std::uint64_t count_features(const Patch& patch) {
  std::uint64_t count = 0;
  for_each_edge(patch, [&](LocalIndex c, LocalIndex) { count += patch.is_feature(c); });
  return count;
}

}  // namespace remaps::simplify
