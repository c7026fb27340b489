#include "remaps/pipeline/replay_check.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>

namespace remaps::pipeline {
namespace {

/// Follows one record at a time; knows what to call it when something is wrong.
class Replay {
 public:
  Replay(const SegmentLog& log, const std::string& what, std::vector<Triangle>& faces)
      : log_(log), what_(what), faces_(faces) {}

  void run() {
    for (number_ = 0; number_ < log_.records.size(); ++number_) {
      record_ = log_.records[number_];
      read_star();
      check_ring_points();
      check_areas();
      apply();
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw CorruptionError(fmt::format("{}: record {} (removes vertex {}): {}", what_, number_,
                                      log_.removed[number_], why));
  }

  /// Finds the ring's vertices; every face must have the removed vertex where the record says and
  /// begin at the ring vertex where the one before ended.
  void read_star() {
    const unsigned n = record_.ring_size();
    const VertexId removed = log_.removed[number_];
    for (unsigned i = 0; i < record_.wedges; ++i) {
      const LocalIndex f = record_.face[i];
      for (unsigned j = 0; j < i; ++j) {
        if (record_.face[j] == f) refuse(fmt::format("face {} is in its star twice", f));
      }
      const Triangle& t = faces_[f];
      const unsigned turn = record_.turn[i];
      if (t == kDroppedFace) refuse(fmt::format("face {} was dropped before", f));
      if (t[turn] != removed) {
        refuse(fmt::format("corner {} of face {} is vertex {}", turn, f, t[turn]));
      }
      const VertexId from = t[(turn + 1) % 3];
      const VertexId to = t[(turn + 2) % 3];
      if (i == 0) ring_[0] = from;
      if (from != ring_[i]) {
        refuse(fmt::format("face {} does not follow face {} around it", f, record_.face[i - 1]));
      }
      if (i + 1 < n) {
        ring_[i + 1] = to;
      } else if (to != ring_[0]) {
        refuse("its star does not close");
      }
    }
    for (unsigned i = 0; i < n; ++i) {
      for (unsigned j = 0; j < i; ++j) {
        if (ring_[i] == ring_[j]) refuse(fmt::format("vertex {} is in its ring twice", ring_[i]));
      }
    }
  }

  /// Half planes: 0 for angles in [0, pi), 1 for [pi, 2 pi).
  static unsigned half_of(GridPoint p) { return p.y > 0 || (p.y == 0 && p.x > 0) ? 0 : 1; }

  /// Counter-clockwise steps of less than pi that pass the positive x axis as often as the ring
  /// winds around the origin.
  void check_ring_points() const {
    const unsigned n = record_.ring_size();
    for (unsigned i = 0; i < n; ++i) {
      if (std::abs(record_.ring[i].x) > kGridRadius || std::abs(record_.ring[i].y) > kGridRadius) {
        refuse(fmt::format("ring point {} lies outside the grid", i));
      }
    }
    unsigned turns = 0;
    for (unsigned i = 0; i < record_.wedges; ++i) {
      const GridPoint a = record_.ring[i];
      const GridPoint b = record_.ring[record_.next(i)];
      if (orientation(a, b) <= 0) refuse(fmt::format("wedge {} is not counter-clockwise", i));
      turns += half_of(a) == 1 && half_of(b) == 0;
    }
    if (turns != (record_.boundary ? 0 : 1)) refuse("its ring does not wind once around it");
    if (!record_.boundary) return;
    const GridPoint first = record_.ring[0];
    const GridPoint last = record_.ring[n - 1];
    if (first.y != 0 || first.x <= 0 || last.y != 0 || last.x >= 0) {
      refuse("its boundary edges do not lie on the x axis");
    }
  }

  void check_areas() const {
    std::int64_t balance = 0;
    for (unsigned i = 0; i < record_.wedges; ++i) {
      balance += orientation(record_.ring[i], record_.ring[record_.next(i)]);
    }
    for (unsigned j = 0; j < record_.triangles(); ++j) {
      const std::int32_t area =
          orientation(record_.ring[record_.apex], record_.ring[record_.corner(j, 1)],
                      record_.ring[record_.corner(j, 2)]);
      if (area <= 0) refuse(fmt::format("new triangle {} is not counter-clockwise", j));
      balance -= area;
    }
    if (balance != 0) refuse("old and new triangles differ in area");
  }

  void apply() {
    for (unsigned j = 0; j < record_.wedges; ++j) {
      faces_[record_.face[j]] = j < record_.triangles()
                                    ? Triangle{ring_[record_.apex], ring_[record_.corner(j, 1)],
                                               ring_[record_.corner(j, 2)]}
                                    : kDroppedFace;
    }
  }

  const SegmentLog& log_;
  const std::string& what_;
  std::vector<Triangle>& faces_;
  std::size_t number_ = 0;
  Retriangulation record_;
  std::array<VertexId, kMaxRing> ring_{};
};

}  // namespace

void replay_records(const SegmentLog& log, const std::string& what, std::vector<Triangle>& faces) {
  Replay(log, what, faces).run();
}

void check_survivors(const SegmentLog& log, const std::string& what,
                     const std::vector<Triangle>& faces) {
  std::size_t i = 0;
  for (LocalIndex f = 0; f < faces.size(); ++f) {
    const bool listed = i < log.survivor.size() && log.survivor[i] == f;
    i += listed;
    if (listed != (faces[f] != kDroppedFace)) {
      throw CorruptionError(fmt::format("{}: face {} is {} the survivors, but the records {} it",
                                        what, f, listed ? "among" : "not among",
                                        listed ? "drop" : "leave"));
    }
  }
}

}  // namespace remaps::pipeline
