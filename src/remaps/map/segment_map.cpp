#include "remaps/map/segment_map.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

#include "remaps/base/errors.h"
#include "remaps/base/simd.h"

namespace remaps::map {
namespace {

/// Weights of p in a triangle from its signed areas (each opposite to its corner); clamps what
/// rounding left outside.
struct Weights {
  double b0, b1, b2;
};

Weights normalized(double w0, double w1, double w2) {
  w0 = std::max(w0, 0.0);
  w1 = std::max(w1, 0.0);
  w2 = std::max(w2, 0.0);
  const double sum = w0 + w1 + w2;
  return {w0 / sum, w1 / sum, w2 / sum};
}

PlanarPoint blend(double b1, GridPoint p1, double b2, GridPoint p2) {
  return planar_point(b1 * p1.x + b2 * p2.x, b1 * p1.y + b2 * p2.y);
}

/// Twice the area of (a, b, p), as `orientation` has it where it needs no more care.
double cross_of(GridPoint a, GridPoint b, const PlanarPoint& p) {
  return double(b.x - a.x) * (p.y - a.y) - double(b.y - a.y) * (p.x - a.x);
}

}  // namespace

template <class Record>
unsigned apply_forward(const Record& r, unsigned slot, FacePoint& point) {
  const std::array<double, 3> weight{1 - point.u - point.v, point.u, point.v};
  const unsigned turn = r.turn[slot];
  const PlanarPoint p = blend(weight[turn == 2 ? 0 : turn + 1], r.ring[slot],
                              weight[turn == 0 ? 2 : turn - 1], r.ring[r.next(slot)]);
  const GridPoint apex = r.ring[r.apex];
  const unsigned triangles = r.triangles();
  unsigned best = 0;
  double best_least = 0;
  std::array<double, 3> best_sign{};
  GridPoint a = r.ring[r.corner(0, 1)];
  double at_a = orientation(apex, a, p);
  for (unsigned j = 0; j < triangles; ++j) {
    const GridPoint b = r.ring[r.corner(j, 2)];
    const double at_b = orientation(apex, b, p);
    const double outer = orientation(a, b, p);
    const double least = std::min({outer, -at_b, at_a});
    if (j == 0 || least > best_least) {
      best = j;
      best_least = least;
      best_sign = {outer, -at_b, at_a};
    }
    if (least >= 0) break;
    a = b;
    at_a = at_b;
  }
  const Weights w = normalized(best_sign[0], best_sign[1], best_sign[2]);
  point = {r.face[best], w.b1, w.b2};
  return best;
}

template <class Record>
unsigned apply_inverse(const Record& r, unsigned slot, FacePoint& point) {
  const GridPoint p0 = r.ring[r.apex];
  const GridPoint p1 = r.ring[r.corner(slot, 1)];
  const GridPoint p2 = r.ring[r.corner(slot, 2)];
  const double w0 = 1 - point.u - point.v;
  const PlanarPoint p = planar_point(w0 * p0.x + point.u * p1.x + point.v * p2.x,
                                     w0 * p0.y + point.u * p1.y + point.v * p2.y);
  unsigned best = 0;
  double best_least = 0;
  std::array<double, 3> best_sign{};
  for (unsigned i = 0; i < r.wedges; ++i) {
    const GridPoint a = r.ring[i];
    const GridPoint b = r.ring[r.next(i)];
    const double at_a = orientation(GridPoint{}, a, p);
    const double at_b = -orientation(GridPoint{}, b, p);
    const double outer = orientation(a, b, p);
    const double least = std::min({outer, at_b, at_a});
    if (i == 0 || least > best_least) {
      best = i;
      best_least = least;
      best_sign = {outer, at_b, at_a};
    }
    if (least >= 0) break;
  }
  const Weights w = normalized(best_sign[0], best_sign[1], best_sign[2]);
  // Wedge order is (removed vertex, ring[i], ring[i + 1]); the face's own order starts `turn`
  // corners earlier.
  const std::array<double, 3> in_wedge{w.b0, w.b1, w.b2};
  const unsigned turn = r.turn[best];
  point = {r.face[best], in_wedge[(4 - turn) % 3], in_wedge[(5 - turn) % 3]};
  return best;
}

template unsigned apply_forward(const Retriangulation&, unsigned, FacePoint&);
template unsigned apply_forward(const RecordView&, unsigned, FacePoint&);
template unsigned apply_inverse(const Retriangulation&, unsigned, FacePoint&);
template unsigned apply_inverse(const RecordView&, unsigned, FacePoint&);

namespace {

using Direction = SegmentMap::Direction;

using Double2 = double __attribute__((vector_size(16)));

constexpr std::uint32_t kEnd = 0x80000000u;
constexpr unsigned kUnit = 4;  // words
/// Points that walk at a time: enough to hide the time that memory takes.
constexpr std::size_t kFlight = 32;

struct Walker {
  std::uint32_t link;
  std::uint32_t index;
  double u, v;
};

/// A record of path_.
struct Stop {
  const std::uint32_t* words;

  unsigned wedges() const { return words[0] & 15u; }
  unsigned apex() const { return (words[0] >> 8) & 15u; }
  unsigned ring_size() const { return words[0] >> 16; }
  unsigned turn(unsigned wedge) const { return (words[1] >> (2 * wedge)) & 3u; }
  unsigned wrap(unsigned slot) const { return slot >= ring_size() ? slot - ring_size() : slot; }
  GridPoint ring(unsigned i) const { return RecordView::Ring{words + 2}[i]; }
  std::uint32_t link(unsigned slot) const { return words[2 + ring_size() + slot]; }
  RecordView view() const {
    return {{},         wedges(),   (words[0] & 16u) != 0, apex(), words + 2 + ring_size(),
            {words[1]}, {words + 2}};
  }
};

/// On which side of lines through `from` and each ring point p lies: bit i is for ring[i]. What is
/// not surely on one side is `near`.
struct Sides {
  unsigned left = 0, near = 0;
};

/// Twice the areas below which floats do not tell the side (simd.h): a millionth of a star's.
constexpr float kNear = 0x1p9f;

[[gnu::always_inline]] inline Sides sides_of(const Stop& r, GridPoint from, const PlanarPoint& p) {
  const auto ax = static_cast<float>(from.x);
  const auto ay = static_cast<float>(from.y);
  const auto dx = static_cast<float>(p.x - from.x);
  const auto dy = static_cast<float>(p.y - from.y);
  const unsigned n = r.ring_size();
  const auto four = [&](unsigned i) {
    return signs_of_cross(load4(r.words + 2 + i), ax, ay, dx, dy, kNear);
  };
  // Nearly all rings have at most eight points; so there is no branch on their number.
  const SignMasks low = four(0);
  const SignMasks high = four(kLanes);
  Sides sides{low.positive | high.positive << kLanes, low.near | high.near << kLanes};
  for (unsigned i = 2 * kLanes; i < n; i += kLanes) [[unlikely]] {
      const SignMasks more = four(i);
      sides.left |= more.positive << i;
      sides.near |= more.near << i;
    }
  const unsigned all = (1u << n) - 1;
  sides.left &= all;
  sides.near &= all;
  return sides;
}

/// One step of apply_forward for points that no exact arithmetic is needed for; the same results.
/// @return  the slot of the new triangle, or kMaxRing when the point needs apply_forward
[[gnu::always_inline]] inline unsigned step_forward(const Stop& r, unsigned slot, Walker& point) {
  const unsigned n = r.ring_size();
  const std::array<double, 3> weight{1 - point.u - point.v, point.u, point.v};
  const unsigned turn = r.turn(slot);
  const PlanarPoint p = blend(weight[turn == 2 ? 0 : turn + 1], r.ring(slot),
                              weight[turn == 0 ? 2 : turn - 1], r.ring(r.wrap(slot + 1)));
  const unsigned at = r.apex();
  const GridPoint apex = r.ring(at);
  const Sides sides = sides_of(r, apex, p);
  // From the apex's successor on: p is in the sector whose first line it is left of, and right of
  // its last.
  const unsigned left =
      ((sides.left >> (at + 1)) | (sides.left << (n - at - 1))) & ((1u << (n - 1)) - 1);
  const unsigned sector = left & ~(left >> 1) & ((1u << (n - 2)) - 1);
  if ((sides.near & ~(1u << at)) != 0 || sector == 0) return kMaxRing;
  const auto j = static_cast<unsigned>(std::countr_zero(sector));
  const GridPoint a = r.ring(r.wrap(at + 1 + j));
  const GridPoint b = r.ring(r.wrap(at + 2 + j));
  const double outer = cross_of(a, b, p);
  if (!(outer > 0x1p-20)) return kMaxRing;
  const double w1 = -cross_of(apex, b, p);
  const double w2 = cross_of(apex, a, p);
  const Double2 weights = Double2{w1, w2} / (outer + w1 + w2);
  point.u = weights[0];
  point.v = weights[1];
  return j;
}

/// The same for apply_inverse.
[[gnu::always_inline]] inline unsigned step_inverse(const Stop& r, unsigned slot, Walker& point) {
  const unsigned n = r.ring_size();
  const unsigned at = r.apex();
  const GridPoint p0 = r.ring(at);
  const GridPoint p1 = r.ring(r.wrap(at + 1 + slot));
  const GridPoint p2 = r.ring(r.wrap(at + 2 + slot));
  const double w0 = 1 - point.u - point.v;
  const PlanarPoint p = planar_point(w0 * p0.x + point.u * p1.x + point.v * p2.x,
                                     w0 * p0.y + point.u * p1.y + point.v * p2.y);
  const Sides sides = sides_of(r, {}, p);
  const unsigned after = (sides.left >> 1) | (sides.left << (n - 1));
  const unsigned sector = sides.left & ~after & ((1u << r.wedges()) - 1);
  if (sides.near != 0 || sector == 0) return kMaxRing;
  const auto i = static_cast<unsigned>(std::countr_zero(sector));
  const GridPoint a = r.ring(i);
  const GridPoint b = r.ring(r.wrap(i + 1));
  const double outer = cross_of(a, b, p);
  if (!(outer > 0x1p-20)) return kMaxRing;
  const double at_b = -cross_of({}, b, p);
  const double at_a = cross_of({}, a, p);
  const double sum = outer + at_b + at_a;
  const std::array<double, 3> in_wedge{outer / sum, at_b / sum, at_a / sum};
  const unsigned turn = r.turn(i);
  point.u = in_wedge[(4 - turn) % 3];
  point.v = in_wedge[(5 - turn) % 3];
  return i;
}

template <Direction direction>
[[gnu::always_inline]] inline void step(const std::uint32_t* words, Walker& point) {
  const Stop r{words};
  const unsigned slot = point.link & 15u;
  unsigned out = direction == Direction::kForward ? step_forward(r, slot, point)
                                                  : step_inverse(r, slot, point);
  if (out == kMaxRing) {
    FacePoint exact{0, point.u, point.v};
    out = direction == Direction::kForward ? apply_forward(r.view(), slot, exact)
                                           : apply_inverse(r.view(), slot, exact);
    point.u = exact.u;
    point.v = exact.v;
  }
  point.link = r.link(out);
}

}  // namespace

template <Direction direction>
void SegmentMap::link(const RetriangulationLog& log, std::size_t faces) {
  constexpr bool forward = direction == Direction::kForward;
  std::size_t end = 0;
  place_.resize(log.size());
  for (std::size_t r = 0; r < log.size(); ++r) {
    const RecordView from = log.view(r);
    place_[r] = static_cast<std::uint32_t>(end / kUnit);
    const unsigned links = forward ? from.triangles() : from.wedges;
    end += (2 + from.ring_size() + links + kUnit - 1) / kUnit * kUnit;
    if (end / kUnit >= kEnd / 16)
      throw BudgetError("a segment has more records than can be linked");
  }
  path_.assign(end + 2 * kLanes, 0);  // rings are loaded beyond their ends
  first_.resize(faces);
  for (std::size_t f = 0; f < faces; ++f) first_[f] = kEnd | static_cast<std::uint32_t>(f);
  for (std::size_t i = 0; i < log.size(); ++i) {
    const std::size_t r = forward ? log.size() - 1 - i : i;
    const RecordView from = log.view(r);
    const unsigned n = from.ring_size();
    std::uint32_t* words = path_.data() + std::size_t{place_[r]} * kUnit;
    words[0] = from.wedges | (from.boundary ? 16u : 0u) | from.apex << 8 | n << 16;
    words[1] = from.turn.bits;
    std::copy_n(from.ring.words, n, words + 2);
    // Faces that go on from here lead to what was linked before, faces that come here lead here.
    const unsigned leaving = forward ? from.triangles() : from.wedges;
    const unsigned coming = forward ? from.wedges : from.triangles();
    for (unsigned k = 0; k < leaving; ++k) words[2 + n + k] = first_[from.face[k]];
    for (unsigned k = 0; k < coming; ++k) first_[from.face[k]] = place_[r] * 16 + k;
    for (unsigned k = 0; k < from.wedges; ++k) {
      for (unsigned m = k + 1; m < from.wedges; ++m) {
        if (from.face[k] != from.face[m]) continue;
        throw CorruptionError("record " + std::to_string(r) + " has face " +
                              std::to_string(from.face[k]) + " in its star twice");
      }
    }
  }
}

void SegmentMap::build(const RetriangulationLog& log, std::size_t faces, Direction direction) {
  direction_ = direction;
  direction == Direction::kForward ? link<Direction::kForward>(log, faces)
                                   : link<Direction::kInverse>(log, faces);
}

/// Many points walk at a time, a step each in turn, so that they wait for memory together.
/// source(walker) starts the next point and returns false when there is none; sink(walker) takes
/// one at its end.
template <Direction direction, class Source, class Sink>
void SegmentMap::walk(Source&& source, Sink&& sink) const {
  std::array<Walker, kFlight> flight;
  std::size_t walking = 0;
  bool more = true;
  while (true) {
    while (more && walking < kFlight) {
      more = source(flight[walking]);
      walking += more;
    }
    if (walking == 0) return;
    for (std::size_t i = 0; i < walking;) {
      Walker& walker = flight[i];
      if (walker.link < kEnd) {
        step<direction>(path_.data() + std::size_t{walker.link >> 4} * kUnit, walker);
      }
      if (walker.link < kEnd) {
        const std::uint32_t* next = path_.data() + std::size_t{walker.link >> 4} * kUnit;
        __builtin_prefetch(next);
        __builtin_prefetch(next + 15);
        ++i;
      } else {
        sink(walker);
        walker = flight[--walking];
      }
    }
  }
}

void SegmentMap::carry(std::span<FacePoint> points) const {
  std::uint32_t next = 0;
  const auto source = [&](Walker& walker) {
    if (next == points.size()) return false;
    const FacePoint& point = points[next];
    walker = {first_[point.face], next, point.u, point.v};
    ++next;
    return true;
  };
  const auto sink = [&](const Walker& walker) {
    points[walker.index] = {walker.link & ~kEnd, walker.u, walker.v};
  };
  direction_ == Direction::kForward ? walk<Direction::kForward>(source, sink)
                                    : walk<Direction::kInverse>(source, sink);
}

void SegmentMap::carry_removed(std::span<FacePoint> out) const {
  std::uint32_t next = 0;
  const auto source = [&](Walker& walker) {
    if (next == place_.size()) return false;
    const Stop r{path_.data() + std::size_t{place_[next]} * kUnit};
    const unsigned corner = r.turn(0);
    walker = {place_[next] * 16, next, corner == 1 ? 1.0 : 0.0, corner == 2 ? 1.0 : 0.0};
    ++next;
    return true;
  };
  walk<Direction::kForward>(source, [&](const Walker& walker) {
    out[walker.index] = {walker.link & ~kEnd, walker.u, walker.v};
  });
}

}  // namespace remaps::map
