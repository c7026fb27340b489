#pragma once

#include <cstddef>

#include "remaps/base/progress.h"
#include "remaps/mesh/patch.h"
#include "remaps/simplify/flatten.h"

/// What the two simplifiers have in common.
namespace remaps::simplify {

struct SimplifyOptions {
  std::size_t target_vertices = 0;  ///< stop when so many own vertices are left
  double wedge_floor = 0.0005;      ///< least planar_shape of a wedge of a flattened star
  double fan_floor = 0.002;         ///< least planar_shape of a new planar triangle
  unsigned max_valence = 12;        ///< of any vertex after a removal (larger ones may shrink)
  /// With fewer vertices left every fan of every star is tried at once (Simplifier only).
  std::size_t thorough_below = 0;
  /// Told how many of the vertices that are to go have gone, where that takes long (Simplifier
  /// only); may be null.
  Progress* progress = nullptr;
};

// The cost of a removal is quadric^0.3 * (growth of the load)^0.7 * shape^-0.25; queues hold its
// logarithm. See docs/design/removal-order.md.
inline constexpr double kQuadricExponent = 0.3;
inline constexpr double kLoadExponent = 0.7;
inline constexpr double kShapeExponent = -0.25;
inline constexpr double kLeastShape = 0.02;

inline Retriangulation make_record(const Star& star, const FlatStar& flat, unsigned apex) {
  Retriangulation record;
  record.wedges = static_cast<std::uint8_t>(star.wedges);
  record.boundary = star.boundary;
  record.apex = static_cast<std::uint8_t>(apex);
  for (unsigned i = 0; i < star.wedges; ++i) {
    record.face[i] = face_of(star.corner[i]);
    record.turn[i] = static_cast<std::uint8_t>(slot_of(star.corner[i]));
  }
  record.ring = flat.ring;
  return record;
}

}  // namespace remaps::simplify
