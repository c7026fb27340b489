#include "remaps/mesh/domain_level.h"

#include <algorithm>
#include <bit>

#include "remaps/mesh/delta_code.h"

namespace remaps {
namespace {

/// Ids have 39 bits, so that they and a flag fit the codes.
constexpr std::uint64_t kIdLimit = std::uint64_t{1} << 39;
/// The largest record: all codes at full length, and what else it has.
constexpr std::size_t kLargestRecord = 64;
/// A table over the range of ids may have so many entries for each id that is there.
constexpr std::uint64_t kSparsest = 16;

std::uint64_t checked_id(std::uint64_t id) {
  if (id >= kIdLimit) throw GeometryError("more than 2^39 vertices or faces");
  return id;
}

template <class T>
void put(std::byte*& at, const T& value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}
template <class T>
T get(const std::byte*& at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

/// True when a face may yet need its label: at the first level, or where it does not know all its
/// edges (see feature_edges.h).
bool needs_label(unsigned level, std::uint8_t feature) {
  return level == 0 || unsigned{feature} >> 3 != 0;
}

/// The bytes of a bucket with room behind them, so that a decoder looks at the end once a record.
struct Records {
  const std::byte* at;
  const std::byte* end;

  Records(store::BucketFile& file, std::size_t bucket, store::Bytes& bytes) {
    file.read(bucket, 0, file.bytes(bucket), bytes);
    const std::size_t size = bytes.size();
    bytes.resize(size + kLargestRecord);
    at = bytes.data();
    end = at + size;
  }
  void check(bool good) const {
    if (!good || at > end) throw CorruptionError("domain records do not agree with their count");
  }
};

}  // namespace

void VertexIndex::reset(std::size_t expected, VertexId low, VertexId high) {
  const std::uint64_t range = high - low;
  dense_ = low <= high && range < kSparsest * (expected + std::uint64_t{16});
  low_ = low;
  if (dense_) {
    table_.assign(static_cast<std::size_t>(range) + 1, kNoIndex);
    return;
  }
  const std::size_t size = std::bit_ceil(2 * expected + 2);
  entries_.assign(size, {~VertexId{0}, kNoIndex});
  mask_ = size - 1;
}

DomainLevel::DomainLevel(unsigned level, SpaceCut cut, const std::filesystem::path& directory,
                         std::uint64_t buffer_bytes, MemoryBudget& budget)
    : level_(level),
      cut_(std::move(cut)),
      reservation_(budget.reserve(cut_.segments() * sizeof(Bucket), "the list of segments")),
      vertex_file_(directory / ("domain-" + std::to_string(level) + "-vertices"), cut_.segments(),
                   buffer_bytes / 2, budget),
      face_file_(directory / ("domain-" + std::to_string(level) + "-faces"), cut_.segments(),
                 buffer_bytes / 2, budget),
      buckets_(cut_.segments()) {}

std::uint64_t DomainLevel::largest_segment() const {
  std::uint64_t largest = 0;
  for (const Bucket& bucket : buckets_) largest = std::max<std::uint64_t>(largest, bucket.faces);
  return largest;
}

void DomainLevel::put_vertex(std::size_t segment, const RoutedVertex& vertex,
                             const Quadric* quadric) {
  Bucket& bucket = buckets_[segment];
  const VertexId id = checked_id(vertex.id);
  std::byte record[kLargestRecord];
  std::byte* at = record;
  const std::uint64_t delta = delta_code(id, bucket.vertex);
  at = put_varint(at, delta << 1 | (quadric == nullptr));
  put(at, vertex.position);
  if (level_ > 0 && quadric != nullptr) put(at, *quadric);
  vertex_file_.append(segment, {record, at});
  bucket.vertex = id;
  bucket.low = std::min(bucket.low, id);
  bucket.high = std::max(bucket.high, id);
  bucket.own_vertices += quadric != nullptr;
  ++bucket.vertex_records;
}

void DomainLevel::add_vertex(const RoutedVertex& vertex, const Quadric& quadric) {
  put_vertex(vertex.segment, vertex, &quadric);
  ++vertices_;
}

void DomainLevel::put_face(std::size_t segment, const std::array<RoutedVertex, 3>& corner,
                           const FacePayload& payload, bool home) {
  Bucket& bucket = buckets_[segment];
  std::byte record[kLargestRecord];
  std::byte* at = record;
  FaceId face = bucket.face;
  if (level_ == 0) {
    face = checked_id(payload.input_face);
  } else if (home) {
    face = payload.origin.face;
  }
  const std::uint64_t first = delta_code(checked_id(corner[0].id), bucket.corner);
  at = put_codes(
      at, {first << 1 | !home, delta_code(checked_id(corner[1].id), corner[0].id),
           delta_code(checked_id(corner[2].id), corner[0].id), delta_code(face, bucket.face)});
  if (level_ > 0) {
    put(at, payload.load);
    if (features_) put(at, payload.feature);
    if (home) {
      at = put_varint(at, delta_code(payload.origin.segment, bucket.origin));
      bucket.origin = payload.origin.segment;
    }
  }
  if (labels_ && needs_label(level_, payload.feature)) {
    const bool other = payload.label != bucket.label;
    put(at, static_cast<std::uint8_t>(other));
    if (other) put(at, payload.label);
    bucket.label = payload.label;
  }
  face_file_.append(segment, {record, at});
  bucket.corner = corner[0].id;
  bucket.face = face;
  ++bucket.faces;
  bucket.home_faces += home;
}

FaceLink DomainLevel::add_face(const std::array<RoutedVertex, 3>& corner,
                               const FacePayload& payload) {
  const FaceLink link = add_face_alone(corner, payload);
  if (corner[0].segment == corner[1].segment && corner[0].segment == corner[2].segment) return link;
  foreign_corners(corner, [&](std::uint32_t segment, const RoutedVertex& vertex) {
    put_vertex(segment, vertex, nullptr);
  });
  return link;
}

FaceLink DomainLevel::add_face_alone(const std::array<RoutedVertex, 3>& corner,
                                     const FacePayload& payload) {
  const std::uint32_t a = corner[0].segment;
  const std::uint32_t b = corner[1].segment;
  const std::uint32_t c = corner[2].segment;
  const std::uint32_t home = std::min({a, b, c});
  const FaceLink link{home, buckets_[home].home_faces};
  put_face(a, corner, payload, a == home);
  ++faces_;
  if (a == b && a == c) return link;
  ++mixed_faces_;
  if (b != a) put_face(b, corner, payload, b == home);
  if (c != a && c != b) put_face(c, corner, payload, c == home);
  return link;
}

void DomainLevel::load(std::size_t segment, VertexIndex& scratch, Segment& out,
                       std::vector<FaceLink>& origin, After after) {
  out.clear();
  origin.clear();
  load_vertices(segment, scratch, out);
  load_faces(segment, scratch, out, origin);
  if (after == After::kFree) {
    vertex_file_.release(segment);
    face_file_.release(segment);
    buckets_[segment] = {};
  }
  out.locked.assign(out.vertex_id.size(), 0);
  for (const LocalTriangle& t : out.triangle) {
    if (std::max({t[0], t[1], t[2]}) < out.own_vertices) continue;
    for (const LocalIndex v : t) out.locked[v] = 1;
  }
}

void DomainLevel::load_vertices(std::size_t segment, VertexIndex& scratch, Segment& out) {
  const Bucket& bucket = buckets_[segment];
  thread_local store::Bytes bytes;
  Records records(vertex_file_, segment, bytes);
  scratch.reset(bucket.vertex_records, bucket.low, bucket.high);
  const LocalIndex own = out.own_vertices = bucket.own_vertices;
  out.vertex_id.resize(own);
  out.position.resize(own);
  if (level_ > 0) out.quadric.resize(own);
  VertexId id = 0;
  LocalIndex next = 0;
  for (LocalIndex i = 0; i < bucket.vertex_records; ++i) {
    std::uint64_t code = 0;
    records.at = get_varint(records.at, code);
    id = apply_delta(code >> 1, id);
    const auto position = get<Vec3f>(records.at);
    records.check(id >= bucket.low && id <= bucket.high);
    LocalIndex& local = scratch[id];
    if ((code & 1) == 0) {
      records.check(next < own && local == kNoIndex);
      local = next++;
      out.vertex_id[local] = id;
      out.position[local] = position;
      if (level_ > 0) out.quadric[local] = get<Quadric>(records.at);
    } else if (local == kNoIndex) {
      local = static_cast<LocalIndex>(out.vertex_id.size());
      out.vertex_id.push_back(id);
      out.position.push_back(position);
      if (level_ > 0) out.quadric.push_back({});
    }
  }
  records.check(next == own && records.at == records.end);
}

void DomainLevel::load_faces(std::size_t segment, VertexIndex& scratch, Segment& out,
                             std::vector<FaceLink>& origin) {
  const Bucket& bucket = buckets_[segment];
  thread_local store::Bytes bytes;
  Records records(face_file_, segment, bytes);
  LocalIndex home = 0;
  LocalIndex ghost = out.home_faces = bucket.home_faces;
  out.triangle.resize(bucket.faces);
  level_ == 0 ? out.face_id.resize(bucket.faces) : out.load.resize(bucket.faces);
  if (level_ > 0) origin.resize(bucket.home_faces);
  if (features_) out.feature.resize(bucket.faces);
  if (labels_) out.label.assign(bucket.faces, kNoLabel);
  const auto local = [&](VertexId id) {
    records.check(id >= bucket.low && id <= bucket.high);
    return scratch[id];
  };
  VertexId corner = 0;
  FaceLink link;
  FaceId face = 0;
  FaceLabel label = kNoLabel;
  const auto read_label = [&](LocalIndex f) {
    if (!labels_ || !needs_label(level_, features_ ? out.feature[f] : std::uint8_t{0})) return;
    if (get<std::uint8_t>(records.at) != 0) label = get<FaceLabel>(records.at);
    out.label[f] = label;
  };
  for (LocalIndex i = 0; i < bucket.faces; ++i) {
    std::array<std::uint64_t, 4> code;
    records.at = get_codes(records.at, code);
    const bool is_home = (code[0] & 1) == 0;
    corner = apply_delta(code[0] >> 1, corner);
    face = apply_delta(code[3], face);
    const LocalIndex f = is_home ? home++ : ghost++;
    records.check(is_home ? f < bucket.home_faces : f < bucket.faces);
    out.triangle[f] = {local(corner), local(apply_delta(code[1], corner)),
                       local(apply_delta(code[2], corner))};
    if (level_ == 0) {
      out.face_id[f] = face;
      read_label(f);
      continue;
    }
    out.load[f] = get<float>(records.at);
    if (features_) out.feature[f] = get<std::uint8_t>(records.at);
    if (is_home) {
      std::uint64_t step = 0;
      records.at = get_varint(records.at, step);
      link.segment = static_cast<std::uint32_t>(apply_delta(step, link.segment));
      link.face = static_cast<LocalIndex>(face);
      origin[f] = link;
    }
    read_label(f);
  }
  records.check(records.at == records.end);
}

}  // namespace remaps
