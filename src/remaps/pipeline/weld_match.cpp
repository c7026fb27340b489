#include "remaps/pipeline/weld_match.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace remaps::pipeline {
namespace {

constexpr std::size_t kBuckets = 256;
/// Cells along a side of a block; all of a block go to one bucket.
constexpr double kBlock = 32;

std::size_t bucket_of(std::uint64_t hash) {
  return static_cast<std::size_t>(hash >> 56);
}

Vec3f canonical(const Vec3f& p) {
  return {p.x + 0.0F, p.y + 0.0F, p.z + 0.0F};
}
Vec3 canonical(const Vec3& p) {
  return {p.x + 0.0, p.y + 0.0, p.z + 0.0};
}

template <class Point>
bool same_bits(const Point& a, const Point& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

template <class Point>
bool is_finite(const Point& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

Vec3 to_double(const Vec3& p) {
  return p;
}
Vec3 to_double(const Vec3f& p) {
  return widen(p);
}

/// Calls what(dx, dy, dz) for a cell and its 26 neighbours.
template <class What>
void for_each_neighbour(What what) {
  for (double dx = -1; dx <= 1; ++dx) {
    for (double dy = -1; dy <= 1; ++dy) {
      for (double dz = -1; dz <= 1; ++dz) what(Vec3{dx, dy, dz});
    }
  }
}

Vec3 floor_of(const Vec3& p) {
  return canonical(Vec3{std::floor(p.x), std::floor(p.y), std::floor(p.z)});
}

std::size_t bucket_of_cell(const Vec3& cell) {
  return bucket_of(hash_of(floor_of((1 / kBlock) * cell)));
}

}  // namespace

template <class Point>
EqualMatcher<Point>::EqualMatcher(const WeldScratch& scratch)
    : scratch_(scratch),
      file_(scratch.directory / "weld-places", kBuckets, scratch.memory_bytes / 4, *scratch.budget),
      before_(kBuckets, 0) {}

template <class Point>
void EqualMatcher<Point>::put(store::BucketFile& file, std::size_t bucket, VertexId& before,
                              VertexId v, const Point& p) {
  std::byte record[kLargestWeldRecord];
  std::byte* end = put_varint(record, v - before);
  file.append(bucket, {record, put_point(end, p)});
  before = v;
}

template <class Point>
void EqualMatcher<Point>::add(VertexId v, const Point& p) {
  const Point place = canonical(p);
  const std::size_t bucket = bucket_of(hash_of(place));
  put(file_, bucket, before_[bucket], v, place);
}

template <class Point>
void EqualMatcher<Point>::match_bucket(const store::BucketFile& file, std::size_t bucket,
                                       LinkBuckets<Point>& links) {
  place_.clear();
  const std::uint64_t records = file.bytes(bucket) / (sizeof(Point) + 1);
  const std::uint64_t places = std::min<std::uint64_t>(records, most_places_);
  place_.reserve(static_cast<std::size_t>(places));
  slot_.assign(std::bit_ceil(static_cast<std::size_t>(2 * places + 2)), kNoIndex);
  VertexId v = 0;
  for_each_weld_record(file, bucket, [&](const std::byte* at) {
    std::uint64_t step = 0;
    Point p;
    at = get_point(get_varint(at, step), p);
    v += step;
    if (!is_finite(p)) {
      links.add_root(v, p);
      return at;
    }
    std::size_t s = static_cast<std::size_t>(hash_of(p)) & (slot_.size() - 1);
    while (slot_[s] != kNoIndex && !same_bits(place_[slot_[s]].p, p))
      s = (s + 1) & (slot_.size() - 1);
    if (slot_[s] != kNoIndex) {
      links.add_link(v, place_[slot_[s]].first);
    } else if (place_.size() < places) {
      slot_[s] = static_cast<std::uint32_t>(place_.size());
      place_.push_back({p, v});
      links.add_root(v, p);
    } else {
      put(*rest_, rest_half_, before_in_rest_, v, p);
    }
    return at;
  });
}

template <class Point>
void EqualMatcher<Point>::match(LinkBuckets<Point>& links, FunctionRef<void(double)> progress) {
  // Of a place: itself, and up to four slots.
  constexpr std::uint64_t kPlaceBytes = sizeof(Place) + 4 * sizeof(std::uint32_t);
  const std::uint64_t memory = scratch_.memory_bytes * 3 / 8;
  most_places_ = static_cast<std::size_t>(
      std::clamp<std::uint64_t>(memory / kPlaceBytes, 1024, std::uint64_t{1} << 30));
  const Reservation reservation =
      scratch_.budget->reserve(most_places_ * kPlaceBytes, "the table of places to weld");
  rest_ = std::make_unique<store::BucketFile>(scratch_.directory / "weld-rest", 2,
                                              scratch_.memory_bytes / 64, *scratch_.budget);
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    progress(double(bucket) / kBuckets);
    match_bucket(file_, bucket, links);
    file_.release(bucket);
    while (rest_->bytes(rest_half_) > 0) {
      const std::size_t present = rest_half_;
      rest_half_ = 1 - present;
      before_in_rest_ = 0;
      match_bucket(*rest_, present, links);
      rest_->release(present);
    }
    before_in_rest_ = 0;
  }
  place_ = {};
  slot_ = {};
  rest_.reset();
}

template <class Point>
NearMatcher<Point>::NearMatcher(const WeldScratch& scratch, double distance)
    : scratch_(scratch),
      distance_(distance),
      // A little more, so that rounding never puts two near vertices two cells apart.
      side_(distance * (1 + 1.0 / 1024)),
      file_(scratch.directory / "weld-places", kBuckets, scratch.memory_bytes / 4, *scratch.budget),
      before_(kBuckets, 0) {}

template <class Point>
Vec3 NearMatcher<Point>::cell_of(const Point& p) const {
  const Vec3 q = to_double(p);
  return floor_of({q.x / side_, q.y / side_, q.z / side_});
}

template <class Point>
void NearMatcher<Point>::put(std::size_t bucket, VertexId v, const Point& p, bool home) {
  std::byte record[kLargestWeldRecord];
  std::byte* end = put_varint(record, (v - before_[bucket]) << 1 | (home ? 1 : 0));
  file_.append(bucket, {record, put_point(end, p)});
  before_[bucket] = v;
}

template <class Point>
void NearMatcher<Point>::add(VertexId v, const Point& p) {
  const Vec3 cell = cell_of(p);
  std::array<std::size_t, 27> sent;
  std::size_t n = 0;
  sent[n++] = bucket_of_cell(cell);
  put(sent[0], v, p, true);
  if (!is_finite(p)) return;
  const auto inside = [](double c) {
    const double at = c - kBlock * std::floor(c / kBlock);
    return at >= 1 && at <= kBlock - 2;
  };
  if (inside(cell.x) && inside(cell.y) && inside(cell.z)) return;
  for_each_neighbour([&](const Vec3& step) {
    const std::size_t bucket = bucket_of_cell(cell + step);
    if (std::find(sent.begin(), sent.begin() + static_cast<std::ptrdiff_t>(n), bucket) !=
        sent.begin() + static_cast<std::ptrdiff_t>(n))
      return;
    sent[n++] = bucket;
    put(bucket, v, p, false);
  });
}

template <class Point>
void NearMatcher<Point>::load(std::size_t bucket) {
  candidate_.clear();
  VertexId v = 0;
  for_each_weld_record(file_, bucket, [&](const std::byte* at) {
    std::uint64_t code = 0;
    Candidate c;
    at = get_point(get_varint(at, code), c.p);
    v += code >> 1;
    c.v = v;
    c.home = (code & 1) != 0;
    c.cell = hash_of(canonical(cell_of(c.p)));
    candidate_.push_back(c);
    return at;
  });
  std::sort(candidate_.begin(), candidate_.end(), [](const Candidate& a, const Candidate& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.v < b.v;
  });
}

template <class Point>
void NearMatcher<Point>::index_cells() {
  slot_.assign(std::bit_ceil(2 * candidate_.size() + 2), kNoIndex);
  for (std::size_t i = 0; i < candidate_.size(); ++i) {
    if (i > 0 && candidate_[i - 1].cell == candidate_[i].cell) continue;
    std::size_t s = static_cast<std::size_t>(candidate_[i].cell) & (slot_.size() - 1);
    while (slot_[s] != kNoIndex) s = (s + 1) & (slot_.size() - 1);
    slot_[s] = static_cast<std::uint32_t>(i);
  }
}

template <class Point>
VertexId NearMatcher<Point>::lowest_near(const Candidate& c) const {
  VertexId best = c.v;
  const Vec3 cell = cell_of(c.p);
  const Vec3 at = to_double(c.p);
  const double most = distance_ * distance_;
  for_each_neighbour([&](const Vec3& step) {
    const std::uint64_t wanted = hash_of(canonical(cell + step));
    std::size_t s = static_cast<std::size_t>(wanted) & (slot_.size() - 1);
    while (slot_[s] != kNoIndex && candidate_[slot_[s]].cell != wanted)
      s = (s + 1) & (slot_.size() - 1);
    if (slot_[s] == kNoIndex) return;
    for (std::size_t i = slot_[s]; i < candidate_.size() && candidate_[i].cell == wanted; ++i) {
      if (candidate_[i].v >= best) break;
      if (norm2(to_double(candidate_[i].p) - at) <= most) best = candidate_[i].v;
    }
  });
  return best;
}

template <class Point>
void NearMatcher<Point>::match(LinkBuckets<Point>& links, FunctionRef<void(double)> progress) {
  // Of a candidate: itself, and up to four slots.
  constexpr std::uint64_t kBytes = sizeof(Candidate) + 4 * sizeof(std::uint32_t);
  std::uint64_t most = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket)
    most = std::max(most, file_.bytes(bucket) / (sizeof(Point) + 1));
  const Reservation reservation = scratch_.budget->reserve(
      most * kBytes, fmt::format("welding vertices within {} of each other, which is much for "
                                 "this mesh,",
                                 distance_));
  candidate_.reserve(static_cast<std::size_t>(most));
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    progress(double(bucket) / kBuckets);
    load(bucket);
    file_.release(bucket);
    index_cells();
    for (const Candidate& c : candidate_) {
      if (!c.home) continue;
      const VertexId to = is_finite(c.p) ? lowest_near(c) : c.v;
      to == c.v ? links.add_root(c.v, c.p) : links.add_link(c.v, to);
    }
  }
  candidate_ = {};
  slot_ = {};
}

template class EqualMatcher<Vec3f>;
template class EqualMatcher<Vec3>;
template class NearMatcher<Vec3f>;
template class NearMatcher<Vec3>;

}  // namespace remaps::pipeline
