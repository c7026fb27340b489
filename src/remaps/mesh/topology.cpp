#include "remaps/mesh/topology.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t x) {
  while (parent[x] != x) {
    parent[x] = parent[parent[x]];
    x = parent[x];
  }
  return x;
}

void unite(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  a = find_root(parent, a);
  b = find_root(parent, b);
  if (a != b) parent[std::max(a, b)] = std::min(a, b);
}

/// Numbers the components among the marked vertices and lists those that other segments see too.
std::uint32_t number_labels(const Segment& segment, std::vector<std::uint32_t>& parent,
                            const std::vector<std::uint8_t>& marked,
                            std::vector<std::pair<VertexId, std::uint32_t>>& shared) {
  std::vector<std::uint32_t> label(parent.size(), kNoIndex);
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < parent.size(); ++v) {
    if (!marked[v]) continue;
    const std::uint32_t root = find_root(parent, v);
    if (label[root] == kNoIndex) label[root] = count++;
    if (segment.locked[v]) shared.emplace_back(segment.vertex_id[v], label[root]);
  }
  return count;
}

}  // namespace

SegmentTopology count_segment(const Segment& s, const Patch& patch) {
  SegmentTopology result;
  const std::size_t n = s.vertex_id.size();
  std::vector<std::uint32_t> parent(n);
  std::vector<std::uint8_t> marked(n, 0);
  std::iota(parent.begin(), parent.end(), 0u);
  for (const LocalTriangle& t : s.triangle) {
    unite(parent, t[0], t[1]);
    unite(parent, t[1], t[2]);
    for (const LocalIndex v : t) marked[v] = 1;
  }
  for (LocalIndex v = 0; v < s.own_vertices; ++v) result.vertices += marked[v];
  result.faces = s.home_faces;
  result.components = number_labels(s, parent, marked, result.shared_component);

  std::iota(parent.begin(), parent.end(), 0u);
  std::fill(marked.begin(), marked.end(), std::uint8_t{0});
  const auto end = corner_of(static_cast<LocalIndex>(s.triangle.size()), 0);
  for (LocalIndex c = 0; c < end; c = after_corner(c)) {
    if (patch.opposite(c) != kNoIndex) continue;
    const LocalIndex a = patch.corner_vertex(next_corner(c));
    const LocalIndex b = patch.corner_vertex(previous_corner(c));
    if (std::min(a, b) >= s.own_vertices)
      continue;  // another segment knows whether this is a boundary
    unite(parent, a, b);
    marked[a] = marked[b] = 1;
    const LocalIndex lower = s.vertex_id[a] < s.vertex_id[b] ? a : b;
    if (lower < s.own_vertices) ++result.boundary_edges;
  }
  result.boundary_chains = number_labels(s, parent, marked, result.shared_chain);
  return result;
}

LabelJoin::LabelJoin(const std::filesystem::path& path, std::uint64_t expected_vertices,
                     std::uint64_t buffer_bytes, MemoryBudget& budget)
    : file_(path, static_cast<std::size_t>(expected_vertices / (1 << 22) + 1), buffer_bytes,
            budget) {}

void LabelJoin::add(std::uint32_t labels,
                    std::span<const std::pair<VertexId, std::uint32_t>> shared) {
  if (labels > kNoIndex - parent_.size()) {
    throw GeometryError("the segments have 2^32 components or boundary chains and more");
  }
  const auto base = static_cast<std::uint32_t>(parent_.size());
  parent_.resize(base + labels);
  std::iota(parent_.begin() + base, parent_.end(), base);
  for (const auto& [id, label] : shared) {
    const std::size_t bucket = (id * 0x9E3779B97F4A7C15u >> 32) % file_.buckets();
    file_.append_record(bucket, [&, label = label, id = id](store::Packer& packer) {
      packer.put40(id);
      packer.put(base + label);
    });
  }
}

std::uint64_t LabelJoin::finish() {
  store::Bytes bytes;
  std::vector<std::pair<VertexId, std::uint32_t>> entries;
  for (std::size_t bucket = 0; bucket < file_.buckets(); ++bucket) {
    file_.take(bucket, bytes);
    entries.clear();
    store::Unpacker unpacker(bytes, "shared vertices");
    while (!unpacker.done()) {
      const VertexId id = unpacker.get40();
      entries.emplace_back(id, unpacker.get<std::uint32_t>());
    }
    std::sort(entries.begin(), entries.end());
    for (std::size_t i = 1; i < entries.size(); ++i) {
      if (entries[i].first == entries[i - 1].first)
        unite(parent_, entries[i].second, entries[i - 1].second);
    }
  }
  std::uint64_t count = 0;
  for (std::uint32_t x = 0; x < parent_.size(); ++x) count += parent_[x] == x;
  return count;
}

TopologyCounter::TopologyCounter(const std::filesystem::path& directory,
                                 std::uint64_t expected_vertices, std::uint64_t buffer_bytes,
                                 MemoryBudget& budget)
    : components_(directory / "shared-components", expected_vertices, buffer_bytes / 2, budget),
      chains_(directory / "shared-boundaries", expected_vertices, buffer_bytes / 2, budget) {}

void TopologyCounter::add(const SegmentTopology& part) {
  total_.vertices += part.vertices;
  total_.faces += part.faces;
  total_.boundary_edges += part.boundary_edges;
  components_.add(part.components, part.shared_component);
  chains_.add(part.boundary_chains, part.shared_chain);
}

Topology TopologyCounter::finish() {
  total_.components = components_.finish();
  total_.boundary_loops = chains_.finish();
  return total_;
}

}  // namespace remaps
