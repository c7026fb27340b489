#include "remaps/pipeline/base_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "remaps/pipeline/bundle.h"

namespace remaps::pipeline {
namespace {

[[noreturn]] void refuse(const std::string& why) {
  throw CorruptionError(fmt::format("{}: {}", kBaseName, why));
}

/// A directed edge and the vertex opposite to it.
struct Edge {
  std::uint32_t from, to, opposite;

  friend auto operator<=>(const Edge&, const Edge&) = default;
};

class BaseCount {
 public:
  explicit BaseCount(const BaseMesh& base) : base_(base), faces_at_(base.position.size(), 0) {
    for (const auto& t : base.triangle) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (t[i] >= faces_at_.size()) refuse(fmt::format("there is no vertex {}", t[i]));
        if (t[i] == t[(i + 1) % 3]) refuse(fmt::format("a face has vertex {} twice", t[i]));
        ++faces_at_[t[i]];
        edges_.push_back({t[i], t[(i + 1) % 3], t[(i + 2) % 3]});
      }
    }
    std::sort(edges_.begin(), edges_.end());
  }

  Topology run() {
    Topology result;
    result.vertices = base_.position.size();
    result.faces = base_.triangle.size();
    for (std::size_t i = 1; i < edges_.size(); ++i) {
      if (edges_[i].from == edges_[i - 1].from && edges_[i].to == edges_[i - 1].to) {
        refuse(fmt::format("two faces have the edge from vertex {} to {} in the same direction",
                           edges_[i].from, edges_[i].to));
      }
    }
    for (const Edge& e : edges_) result.boundary_edges += find(e.to, e.from) == nullptr;
    for (std::uint32_t v = 0; v < faces_at_.size(); ++v) check_fan(v);
    result.components = count_joined(false);
    result.boundary_loops = count_joined(true);
    return result;
  }

 private:
  const Edge* find(std::uint32_t from, std::uint32_t to) const {
    const auto at = std::lower_bound(edges_.begin(), edges_.end(), Edge{from, to, 0});
    return at != edges_.end() && at->from == from && at->to == to ? &*at : nullptr;
  }

  /// Walks around v over shared edges, from its boundary edge if it has one, and must meet all.
  void check_fan(std::uint32_t v) const {
    const auto first = std::lower_bound(edges_.begin(), edges_.end(), Edge{v, 0, 0});
    if (faces_at_[v] == 0) refuse(fmt::format("vertex {} has no face", v));
    const Edge* start = &*first;
    for (auto e = first; e != edges_.end() && e->from == v; ++e) {
      if (find(e->to, v) == nullptr) start = &*e;
    }
    std::uint32_t met = 0;
    for (const Edge* e = start; e != nullptr && met <= faces_at_[v];) {
      ++met;
      e = find(v, e->opposite);
      if (e == start) break;
    }
    if (met != faces_at_[v])
      refuse(fmt::format("the faces at vertex {} form more than one fan", v));
  }

  /// Connected components of the graph of all edges, or of the boundary edges alone.
  std::uint64_t count_joined(bool boundary) const {
    std::vector<std::uint32_t> parent(faces_at_.size());
    std::vector<bool> marked(parent.size(), false);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t x) {
      while (parent[x] != x) x = parent[x] = parent[parent[x]];
      return x;
    };
    for (const Edge& e : edges_) {
      if (boundary && find(e.to, e.from) != nullptr) continue;
      marked[e.from] = marked[e.to] = true;
      parent[root(e.from)] = root(e.to);
    }
    std::uint64_t count = 0;
    for (std::uint32_t v = 0; v < parent.size(); ++v) count += marked[v] && parent[v] == v;
    return count;
  }

  const BaseMesh& base_;
  std::vector<std::uint32_t> faces_at_;  // (vertices)
  std::vector<Edge> edges_;              // sorted
};

}  // namespace

Topology count_base(const BaseMesh& base) {
  return BaseCount(base).run();
}

std::vector<VertexId> match_base(const BaseMesh& base, const std::vector<Triangle>& replayed) {
  constexpr VertexId kNone = ~VertexId{0};
  if (base.triangle.size() != replayed.size()) {
    refuse(
        fmt::format("{} faces, but the records leave {}", base.triangle.size(), replayed.size()));
  }
  std::vector<VertexId> id(base.position.size(), kNone);
  for (std::size_t f = 0; f < replayed.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      VertexId& known = id.at(base.triangle[f][i]);
      if (known == kNone) known = replayed[f][i];
      if (known == replayed[f][i]) continue;
      refuse(fmt::format("corner {} of face {} is input vertex {} by the records, but {} elsewhere",
                         i, f, replayed[f][i], known));
    }
  }
  std::vector<VertexId> sorted = id;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    refuse(fmt::format("input vertex {} stands for two of its vertices", *twice));
  }
  return id;
}

}  // namespace remaps::pipeline
