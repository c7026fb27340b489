#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "remaps/simplify/removal.h"
#include "support/shapes.h"
#include "support/simplified_shape.h"
#include "support/surface_check.h"

namespace remaps::simplify {

/// Checks each record against a mesh of its own that follows the log.
inline void replay(const test::Shape& shape, const test::SimplifiedShape& run,
                   const SimplifyOptions& options) {
  Patch patch;
  patch.build(shape.position.size(), shape.position.size(), shape.triangle);
  for (std::size_t r = 0; r < run.log.size(); ++r) {
    const Retriangulation record = run.log[r];
    const LocalIndex v = patch.corner_vertex(corner_of(record.face[0], record.turn[0]));
    ASSERT_EQ(v, run.removed[r]);
    Star star;
    ASSERT_TRUE(patch.star(v, star));
    const unsigned n = star.ring_size();
    ASSERT_EQ(record.wedges, star.wedges);
    ASSERT_EQ(record.boundary, star.boundary);
    ASSERT_LE(record.wedges, options.max_valence);
    for (unsigned i = 0; i < star.wedges; ++i) {
      ASSERT_EQ(corner_of(record.face[i], record.turn[i]), star.corner[i]);
      ASSERT_GE(planar_shape({}, record.ring[i], record.ring[(i + 1) % n]), options.wedge_floor);
    }
    for (unsigned j = 0; j < record.triangles(); ++j) {
      ASSERT_GE(planar_shape(record.ring[record.corner(j, 0)], record.ring[record.corner(j, 1)],
                             record.ring[record.corner(j, 2)]),
                options.fan_floor);
    }
    if (record.boundary) {
      ASSERT_EQ(record.ring[0].y, 0);
      ASSERT_EQ(record.ring[n - 1].y, 0);
      ASSERT_TRUE(record.apex == 0 || record.apex == n - 1) << "removed off the boundary";
    }
    ASSERT_TRUE(patch.fan_keeps_topology(star, record.apex));
    std::vector<unsigned> before(n);
    for (unsigned i = 0; i < n; ++i) before[i] = patch.valence(star.ring[i]);
    patch.retriangulate(v, star, record.apex);
    for (unsigned i = 0; i < n; ++i) {
      ASSERT_LE(patch.valence(star.ring[i]), std::max(before[i], options.max_valence));
    }
  }
  EXPECT_EQ(test::alive_faces(patch), test::alive_faces(run.patch));
}

}  // namespace remaps::simplify
