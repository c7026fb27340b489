#include "remaps/map/level_map.h"

#include <algorithm>

#include "remaps/base/workers.h"

namespace remaps::map {
namespace {

/// A run of points of one segment: the unit of work.
struct Piece {
  std::size_t segment;
  std::uint64_t first;
  std::uint64_t count;
  bool last_of_segment;
};

constexpr FaceLink kDropped{kNoIndex, kNoIndex};

/// Each face is dropped by one record or survives; so the count is known before memory is taken for
/// it.
void check_face_count(const SegmentLog& log, const std::string& what) {
  std::uint64_t faces = log.survivor.size();
  for (std::size_t r = 0; r < log.records.size(); ++r) faces += log.records.boundary(r) ? 1u : 2u;
  if (faces != log.faces) {
    throw CorruptionError(what + ": " + std::to_string(log.faces) + " faces, but " +
                          std::to_string(faces) + " survive or are dropped");
  }
}

/// Hands out the segment that the pieces in work need; those of one segment share it.
class SegmentCache {
 public:
  SegmentCache(const LevelMap& level, SegmentMap::Direction direction)
      : level_(level), direction_(direction) {}

  std::shared_ptr<const LoadedSegment> get(std::size_t segment) {
    const std::scoped_lock lock(mutex_);
    if (latest_ == nullptr || latest_segment_ != segment) {
      latest_.reset();
      latest_ = level_.load(segment, direction_);
      latest_segment_ = segment;
    }
    return latest_;
  }

 private:
  const LevelMap& level_;
  const SegmentMap::Direction direction_;
  std::mutex mutex_;
  std::size_t latest_segment_ = 0;
  std::shared_ptr<const LoadedSegment> latest_;
};

template <class Count>
std::vector<Piece> cut_into_pieces(std::size_t segments, std::size_t size, Count&& count) {
  std::vector<Piece> pieces;
  for (std::size_t segment = 0; segment < segments; ++segment) {
    const std::uint64_t total = count(segment);
    for (std::uint64_t first = 0; first < total; first += size) {
      const std::uint64_t n = std::min<std::uint64_t>(size, total - first);
      pieces.push_back({segment, first, n, first + n == total});
    }
  }
  return pieces;
}

}  // namespace

std::shared_ptr<const LoadedSegment> LevelMap::load(std::size_t segment,
                                                    SegmentMap::Direction direction) const {
  const std::string what = log_->path().string() + ": segment " + std::to_string(segment);
  auto loaded = std::make_shared<LoadedSegment>();
  store::Bytes bytes;
  log_->read(2 * segment, bytes);
  decode_records(bytes, what, loaded->log);
  log_->read(2 * segment + 1, bytes);
  decode_survivors(bytes, what, loaded->log);
  const SegmentLog& log = loaded->log;
  check_face_count(log, what);
  if (direction == SegmentMap::Direction::kForward) {
    loaded->link.assign(log.faces, kDropped);
    for (std::size_t i = 0; i < log.survivor.size(); ++i)
      loaded->link[log.survivor[i]] = log.next[i];
  } else if (log.level == 0) {
    loaded->link.resize(log.faces);
    for (LocalIndex f = 0; f < log.faces; ++f)
      loaded->link[f] = {static_cast<std::uint32_t>(segment), f};
  } else {
    loaded->link = log.origin;
  }
  loaded->map.build(log.records, log.faces, direction);
  loaded->log.records = {};  // the map has its own form of them
  return loaded;
}

std::uint64_t LevelMap::expected_bytes(std::size_t segment) const {
  // A record's words are some more in the map's form; and survivors have links in two places.
  return log_->raw_bytes(2 * segment) * 3 / 2 + log_->raw_bytes(2 * segment + 1) * 2;
}

void LoadedSegment::carry(std::span<FacePoint> points) const {
  for (const FacePoint& point : points) {
    if (point.face >= link.size())
      throw CorruptionError("a surface point lies on a face that does not exist");
  }
  map.carry(points);
  for (const FacePoint& point : points) {
    if (link[point.face] == kDropped)
      throw CorruptionError("a surface point ends on a face that was dropped");
  }
}

std::uint64_t LoadedSegment::bytes() const {
  return map.bytes() + link.size() * sizeof(FaceLink) + log.origin.size() * sizeof(FaceLink) +
         log.removed.size() * sizeof(VertexId) + log.survivor.size() * sizeof(LocalIndex) +
         log.next.size() * sizeof(FaceLink);
}

void carry_points(const LevelMap& level, SegmentMap::Direction direction, PointSupply& in,
                  const CarryOptions& options, const PointSink& sink) {
  SegmentCache cache(level, direction);
  const std::vector<Piece> pieces = cut_into_pieces(
      in.segments(), options.map_buffer, [&](std::size_t segment) { return in.count(segment); });
  run_ordered(pieces.size(), options.threads, [&](std::size_t i, unsigned) -> Commit {
    if (options.progress != nullptr) options.progress->check();
    const Piece& piece = pieces[i];
    auto points = std::make_shared<std::vector<TaggedPoint>>();
    in.read(piece.segment, piece.first, piece.count, *points);
    const std::shared_ptr<const LoadedSegment> loaded = cache.get(piece.segment);
    std::vector<FacePoint> at;
    at.reserve(points->size());
    for (const TaggedPoint& point : *points) at.push_back(point.at);
    loaded->carry(at);
    for (std::size_t k = 0; k < at.size(); ++k) (*points)[k].at = at[k];
    return [&, points, loaded, i] {
      for (TaggedPoint& point : *points) {
        const FaceLink link = loaded->link[point.at.face];
        point.at.face = link.face;
        sink(link, point);
      }
      if (pieces[i].last_of_segment) in.release(pieces[i].segment);
      if (options.progress != nullptr)
        options.progress->advance(double(i + 1) / double(pieces.size()));
    };
  });
}

}  // namespace remaps::map
