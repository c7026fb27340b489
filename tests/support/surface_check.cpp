#include "support/surface_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace remaps::test {
namespace {

using HalfEdge = std::pair<VertexId, VertexId>;

VertexId root_of(std::map<VertexId, VertexId>& parent, VertexId v) {
  while (parent.at(v) != v) v = parent[v] = parent.at(parent.at(v));
  return v;
}

/// Neighbours of a vertex in order about it, from the triangles that have it; empty when they are
/// not one fan.
std::vector<VertexId> ring_of(const std::vector<HalfEdge>& outer_edges) {
  std::map<VertexId, VertexId> next;
  std::set<VertexId> heads;
  for (const auto& [tail, head] : outer_edges) {
    if (!next.emplace(tail, head).second || !heads.insert(head).second) return {};
  }
  VertexId start = next.begin()->first;
  for (const auto& [tail, head] : next) {
    if (!heads.contains(tail)) start = tail;
  }
  std::vector<VertexId> ring{start};
  VertexId at = start;
  while (next.contains(at)) {
    at = next.at(at);
    if (at == start) break;
    ring.push_back(at);
    if (ring.size() > next.size() + 1) return {};
  }
  const bool closed = at == start;
  return ring.size() == next.size() + (closed ? 0 : 1) ? ring : std::vector<VertexId>{};
}

std::string check_corners(const Patch& patch) {
  const LocalIndex end = corner_of(static_cast<LocalIndex>(patch.face_slots()), 0);
  std::map<HalfEdge, LocalIndex> corner_at;
  for (LocalIndex c = 0; c < end; c = after_corner(c)) {
    if (!patch.face_alive(face_of(c))) continue;
    if (patch.corner_vertex(c) >= patch.vertex_slots()) return fmt::format("corner {}: vertex", c);
    const HalfEdge edge{patch.corner_vertex(next_corner(c)),
                        patch.corner_vertex(previous_corner(c))};
    if (!corner_at.emplace(edge, c).second)
      return fmt::format("half-edge {} {} occurs twice", edge.first, edge.second);
  }
  for (LocalIndex c = 0; c < end; c = after_corner(c)) {
    LocalIndex expected = kNoIndex;
    if (patch.face_alive(face_of(c))) {
      const auto twin = corner_at.find(
          {patch.corner_vertex(previous_corner(c)), patch.corner_vertex(next_corner(c))});
      if (twin != corner_at.end()) expected = twin->second;
    }
    if (patch.opposite(c) != expected)
      return fmt::format("opposite of corner {} is {}, not {}", c, patch.opposite(c), expected);
  }
  return {};
}

std::string check_vertex(const Patch& patch, LocalIndex v, const std::vector<HalfEdge>& outer) {
  if (patch.vertex_alive(v) == outer.empty()) return fmt::format("vertex {}: alive?", v);
  if (outer.empty()) {
    return patch.valence(v) == 0 ? "" : fmt::format("vertex {}: valence without faces", v);
  }
  const std::vector<VertexId> ring = ring_of(outer);
  if (ring.empty()) return fmt::format("vertex {}: more than one fan", v);
  const bool boundary = ring.size() > outer.size();
  if (patch.on_boundary(v) != boundary) return fmt::format("vertex {}: on the boundary?", v);
  if (patch.valence(v) != ring.size())
    return fmt::format("vertex {}: valence {}, not {}", v, patch.valence(v), ring.size());
  std::vector<VertexId> seen;
  patch.for_each_neighbour(v, [&](LocalIndex x) { seen.push_back(x); });
  if (!boundary) {
    const auto start = std::find(seen.begin(), seen.end(), ring[0]);
    std::rotate(seen.begin(), start, seen.end());
  }
  if (seen != ring) return fmt::format("vertex {}: neighbours differ", v);
  Star star;
  if (!patch.star(v, star)) {
    return ring.size() > kMaxStarFaces ? "" : fmt::format("vertex {}: star refused", v);
  }
  if (star.wedges != outer.size() || star.boundary != boundary || star.ring_size() != ring.size())
    return fmt::format("vertex {}: size of the star", v);
  for (unsigned i = 0; i < star.wedges; ++i) {
    const LocalIndex c = star.corner[i];
    const unsigned k = i + 1 == star.ring_size() ? 0 : i + 1;
    if (patch.corner_vertex(c) != v || patch.corner_vertex(next_corner(c)) != star.ring[i] ||
        patch.corner_vertex(previous_corner(c)) != star.ring[k])
      return fmt::format("vertex {}: wedge {} of the star", v, i);
  }
  return {};
}

}  // namespace

CountedSurface count_surface(std::span<const Triangle> triangles) {
  CountedSurface result;
  std::map<HalfEdge, unsigned> count;
  std::map<VertexId, VertexId> parent;
  std::map<VertexId, std::vector<HalfEdge>> outer;
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (++count[{t[i], t[(i + 1) % 3]}] > 1) result.defect = "a half-edge occurs twice";
      parent.try_emplace(t[i], t[i]);
      outer[t[i]].emplace_back(t[(i + 1) % 3], t[(i + 2) % 3]);
    }
  }
  std::map<VertexId, VertexId> along;
  for (const auto& [edge, n] : count) {
    const VertexId a = root_of(parent, edge.first);
    const VertexId b = root_of(parent, edge.second);
    parent[std::max(a, b)] = std::min(a, b);
    if (!count.contains({edge.second, edge.first})) along[edge.first] = edge.second;
  }
  for (const auto& [v, edges] : outer) {
    if (ring_of(edges).empty()) result.defect = fmt::format("vertex {} has no single fan", v);
  }
  Topology& topology = result.topology;
  topology.vertices = parent.size();
  topology.faces = triangles.size();
  topology.boundary_edges = along.size();
  for (const auto& [v, p] : parent) topology.components += v == p;
  std::set<VertexId> walked;
  for (const auto& [start, head] : along) {
    if (walked.contains(start)) continue;
    ++topology.boundary_loops;
    for (VertexId v = start; along.contains(v) && walked.insert(v).second;) v = along.at(v);
  }
  return result;
}

std::vector<Triangle> alive_faces(const Patch& patch) {
  std::vector<Triangle> faces;
  for (LocalIndex f = 0; f < patch.face_slots(); ++f) {
    if (!patch.face_alive(f)) continue;
    const LocalTriangle& t = patch.face(f);
    faces.push_back({t[0], t[1], t[2]});
  }
  return faces;
}

std::string patch_defect(const Patch& patch) {
  std::string defect = check_corners(patch);
  std::vector<std::vector<HalfEdge>> outer(patch.vertex_slots());
  for (const Triangle& t : alive_faces(patch)) {
    for (std::size_t i = 0; i < 3; ++i) outer[t[i]].emplace_back(t[(i + 1) % 3], t[(i + 2) % 3]);
  }
  for (LocalIndex v = 0; v < patch.vertex_slots() && defect.empty(); ++v) {
    defect = check_vertex(patch, v, outer[v]);
  }
  return defect;
}

}  // namespace remaps::test
