#include "remaps/mesh/domain_level.h"

#include <algorithm>
#include <bit>

namespace remaps {
namespace {

/// Top bit of a 40-bit id: the vertex is foreign to the segment, or the face a ghost in it.
constexpr std::uint64_t kAway = std::uint64_t{1} << 39;

std::uint64_t checked_id(std::uint64_t id) {
  if (id >= kAway) throw GeometryError("more than 2^39 vertices or faces");
  return id;
}

constexpr std::size_t vertex_bytes(unsigned level) {
  return 5 + sizeof(Vec3f) + (level == 0 ? 0 : sizeof(Quadric));
}
constexpr std::size_t face_bytes(unsigned level) {
  return 15 + (level == 0 ? 5 : sizeof(float) + sizeof(FaceLink));
}

}  // namespace

void VertexIndex::reset(std::size_t expected) {
  const std::size_t size = std::bit_ceil(2 * expected + 2);
  key_.assign(size, ~VertexId{0});
  value_.assign(size, kNoIndex);
  mask_ = size - 1;
}

LocalIndex& VertexIndex::operator[](VertexId id) {
  std::uint64_t at = (id * 0x9E3779B97F4A7C15u) >> 20 & mask_;
  while (key_[at] != id && key_[at] != ~VertexId{0}) at = (at + 1) & mask_;
  key_[at] = id;
  return value_[at];
}

DomainLevel::DomainLevel(unsigned level, SpaceCut cut, const std::filesystem::path& directory,
                         std::uint64_t buffer_bytes, MemoryBudget& budget)
    : level_(level),
      cut_(std::move(cut)),
      vertex_file_(directory / ("domain-" + std::to_string(level) + "-vertices"), cut_.segments(),
                   buffer_bytes / 2, budget),
      face_file_(directory / ("domain-" + std::to_string(level) + "-faces"), cut_.segments(),
                 buffer_bytes / 2, budget),
      home_faces_(cut_.segments(), 0) {}

std::uint64_t DomainLevel::largest_segment() const {
  std::uint64_t largest = 0;
  for (std::size_t i = 0; i < segments(); ++i) {
    largest = std::max(largest, face_file_.bytes(i) / face_bytes(level_));
  }
  return largest;
}

void DomainLevel::put_vertex(std::size_t segment, const RoutedVertex& vertex,
                             const Quadric* quadric) {
  vertex_file_.append_record(segment, [&](store::Packer& packer) {
    packer.put40(checked_id(vertex.id) | (quadric == nullptr ? kAway : 0));
    packer.put(vertex.position);
    if (level_ > 0) packer.put(quadric == nullptr ? Quadric{} : *quadric);
  });
}

void DomainLevel::add_vertex(const RoutedVertex& vertex, const Quadric& quadric) {
  put_vertex(vertex.segment, vertex, &quadric);
  ++vertices_;
}

FaceLink DomainLevel::add_face(const std::array<RoutedVertex, 3>& corner,
                               const FacePayload& payload) {
  const std::uint32_t home = std::min({corner[0].segment, corner[1].segment, corner[2].segment});
  for (unsigned i = 0; i < 3; ++i) {
    const std::uint32_t segment = corner[i].segment;
    if ((i > 0 && segment == corner[0].segment) || (i > 1 && segment == corner[1].segment))
      continue;
    face_file_.append_record(segment, [&](store::Packer& packer) {
      packer.put40(corner[0].id | (segment == home ? 0 : kAway));
      packer.put40(corner[1].id);
      packer.put40(corner[2].id);
      if (level_ == 0) {
        packer.put40(checked_id(payload.input_face));
      } else {
        packer.put(payload.load);
        packer.put(payload.origin);
      }
    });
    for (const RoutedVertex& other : corner) {
      if (other.segment != segment) put_vertex(segment, other, nullptr);
    }
  }
  ++faces_;
  mixed_faces_ += corner[0].segment != corner[1].segment || corner[0].segment != corner[2].segment;
  return {home, home_faces_[home]++};
}

void DomainLevel::load(std::size_t segment, VertexIndex& scratch, Segment& out,
                       std::vector<FaceLink>& origin) {
  out.clear();
  origin.clear();
  load_vertices(segment, scratch, out);
  load_faces(segment, scratch, out, origin);
  out.locked.assign(out.vertex_id.size(), 0);
  for (const LocalTriangle& t : out.triangle) {
    if (std::max({t[0], t[1], t[2]}) < out.own_vertices) continue;
    for (const LocalIndex v : t) out.locked[v] = 1;
  }
}

void DomainLevel::load_vertices(std::size_t segment, VertexIndex& scratch, Segment& out) {
  thread_local store::Bytes bytes;
  vertex_file_.take(segment, bytes);
  const std::size_t records = bytes.size() / vertex_bytes(level_);
  scratch.reset(records);
  for (const bool away : {false, true}) {
    store::Unpacker unpacker(bytes, "domain vertices");
    for (std::size_t i = 0; i < records; ++i) {
      const std::uint64_t id = unpacker.get40();
      const auto position = unpacker.get<Vec3f>();
      const auto quadric = level_ > 0 ? unpacker.get<Quadric>() : Quadric{};
      if (((id & kAway) != 0) != away) continue;
      LocalIndex& local = scratch[id & ~kAway];
      if (local != kNoIndex) continue;
      local = static_cast<LocalIndex>(out.vertex_id.size());
      out.vertex_id.push_back(id & ~kAway);
      out.position.push_back(position);
      if (level_ > 0) out.quadric.push_back(quadric);
    }
    if (!away) out.own_vertices = static_cast<LocalIndex>(out.vertex_id.size());
  }
}

void DomainLevel::load_faces(std::size_t segment, VertexIndex& scratch, Segment& out,
                             std::vector<FaceLink>& origin) {
  thread_local store::Bytes bytes;
  face_file_.take(segment, bytes);
  const std::size_t records = bytes.size() / face_bytes(level_);
  for (const bool away : {false, true}) {
    store::Unpacker unpacker(bytes, "domain faces");
    for (std::size_t i = 0; i < records; ++i) {
      const std::uint64_t first = unpacker.get40();
      const std::uint64_t second = unpacker.get40();
      const std::uint64_t third = unpacker.get40();
      FacePayload payload;
      if (level_ == 0) {
        payload.input_face = unpacker.get40();
      } else {
        payload.load = unpacker.get<float>();
        payload.origin = unpacker.get<FaceLink>();
      }
      if (((first & kAway) != 0) != away) continue;
      out.triangle.push_back({scratch[first & ~kAway], scratch[second], scratch[third]});
      if (level_ == 0) {
        out.face_id.push_back(payload.input_face);
      } else {
        out.load.push_back(payload.load);
        if (!away) origin.push_back(payload.origin);
      }
    }
    if (!away) out.home_faces = static_cast<LocalIndex>(out.triangle.size());
  }
}

}  // namespace remaps
