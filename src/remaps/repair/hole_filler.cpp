#include "remaps/repair/hole_filler.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <tuple>

#include "remaps/base/errors.h"
#include "remaps/base/workers.h"

namespace remaps::repair {
namespace {

/// Cubic time is little up to here.
constexpr std::size_t kLargestTriangulated = 128;

/// Memory of the list of an edge while loops are traced.
constexpr std::uint64_t kBytesPerEdge = 100;
constexpr std::uint64_t kEdgesAtATime = 1 << 14;

/// A half-edge without a face across it.
struct BoundaryEdge {
  VertexId from = 0, to = 0;
  Vec3f position;  // of from
  FaceId face = 0;
};

/// An edge at a boundary vertex.
using Edge = std::pair<VertexId, VertexId>;

struct Lane {
  VertexIndex index;
  Segment segment;
  std::vector<FaceLink> origin;
  Patch patch;
};

struct Found {
  std::vector<BoundaryEdge> boundary;
  std::vector<Edge> edge;
};

double area(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  return norm(cross(widen(b) - widen(a), widen(c) - widen(a)));
}

/// The boundary as a whole, in memory.
class Boundary {
 public:
  explicit Boundary(MemoryBudget& budget) : budget_(budget) {}

  void add(const Found& found) {
    while (reserved_ < edge_.size() + found.boundary.size()) {
      const std::uint64_t more = std::max(kEdgesAtATime, reserved_);
      reservations_.push_back(budget_.reserve(more * kBytesPerEdge, "the edges of holes"));
      reserved_ += more;
    }
    edge_.insert(edge_.end(), found.boundary.begin(), found.boundary.end());
    joined_.insert(joined_.end(), found.edge.begin(), found.edge.end());
  }

  /// Calls fill(hole) for each loop of up to so many edges, in order of their lowest vertices.
  template <class Fill>
  void for_each_hole(std::uint64_t most_edges, Fill&& fill) {
    std::sort(edge_.begin(), edge_.end(),
              [](const BoundaryEdge& a, const BoundaryEdge& b) { return a.from < b.from; });
    std::sort(joined_.begin(), joined_.end());
    std::vector<bool> seen(edge_.size(), false);
    for (std::size_t start = 0; start < edge_.size(); ++start) {
      if (seen[start]) continue;
      std::vector<std::size_t> loop;
      for (std::size_t at = start; !seen[at]; at = find(edge_[at].to)) {
        seen[at] = true;
        loop.push_back(at);
      }
      if (loop.size() <= most_edges) fill(make_hole(loop));
    }
  }

 private:
  std::size_t find(VertexId vertex) const {
    const auto at =
        std::lower_bound(edge_.begin(), edge_.end(), vertex,
                         [](const BoundaryEdge& edge, VertexId v) { return edge.from < v; });
    if (at == edge_.end() || at->from != vertex)
      throw CorruptionError("a boundary does not go on where it should");
    return static_cast<std::size_t>(at - edge_.begin());
  }

  Hole make_hole(const std::vector<std::size_t>& loop) const {
    Hole hole;
    std::vector<std::pair<VertexId, std::uint32_t>> number;
    hole.of_one_face = loop.size() == 3;
    for (std::size_t i = loop.size(); i-- > 0;) {
      const BoundaryEdge& edge = edge_[loop[i]];
      number.emplace_back(edge.from, static_cast<std::uint32_t>(hole.vertex.size()));
      hole.vertex.push_back(edge.from);
      hole.position.push_back(edge.position);
      hole.of_one_face = hole.of_one_face && edge.face == edge_[loop[0]].face;
    }
    std::sort(number.begin(), number.end());
    for (const auto& [vertex, i] : number) {
      const auto first = std::lower_bound(joined_.begin(), joined_.end(), Edge{vertex, 0});
      for (auto at = first; at != joined_.end() && at->first == vertex; ++at) {
        const auto other =
            std::lower_bound(number.begin(), number.end(), std::pair{at->second, std::uint32_t{0}});
        if (other == number.end() || other->first != at->second) continue;
        hole.joined.emplace_back(std::min(i, other->second), std::max(i, other->second));
      }
    }
    std::sort(hole.joined.begin(), hole.joined.end());
    return hole;
  }

  MemoryBudget& budget_;
  std::vector<Reservation> reservations_;
  std::uint64_t reserved_ = 0;
  std::vector<BoundaryEdge> edge_;
  std::vector<Edge> joined_;
};

std::shared_ptr<Found> find_boundary(DomainLevel& level, std::size_t i, Lane& lane) {
  level.load(i, lane.index, lane.segment, lane.origin, DomainLevel::After::kKeep);
  const Segment& s = lane.segment;
  const ManifoldDefect defect = lane.patch.build(s.vertex_id.size(), s.own_vertices, s.triangle);
  if (defect.kind != ManifoldDefect::Kind::kNone)
    throw GeometryError("holes can be filled in a manifold only");
  auto found = std::make_shared<Found>();
  const auto end = corner_of(static_cast<LocalIndex>(s.triangle.size()), 0);
  for (LocalIndex c = 0; c < end; c = after_corner(c)) {
    if (lane.patch.opposite(c) != kNoIndex) continue;
    const LocalIndex a = lane.patch.corner_vertex(next_corner(c));
    const LocalIndex b = lane.patch.corner_vertex(previous_corner(c));
    if (a >= s.own_vertices) continue;
    found->boundary.push_back(
        {s.vertex_id[a], s.vertex_id[b], s.position[a], s.face_id[face_of(c)]});
    lane.patch.for_each_neighbour(
        a, [&](LocalIndex other) { found->edge.emplace_back(s.vertex_id[a], s.vertex_id[other]); });
  }
  return found;
}

/// Appends what fills holes to a level.
class Appender {
 public:
  Appender(DomainLevel& level, FaceId first_face, VertexId first_vertex)
      : level_(level), next_face_(first_face), next_vertex_(first_vertex) {}

  void fill(const Hole& hole) {
    std::vector<RoutedVertex> around;
    for (std::size_t i = 0; i < hole.vertex.size(); ++i)
      around.push_back(routed(hole.vertex[i], hole.position[i]));
    const auto triangles = triangulate_hole(hole);
    for (const auto& t : triangles) add({around[t[0]], around[t[1]], around[t[2]]});
    if (triangles.empty()) fill_around_middle(hole, around);
    ++counts_.holes;
  }

  const FillCounts& counts() const { return counts_; }

 private:
  RoutedVertex routed(VertexId id, const Vec3f& position) const {
    return {id, position, level_.cut().segment_of(position)};
  }
  void add(const std::array<RoutedVertex, 3>& corner) {
    level_.add_face(corner, {next_face_++, 0, {}});
    ++counts_.faces;
  }
  void fill_around_middle(const Hole& hole, const std::vector<RoutedVertex>& around) {
    Vec3 sum;
    for (const Vec3f& p : hole.position) sum = sum + widen(p);
    const RoutedVertex middle =
        routed(next_vertex_++, to_float((1 / double(hole.position.size())) * sum));
    level_.add_vertex(middle, {});
    ++counts_.vertices;
    for (std::size_t i = 0; i < around.size(); ++i)
      add({around[i], around[(i + 1) % around.size()], middle});
  }

  DomainLevel& level_;
  FaceId next_face_;
  VertexId next_vertex_;
  FillCounts counts_;
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulate_hole(const Hole& hole) {
  const std::size_t n = hole.position.size();
  if (n > kLargestTriangulated || hole.of_one_face) return {};
  constexpr double kNone = std::numeric_limits<double>::infinity();
  // least[i * n + k]: of the polygon i ... k; middle: its triangle's third corner.
  std::vector<double> least(n * n, 0);
  std::vector<std::uint32_t> middle(n * n, 0);
  for (std::size_t span = 2; span < n; ++span) {
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t k = i + span;
      double& best = least[i * n + k];
      best = kNone;
      // The last chord is a side of the loop.
      const std::pair chord{static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k)};
      const bool side = i == 0 && k == n - 1;
      if (!side && std::binary_search(hole.joined.begin(), hole.joined.end(), chord)) continue;
      for (std::size_t j = i + 1; j < k; ++j) {
        const double sum = least[i * n + j] + least[j * n + k] +
                           area(hole.position[i], hole.position[j], hole.position[k]);
        if (sum >= best) continue;
        best = sum;
        middle[i * n + k] = static_cast<std::uint32_t>(j);
      }
    }
  }
  if (!(least[n - 1] < kNone)) return {};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open{{0, static_cast<std::uint32_t>(n - 1)}};
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    if (k - i < 2) continue;
    const std::uint32_t j = middle[i * n + k];
    triangles.push_back({i, j, k});
    open.emplace_back(i, j);
    open.emplace_back(j, k);
  }
  return triangles;
}

FillCounts fill_holes(DomainLevel& level, const FillOptions& options, FaceId first_face,
                      VertexId first_vertex, MemoryBudget& budget) {
  std::vector<Lane> lanes(std::max(1u, options.threads));
  Boundary boundary(budget);
  run_ordered(level.segments(), options.threads, [&](std::size_t i, unsigned lane) -> Commit {
    if (options.progress != nullptr) options.progress->check();
    const std::shared_ptr<Found> found = find_boundary(level, i, lanes[lane]);
    return [&, i, found] {
      boundary.add(*found);
      if (options.progress != nullptr)
        options.progress->advance(double(i + 1) / double(level.segments()));
    };
  });
  Appender appender(level, first_face, first_vertex);
  boundary.for_each_hole(options.most_edges, [&](const Hole& hole) { appender.fill(hole); });
  return appender.counts();
}

}  // namespace remaps::repair
