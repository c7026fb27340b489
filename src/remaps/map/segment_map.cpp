#include "remaps/map/segment_map.h"

#include <algorithm>
#include <array>
#include <string>

#include "remaps/base/errors.h"

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

void SegmentMap::build(const RetriangulationLog& log, std::size_t faces, Direction direction) {
  log_ = &log;
  direction_ = direction;
  first_.assign(faces, kNoIndex);
  next_.assign(log.words().size(), kNoIndex);
  const auto touch = [&](std::size_t r) {
    for (unsigned i = 0; i < log.wedges(r); ++i) {
      std::uint32_t& latest = first_[log.face(r, i)];
      // A record that led back to itself would be followed for ever.
      if (latest != kNoIndex && latest / 16 == r) {
        throw CorruptionError("record " + std::to_string(r) + " has face " +
                              std::to_string(log.face(r, i)) + " in its star twice");
      }
      next_[log.face_offset(r) + i] = latest;
      latest = static_cast<std::uint32_t>(r * 16 + i);
    }
  };
  if (direction == Direction::kForward) {
    for (std::size_t r = log.size(); r-- > 0;) touch(r);
  } else {
    for (std::size_t r = 0; r < log.size(); ++r) touch(r);
  }
}

FacePoint SegmentMap::carry_from(FacePoint point, std::uint32_t link) const {
  while (link != kNoIndex) {
    const std::size_t r = link / 16;
    const RecordView record = log_->view(r);
    const unsigned slot = direction_ == Direction::kForward
                              ? apply_forward(record, link % 16, point)
                              : apply_inverse(record, link % 16, point);
    link = next_[log_->face_offset(r) + slot];
  }
  return point;
}

void SegmentMap::carry(std::span<FacePoint> points) const {
  for (FacePoint& point : points) point = carry_from(point, first_[point.face]);
}

}  // namespace remaps::map
