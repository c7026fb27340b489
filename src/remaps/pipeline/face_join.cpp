#include "remaps/pipeline/face_join.h"

#include <algorithm>

#include "remaps/mesh/delta_code.h"
#include "remaps/store/bucket_records.h"

namespace remaps::pipeline {
namespace {

constexpr std::size_t kLargestRecord = 64;

std::uint64_t table_bytes(const MemoryPlan& plan) {
  return plan.budget_bytes / 2;
}

std::uint64_t divide_up(std::uint64_t a, std::uint64_t b) {
  return (a + b - 1) / b;
}

/// Decodes what waits in a bucket, and frees it.
template <class Decode>
void for_each_record(store::BucketFile& file, std::size_t bucket, Decode&& decode) {
  store::for_each_record(file, bucket, kLargestRecord, "waiting faces", decode);
  file.release(bucket);
}

}  // namespace

void SegmentTable::reset(std::size_t segments, std::size_t vertices) {
  narrow_ = bytes_per_vertex(segments) == 2;
  narrow_ ? two_.resize(vertices) : four_.resize(vertices);
}

std::uint64_t FaceJoin::ranges(std::uint64_t vertices, std::size_t segments,
                               const MemoryPlan& plan) {
  return std::max<std::uint64_t>(
      divide_up(vertices * SegmentTable::bytes_per_vertex(segments), table_bytes(plan)), 1);
}

FaceJoin::FaceJoin(const VertexSpool& spool, DomainLevel& level, bool add_vertices,
                   const MemoryPlan& plan, const std::filesystem::path& directory,
                   MemoryBudget& budget)
    : spool_(spool),
      level_(level),
      add_vertices_(add_vertices),
      ranges_(ranges(spool.vertices(), level.segments(), plan)),
      range_size_(divide_up(spool.vertices(), ranges_)),
      fetch_size_(std::min(table_bytes(plan) / sizeof(Vec3f), spool.vertices())),
      reservation_(
          budget.reserve(std::max(range_size_ * SegmentTable::bytes_per_vertex(level.segments()),
                                  fetch_size_ * std::uint64_t{sizeof(Vec3f)}),
                         "joining faces with their vertices")),
      foreign_(directory / "foreign-corners", divide_up(spool.vertices(), fetch_size_),
               plan.bucket_bytes / 4, budget) {
  if (ranges_ > 1) {
    waiting_ = std::make_unique<store::BucketFile>(directory / "waiting-faces", ranges_,
                                                   plan.bucket_bytes / 2, budget);
  }
  load_range(0);
}

void FaceJoin::load_range(std::uint64_t range) {
  constexpr std::uint64_t kChunk = 1 << 14;
  present_ = range;
  const std::uint64_t first = range * range_size_;
  const std::uint64_t count = std::min(range_size_, spool_.vertices() - first);
  table_.reset(level_.segments(), static_cast<std::size_t>(range_size_));
  std::vector<Vec3f> chunk;
  for (std::uint64_t at = 0; at < count; at += kChunk) {
    chunk.resize(static_cast<std::size_t>(std::min(kChunk, count - at)));
    spool_.read(first + at, chunk);
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const std::uint32_t segment = level_.cut().segment_of(chunk[i]);
      table_.set(static_cast<std::size_t>(at) + i, segment);
      if (add_vertices_ && is_finite(chunk[i]))
        level_.add_vertex({first + at + i, chunk[i], segment}, {});
    }
  }
}

void FaceJoin::add(const Triangle& t, FaceId face, FaceLabel label) {
  if (ranges_ > 1) {
    Waiting waiting{t, face, label, {}};
    advance(waiting);
    return;
  }
  std::array<RoutedVertex, 3> corner;
  for (unsigned i = 0; i < 3; ++i) corner[i] = {t[i], {}, table_[static_cast<std::size_t>(t[i])]};
  route(corner, face, label);
}

void FaceJoin::route(const std::array<RoutedVertex, 3>& corner, FaceId face, FaceLabel label) {
  level_.add_face_alone(corner, {face, 0, {}, 0, label});
  if (corner[0].segment == corner[1].segment && corner[0].segment == corner[2].segment) return;
  DomainLevel::foreign_corners(corner, [&](std::uint32_t segment, const RoutedVertex& v) {
    std::byte record[kLargestRecord];
    std::byte* end = put_varint(put_varint(record, v.id % fetch_size_), segment);
    foreign_.append(static_cast<std::size_t>(v.id / fetch_size_), {record, end});
  });
}

/// Fills in the corners of the present range; then the face is done or waits for the next.
void FaceJoin::advance(Waiting& waiting) {
  std::uint64_t next = ~std::uint64_t{0};
  std::array<RoutedVertex, 3> corner;
  for (unsigned i = 0; i < 3; ++i) {
    const std::uint64_t range = waiting.corner[i] / range_size_;
    if (range == present_) {
      waiting.segment_code[i] =
          table_[static_cast<std::size_t>(waiting.corner[i] - range * range_size_)] + 1;
    }
    if (waiting.segment_code[i] == 0) next = std::min(next, range);
    corner[i] = {waiting.corner[i], {}, waiting.segment_code[i] - 1};
  }
  if (next != ~std::uint64_t{0}) return put(next, waiting);
  route(corner, waiting.face, waiting.label);
}

void FaceJoin::put(std::uint64_t range, const Waiting& waiting) {
  std::byte record[kLargestRecord];
  const Triangle& t = waiting.corner;
  std::byte* end =
      put_codes(record, {t[0], delta_code(t[1], t[0]), delta_code(t[2], t[0]), waiting.face});
  for (const std::uint32_t code : waiting.segment_code) end = put_varint(end, code);
  if (level_.has_labels()) end = put_varint(end, waiting.label);
  waiting_->append(static_cast<std::size_t>(range), {record, end});
}

void FaceJoin::work_through(std::uint64_t range) {
  load_range(range);
  for_each_record(*waiting_, static_cast<std::size_t>(range), [&](const std::byte* at) {
    Waiting waiting;
    std::array<std::uint64_t, 4> code;
    at = get_codes(at, code);
    waiting.corner = {code[0], apply_delta(code[1], code[0]), apply_delta(code[2], code[0])};
    waiting.face = code[3];
    for (std::uint32_t& segment : waiting.segment_code) {
      std::uint64_t value = 0;
      at = get_varint(at, value);
      segment = static_cast<std::uint32_t>(value);
    }
    if (level_.has_labels()) at = get_varint(at, waiting.label);
    advance(waiting);
    return at;
  });
}

void FaceJoin::add_foreign(std::uint64_t range) {
  const std::uint64_t first = range * fetch_size_;
  std::vector<Vec3f> position(
      static_cast<std::size_t>(std::min(fetch_size_, spool_.vertices() - first)));
  spool_.read(first, position);
  for_each_record(foreign_, static_cast<std::size_t>(range), [&](const std::byte* at) {
    std::uint64_t id = 0;
    std::uint64_t segment = 0;
    at = get_varint(get_varint(at, id), segment);
    if (id >= position.size() || segment >= level_.segments())
      throw CorruptionError("a foreign corner is out of range");
    const Vec3f& p = position[static_cast<std::size_t>(id)];
    level_.add_foreign(static_cast<std::size_t>(segment), {first + id, p, 0});
    return at;
  });
}

void FaceJoin::finish(const std::function<void(double)>& progress) {
  const auto fetches = foreign_.buckets();
  const double steps = double(ranges_ - 1 + fetches);
  for (std::uint64_t range = 1; range < ranges_; ++range) {
    work_through(range);
    progress(double(range) / steps);
  }
  table_ = {};
  waiting_.reset();
  for (std::size_t range = 0; range < fetches; ++range) {
    if (foreign_.bytes(range) > 0) add_foreign(range);
    progress(double(ranges_ + range) / steps);
  }
}

}  // namespace remaps::pipeline
