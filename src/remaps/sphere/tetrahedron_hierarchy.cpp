#include "remaps/sphere/tetrahedron_hierarchy.h"

#include <algorithm>
#include <queue>
#include <string>

#include "remaps/base/errors.h"
#include "remaps/mesh/quadric.h"

namespace remaps::sphere {
namespace {

/// Of the fourth power of the longest edge of a new triangle.
constexpr double kLengthCost = 1e-3;
constexpr unsigned kMostValence = 9;  // beyond, each further edge doubles the cost

struct Candidate {
  double cost;
  LocalIndex vertex;
  std::uint32_t version;  // of the vertex; an earlier one is out of date

  friend bool operator<(const Candidate& a, const Candidate& b) {
    return a.cost != b.cost ? a.cost > b.cost : a.vertex > b.vertex;
  }
};

/// Removes vertices from a patch until four are left.
class Simplification {
 public:
  Simplification(std::span<const Vec3> position, std::span<const LocalTriangle> triangle)
      : position_(position), quadric_(position.size()), version_(position.size()) {
    if (patch_.build(position.size(), position.size(), triangle).kind !=
        ManifoldDefect::Kind::kNone) {
      throw GeometryError("a surface to be mapped to the sphere is not manifold");
    }
    for (LocalIndex v = 0; v < position.size(); ++v) {
      if (patch_.vertex_alive(v) && !patch_.on_boundary(v)) continue;
      throw GeometryError("a surface to be mapped to the sphere is not closed: vertex " +
                          std::to_string(v) + " is " +
                          (patch_.vertex_alive(v) ? "at a boundary" : "in no face"));
    }
    for (const LocalTriangle& t : triangle) {
      const Vec3 n = cross(position[t[1]] - position[t[0]], position[t[2]] - position[t[0]]);
      const double doubled = norm(n);
      if (!(doubled > 0)) continue;
      for (const LocalIndex v : t) quadric_[v].add_plane(1 / doubled * n, 0, doubled);
    }
  }

  TetrahedronHierarchy run(const Progress& progress) {
    const std::size_t n = position_.size();
    for (LocalIndex v = 0; v < n; ++v) push(v);
    std::size_t left = n;
    while (left > 4) {
      if (queue_.empty()) {
        throw GeometryError("a surface to be mapped to the sphere has genus other than 0: " +
                            std::to_string(left) + " of its vertices cannot be removed");
      }
      const Candidate next = queue_.top();
      queue_.pop();
      if (version_[next.vertex] != next.version) continue;
      if (!remove(next.vertex)) continue;
      if (--left % 4096 == 0) progress.check();
    }
    return collect();
  }

 private:
  double fan_cost(LocalIndex v, unsigned apex) const {
    const unsigned n = star_.wedges;
    const LocalIndex a = star_.ring[apex];
    double cost = quadric_[v](position_[a] - position_[v]);
    for (unsigned j = 0; j + 2 < n; ++j) {
      const LocalIndex b = star_.ring[(apex + 1 + j) % n], c = star_.ring[(apex + 2 + j) % n];
      const double longest =
          std::max({norm2(position_[a] - position_[b]), norm2(position_[b] - position_[c]),
                    norm2(position_[c] - position_[a])});
      cost += kLengthCost * longest * longest;
    }
    // The apex gets the edges to the ring but to itself and those beside, and loses that to v.
    const unsigned valence = patch_.valence(a) + n - 4;
    return valence > kMostValence ? std::ldexp(cost, static_cast<int>(valence - kMostValence))
                                  : cost;
  }

  /// The cheapest fan that may replace the star of v.
  bool choose(LocalIndex v, double& cost, unsigned& apex) {
    if (!patch_.star(v, star_)) return false;
    bool found = false;
    for (unsigned i = 0; i < star_.wedges; ++i) {
      const double of = fan_cost(v, i);
      if ((found && of >= cost) || !patch_.fan_keeps_topology(star_, i)) continue;
      found = true;
      cost = of;
      apex = i;
    }
    return found;
  }

  void push(LocalIndex v) {
    double cost = 0;
    unsigned apex = 0;
    ++version_[v];
    if (choose(v, cost, apex)) queue_.push({cost, v, version_[v]});
  }

  /// @return  false if that is no longer possible: removals elsewhere may join points of the ring
  bool remove(LocalIndex v) {
    double cost = 0;
    unsigned apex = 0;
    if (!choose(v, cost, apex)) return false;
    const unsigned n = star_.wedges;
    std::array<LocalIndex, kMaxRing> ring{};
    for (unsigned i = 0; i < n; ++i) ring[i] = star_.ring[(apex + i) % n];
    patch_.retriangulate(v, star_, apex);
    quadric_[ring[0]].add_translated(quadric_[v], position_[v] - position_[ring[0]]);
    removed_.push_back(v);
    ring_.insert(ring_.end(), ring.begin(), ring.begin() + n);
    end_.push_back(static_cast<std::uint32_t>(ring_.size()));
    for (unsigned i = 0; i < n; ++i) push(ring[i]);
    return true;
  }

  /// The removals backwards.
  TetrahedronHierarchy collect() const {
    TetrahedronHierarchy result;
    result.start.push_back(0);
    for (std::size_t i = removed_.size(); i-- > 0;) {
      result.vertex.push_back(removed_[i]);
      result.ring.insert(result.ring.end(), ring_.begin() + (i == 0 ? 0 : end_[i - 1]),
                         ring_.begin() + end_[i]);
      result.start.push_back(static_cast<std::uint32_t>(result.ring.size()));
    }
    LocalIndex f = 0;
    while (!patch_.face_alive(f)) ++f;
    const LocalTriangle first = patch_.face(f);
    std::copy(first.begin(), first.end(), result.corner.begin());
    LocalIndex v = 0;
    while (!patch_.vertex_alive(v) || std::find(first.begin(), first.end(), v) != first.end()) ++v;
    result.corner[3] = v;
    return result;
  }

  std::span<const Vec3> position_;
  Patch patch_;
  std::vector<Quadric> quadric_;
  std::vector<std::uint32_t> version_;
  std::priority_queue<Candidate> queue_;
  Star star_;
  std::vector<LocalIndex> removed_, ring_;
  std::vector<std::uint32_t> end_;
};

}  // namespace

TetrahedronHierarchy simplify_to_tetrahedron(std::span<const Vec3> position,
                                             std::span<const LocalTriangle> triangle,
                                             const Progress& progress) {
  if (position.size() < 4 || triangle.size() != 2 * position.size() - 4) {
    throw GeometryError("a surface of " + std::to_string(position.size()) + " vertices and " +
                        std::to_string(triangle.size()) + " faces is not closed of genus 0");
  }
  return Simplification(position, triangle).run(progress);
}

}  // namespace remaps::sphere
