#include "remaps/sphere/spherical_parameterization.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "remaps/base/errors.h"
#include "remaps/sphere/star_stretch.h"
#include "remaps/sphere/tetrahedron_hierarchy.h"

namespace remaps::sphere {
namespace {

constexpr std::uint64_t kVertexBytes = 600;
constexpr unsigned kSteps = 3;        // of Newton's method, for a vertex in a sweep
constexpr unsigned kFirstSteps = 10;  // for a vertex that is new
/// Of the time, what the sweeps over all vertices take when all are there.
constexpr double kLastShare = 0.2;

/// A triangulated sphere that grows.
class Embedding {
 public:
  Embedding(std::span<const Vec3> position, const SphericalOptions& options)
      : position_(position), options_(options), place_(position.size()), ring_(position.size()) {}

  void begin(const std::array<LocalIndex, 4>& corner) {
    const double s = 1 / std::numbers::sqrt3;
    // Faces (0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0) turn counter-clockwise.
    const std::array<Vec3, 4> places{Vec3{s, s, s}, Vec3{-s, -s, s}, Vec3{s, -s, -s},
                                     Vec3{-s, s, -s}};
    constexpr std::array<std::array<int, 3>, 4> kRings{
        {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    for (std::size_t i = 0; i < 4; ++i) {
      const LocalIndex v = corner[i];
      place_[v] = places[i];
      for (const int j : kRings[i]) ring_[v].push_back(corner[static_cast<std::size_t>(j)]);
      order_.push_back(v);
    }
    measure_area();
  }

  /// @param ring  as in TetrahedronHierarchy
  void insert(LocalIndex v, std::span<const LocalIndex> ring) {
    link(v, ring);
    place_[v] = place_in(ring);
    order_.push_back(v);
    relax(v, kFirstSteps);
    for (const LocalIndex u : ring) relax(u, kSteps);
  }

  /// Relaxes all vertices, several times.
  void sweep(unsigned most, double least_gain, const Progress& progress) {
    measure_area();
    double before = 0;
    for (const LocalIndex v : order_) before += energy_at(v);
    for (unsigned k = 0; k < most; ++k) {
      progress.check();
      double now = 0;
      for (const LocalIndex v : order_) now += relax(v, kSteps);
      if (now > (1 - least_gain) * before) break;
      before = now;
    }
  }

  std::size_t vertices() const { return order_.size(); }
  const std::vector<Vec3>& places() const { return place_; }

 private:
  /// Makes the star of v from the fan about ring[0].
  void link(LocalIndex v, std::span<const LocalIndex> ring) {
    const std::size_t n = ring.size();
    ring_[v].assign(ring.begin(), ring.end());
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<LocalIndex>& of = ring_[ring[i]];
      const LocalIndex first = ring[i + 1 == n ? 0 : i + 1], last = ring[i == 0 ? n - 1 : i - 1];
      // Between first and last comes v, and what was there goes.
      std::rotate(of.begin(), std::find(of.begin(), of.end(), first), of.end());
      const auto end = std::find(of.begin(), of.end(), last);
      of.erase(of.begin() + 1, end);
      of.insert(of.begin() + 1, v);
    }
  }

  void load(LocalIndex v) {
    ring_position_.clear();
    ring_place_.clear();
    for (const LocalIndex u : ring_[v]) {
      ring_position_.push_back(position_[u]);
      ring_place_.push_back(place_[u]);
    }
    star_.set_surface(position_[v], ring_position_, added_area_);
    star_.set_ring(ring_place_);
  }

  double energy_at(LocalIndex v) {
    load(v);
    return star_.energy(place_[v]);
  }

  /// @return  energy of the star before
  double relax(LocalIndex v, unsigned steps) {
    load(v);
    const double before = star_.energy(place_[v]);
    place_[v] = star_.improve(place_[v], steps);
    return before;
  }

  /// A place in sight of the whole ring, as far from its edges as is found among some.
  Vec3 place_in(std::span<const LocalIndex> ring) const {
    const std::size_t n = ring.size();
    std::vector<Vec3> inward(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 a = place_[ring[i]], b = place_[ring[(i + 1) % n]];
      const Vec3 normal = cross(a, b - a);
      inward[i] = 1 / norm(normal) * normal;
    }
    const auto depth = [&](const Vec3& x) {
      double least = 1;
      for (std::size_t i = 0; i < n; ++i) {
        least = std::min(least, dot(x - place_[ring[i]], inward[i]));
      }
      return least;
    };
    const Vec3 apex = place_[ring[0]];
    Vec3 middle;
    for (const LocalIndex r : ring) middle = middle + place_[r];
    Vec3 best = apex;
    double best_depth = 0;
    const auto try_place = [&](const Vec3& x) {
      if (!(norm2(x) > 0)) return;
      const Vec3 on_sphere = 1 / norm(x) * x;
      const double d = depth(on_sphere);
      if (d > best_depth) {
        best = on_sphere;
        best_depth = d;
      }
    };
    try_place(middle);
    // From the apex, which sees the whole ring, into the hole.
    const Vec3 inside = inward[0] + inward[n - 1];
    for (std::size_t i = 1; i < n; ++i) {
      Vec3 to = place_[ring[i]] - apex;
      for (double part = 0.5; part > 1e-6; part *= 0.5) {
        try_place(apex + part * to);
        try_place(apex + part * norm(to) / norm(inside) * inside);
        if (i + 1 < n) {
          try_place(apex + part * 0.5 * (to + (place_[ring[i + 1]] - apex)));
        }
      }
    }
    if (best_depth <= 0) {
      throw GeometryError("a part of the surface is too thin for the sphere");
    }
    return best;
  }

  void measure_area() {
    double area = 0;
    for (const LocalIndex v : order_) {
      const std::vector<LocalIndex>& ring = ring_[v];
      for (std::size_t i = 0; i < ring.size(); ++i) {
        area += norm(cross(position_[ring[i]] - position_[v],
                           position_[ring[(i + 1) % ring.size()]] - position_[v]));
      }
    }
    added_area_ = options_.regularization * area / 6 / static_cast<double>(2 * order_.size() - 4);
  }

  std::span<const Vec3> position_;
  const SphericalOptions& options_;
  std::vector<Vec3> place_;
  std::vector<std::vector<LocalIndex>> ring_;
  std::vector<LocalIndex> order_;  // of vertices that are there
  double added_area_ = 0;
  StarStretch star_;
  std::vector<Vec3> ring_position_, ring_place_;
};

}  // namespace

std::vector<SpherePoint> parameterize_sphere(std::span<const Vec3> position,
                                             std::span<const LocalTriangle> triangle,
                                             const SphericalOptions& options, MemoryBudget& budget,
                                             Progress& progress) {
  const Reservation memory =
      budget.reserve(kVertexBytes * position.size(), "mapping the base to the sphere");
  progress.begin("simplifying the base");
  const TetrahedronHierarchy hierarchy = simplify_to_tetrahedron(position, triangle, progress);
  progress.begin("mapping to the sphere");
  Embedding embedding(position, options);
  embedding.begin(hierarchy.corner);
  std::optional<ProgressPart> part(std::in_place, &progress, 0, 1 - kLastShare);
  double next = 4 * options.growth;
  for (std::size_t i = 0; i < hierarchy.vertex.size(); ++i) {
    embedding.insert(hierarchy.vertex[i], hierarchy.ring_of(i));
    if (static_cast<double>(embedding.vertices()) < next) continue;
    next *= options.growth;
    embedding.sweep(options.sweeps, options.least_gain, progress);
    progress.advance(static_cast<double>(i) / static_cast<double>(position.size()));
  }
  part.emplace(&progress, 1 - kLastShare, 1);
  embedding.sweep(options.last_sweeps, options.least_gain, progress);
  progress.advance(1);
  std::vector<SpherePoint> result;
  result.reserve(position.size());
  for (const Vec3& p : embedding.places()) result.push_back(to_sphere_point(p));
  for (const LocalTriangle& t : triangle) {
    if (orientation(result[t[0]], result[t[1]], result[t[2]]) <= 0) {
      throw GeometryError("a part of the surface is too thin for the sphere");
    }
  }
  return result;
}

}  // namespace remaps::sphere
