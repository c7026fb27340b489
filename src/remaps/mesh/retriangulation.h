#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"

/// One removal of a vertex, as a record. The sequence of records is the map between the input and
/// the base: see docs/design/log-is-the-map.md. This header is the one thing that the room that
/// writes records (simplify) and the room that follows them (map) have in common.
///
/// The star of the removed vertex is flattened with the vertex at the origin of a planar integer
/// grid. Its k triangles are the wedges (origin, ring[i], ring[i + 1]); an interior vertex has n =
/// k ring points and the last wedge closes the ring; a boundary vertex has n = k + 1 ring points
/// and the segment from ring[n - 1] to ring[0] passes through the origin. The hole is filled by the
/// n - 2 triangles of the fan about ring[apex]: triangle j is (ring[apex], ring[apex + 1 + j],
/// ring[apex + 2 + j]), indices modulo n, and takes the id of wedge j. The ids of the last wedges
/// are dropped.
namespace remaps {

/// A point on the integer grid of a flattened star. |x|, |y| <= kGridRadius.
struct GridPoint {
  std::int16_t x = 0, y = 0;

  friend bool operator==(const GridPoint&, const GridPoint&) = default;
};

/// Ring coordinates are integers of 14 bits and a sign.
inline constexpr int kGridRadius = 16383;
inline constexpr unsigned kMaxStarFaces = 14;
inline constexpr unsigned kMaxRing = kMaxStarFaces + 1;

/// A point in the plane of a star, made by `planar_point`.
struct PlanarPoint {
  double x = 0, y = 0;
};

/// Coordinates below 2^-30 count as 0 (1e-13 of a star's radius): so all are multiples of 2^-82,
/// and no orientation below needs more than 113 bits.
inline PlanarPoint planar_point(double x, double y) {
  constexpr double kLeast = 0x1p-30;
  return {std::fabs(x) < kLeast ? 0 : x, std::fabs(y) < kLeast ? 0 : y};
}

/// Twice the signed area of (a, b, c); exact.
inline std::int32_t orientation(GridPoint a, GridPoint b, GridPoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}
/// Twice the signed area of (origin, a, b); exact.
inline std::int32_t orientation(GridPoint a, GridPoint b) {
  return a.x * b.y - a.y * b.x;
}
/// `orientation` of nearly collinear points, in 113 bits and so without any rounding before the
/// last.
double orientation_near_zero(GridPoint a, GridPoint b, PlanarPoint p);
/// Twice the signed area of (a, b, p): the sign, 0 included, is exact. Differences and products of
/// the doubles err by less than 3 * 2^-22; only results as small as that are computed again.
inline double orientation(GridPoint a, GridPoint b, PlanarPoint p) {
  const double area = double(b.x - a.x) * (p.y - a.y) - double(b.y - a.y) * (p.x - a.x);
  return std::fabs(area) > 0x1p-20 ? area : orientation_near_zero(a, b, p);
}

/// The numbering that all forms of a record share; see the head of this file.
template <class Record>
struct RecordShape {
  unsigned ring_size() const { return self().wedges + (self().boundary ? 1u : 0u); }
  unsigned triangles() const { return ring_size() - 2; }
  /// Ring index of corner c (0, 1, 2) of new triangle j.
  unsigned corner(unsigned j, unsigned c) const {
    const unsigned slot = c == 0 ? self().apex : self().apex + j + c;
    return slot >= ring_size() ? slot - ring_size() : slot;
  }
  unsigned next(unsigned slot) const { return slot + 1 == ring_size() ? 0 : slot + 1; }

 private:
  const Record& self() const { return static_cast<const Record&>(*this); }
};

/// One removal, unpacked. Plain data; made by simplify.
struct Retriangulation : RecordShape<Retriangulation> {
  std::uint8_t wedges = 0;  ///< k, the triangles of the star: 3 (2 at a boundary) to kMaxStarFaces
  bool boundary = false;    ///< the removed vertex lies on a boundary
  std::uint8_t apex = 0;    ///< the ring point that the new triangles fan about
  std::array<LocalIndex, kMaxStarFaces>
      face{};  ///< (k) ids of the star's triangles, counter-clockwise
  std::array<std::uint8_t, kMaxStarFaces>
      turn{};                              ///< (k) which corner of face[i] is the removed vertex
  std::array<GridPoint, kMaxRing> ring{};  ///< (n) flattened ring, counter-clockwise
};

/// One removal, read in place from a log.
struct RecordView : RecordShape<RecordView> {
  struct Turns {
    std::uint32_t bits;
    unsigned operator[](unsigned i) const { return (bits >> (2 * i)) & 3u; }
  };
  struct Ring {
    const std::uint32_t* words;
    GridPoint operator[](unsigned i) const {
      return {static_cast<std::int16_t>(words[i] & 0xFFFFu),
              static_cast<std::int16_t>(words[i] >> 16)};
    }
  };

  unsigned wedges;
  bool boundary;
  unsigned apex;
  const LocalIndex* face;
  Turns turn;
  Ring ring;
};

/// Records of one segment, in removal order, packed. A record takes 2 + k + n words of 32 bits:
///   word 0: k (bits 0-3), boundary (bit 4), apex (bits 8-11);  word 1: turn, 2 bits a wedge;
///   k words: face ids;  n words: ring points, x in the low half, y in the high half, two's
///   complement.
class RetriangulationLog {
 public:
  void clear() {
    words_.clear();
    starts_.clear();
  }
  std::size_t size() const { return starts_.size(); }
  bool empty() const { return starts_.empty(); }
  void reserve(std::size_t records) {
    starts_.reserve(records);
    words_.reserve(records * 15);
  }

  void append(const Retriangulation& r) {
    starts_.push_back(static_cast<std::uint32_t>(words_.size()));
    std::uint32_t turns = 0;
    for (unsigned i = 0; i < r.wedges; ++i) turns |= std::uint32_t{r.turn[i]} << (2 * i);
    words_.push_back(r.wedges | (r.boundary ? 16u : 0u) | std::uint32_t{r.apex} << 8);
    words_.push_back(turns);
    words_.insert(words_.end(), r.face.begin(), r.face.begin() + r.wedges);
    for (unsigned i = 0; i < r.ring_size(); ++i) {
      words_.push_back(static_cast<std::uint16_t>(r.ring[i].x) |
                       std::uint32_t{static_cast<std::uint16_t>(r.ring[i].y)} << 16);
    }
  }

  /// Where the face ids of record r start among words(): a stable number for the pair (record,
  /// slot).
  std::uint32_t face_offset(std::size_t r) const { return starts_[r] + 2; }
  unsigned wedges(std::size_t r) const { return words_[starts_[r]] & 15u; }
  bool boundary(std::size_t r) const { return (words_[starts_[r]] & 16u) != 0; }
  unsigned apex(std::size_t r) const { return (words_[starts_[r]] >> 8) & 15u; }
  unsigned turn(std::size_t r, unsigned i) const {
    return (words_[starts_[r] + 1] >> (2 * i)) & 3u;
  }
  LocalIndex face(std::size_t r, unsigned i) const { return words_[starts_[r] + 2 + i]; }
  GridPoint ring(std::size_t r, unsigned i) const {
    const std::uint32_t word = words_[starts_[r] + 2 + wedges(r) + i];
    return {static_cast<std::int16_t>(word & 0xFFFFu), static_cast<std::int16_t>(word >> 16)};
  }

  /// Valid until the log changes.
  RecordView view(std::size_t r) const {
    const std::uint32_t* words = words_.data() + starts_[r];
    const unsigned k = words[0] & 15u;
    return {{},        k,          (words[0] & 16u) != 0, (words[0] >> 8) & 15u,
            words + 2, {words[1]}, {words + 2 + k}};
  }
  Retriangulation operator[](std::size_t r) const {
    const RecordView from = view(r);
    Retriangulation result;
    result.wedges = static_cast<std::uint8_t>(from.wedges);
    result.boundary = from.boundary;
    result.apex = static_cast<std::uint8_t>(from.apex);
    for (unsigned i = 0; i < from.wedges; ++i) {
      result.face[i] = from.face[i];
      result.turn[i] = static_cast<std::uint8_t>(from.turn[i]);
    }
    for (unsigned i = 0; i < from.ring_size(); ++i) result.ring[i] = from.ring[i];
    return result;
  }

  std::span<const std::uint32_t> words() const { return words_; }
  /// Takes packed words as read from a file.
  /// @return  false when the words are not whole records (then the log is empty)
  bool assign(std::vector<std::uint32_t> words);

 private:
  std::vector<std::uint32_t> words_;
  std::vector<std::uint32_t> starts_;
};

}  // namespace remaps
