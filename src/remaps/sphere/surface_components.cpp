#include "remaps/sphere/surface_components.h"

#include <algorithm>
#include <numeric>

#include "remaps/base/errors.h"

namespace remaps::sphere {
namespace {

/// Disjoint sets of vertices.
class VertexSets {
 public:
  explicit VertexSets(std::size_t vertices) : parent_(vertices) {
    std::iota(parent_.begin(), parent_.end(), LocalIndex{0});
  }
  LocalIndex find(LocalIndex v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void join(LocalIndex a, LocalIndex b) { parent_[find(a)] = find(b); }

 private:
  std::vector<LocalIndex> parent_;
};

}  // namespace

SurfaceComponents find_components(std::size_t vertices, std::span<const LocalTriangle> triangle) {
  Patch patch;
  if (patch.build(vertices, vertices, triangle).kind != ManifoldDefect::Kind::kNone) {
    throw GeometryError("the surface is not manifold");
  }
  VertexSets parts(vertices), loops(vertices);
  for (const LocalTriangle& t : triangle) {
    parts.join(t[0], t[1]);
    parts.join(t[1], t[2]);
  }
  // Numbers of the parts in the order of their first faces.
  std::vector<std::uint32_t> number(vertices, kNoIndex), of_face;
  std::vector<SurfaceComponent> found;
  std::vector<std::uint64_t> boundary_edges;
  for (LocalIndex f = 0; f < triangle.size(); ++f) {
    std::uint32_t& c = number[parts.find(triangle[f][0])];
    if (c == kNoIndex) {
      c = static_cast<std::uint32_t>(found.size());
      found.emplace_back();
      boundary_edges.push_back(0);
    }
    of_face.push_back(c);
    ++found[c].faces;
    for (LocalIndex slot = 0; slot < 3; ++slot) {
      if (patch.opposite(corner_of(f, slot)) != kNoIndex) continue;
      ++boundary_edges[c];
      loops.join(triangle[f][(slot + 1) % 3], triangle[f][(slot + 2) % 3]);
    }
  }
  for (LocalIndex v = 0; v < vertices; ++v) {
    if (!patch.vertex_alive(v)) continue;
    SurfaceComponent& c = found[number[parts.find(v)]];
    ++c.vertices;
    if (patch.on_boundary(v) && loops.find(v) == v) ++c.boundary_loops;
  }
  for (std::size_t c = 0; c < found.size(); ++c) {
    const std::uint64_t edges = (3 * found[c].faces + boundary_edges[c]) / 2;
    found[c].euler_characteristic = static_cast<std::int64_t>(found[c].vertices + found[c].faces) -
                                    static_cast<std::int64_t>(edges);
  }
  std::vector<std::uint32_t> order(found.size()), rank(found.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return found[a].faces > found[b].faces;
  });
  SurfaceComponents result;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    rank[order[i]] = i;
    result.component.push_back(found[order[i]]);
  }
  for (std::uint32_t& c : of_face) c = rank[c];
  result.of_face = std::move(of_face);
  return result;
}

}  // namespace remaps::sphere
