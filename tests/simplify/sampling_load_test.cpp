#include "remaps/simplify/sampling_load.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "support/cut_shape.h"
#include "support/random_records.h"
#include "support/shapes.h"

namespace remaps::simplify {
namespace {

struct LoadedStar {
  FlatStar star;
  unsigned apex;
  std::vector<float> wedge_load;
};

/// A random star with a valid fan about an apex that sees the star within a half-plane.
LoadedStar random_loaded_star(std::mt19937_64& random, bool boundary) {
  Retriangulation r;
  GridPoint after, before;
  do {
    r = test::random_record(random, boundary, 1000, 0.02);
    after = r.ring[r.next(r.apex)];
    before = r.ring[(r.apex + r.ring_size() - 1u) % r.ring_size()];
  } while (orientation(r.ring[r.apex], after, before) < 0);
  LoadedStar result{{r.wedges, r.boundary, r.ring}, r.apex, {}};
  for (unsigned i = 0; i < r.wedges; ++i) {
    result.wedge_load.push_back(0.1f + static_cast<float>(random() % 1000) / 100);
  }
  return result;
}

double wedge_area(const FlatStar& s, unsigned i) {
  return orientation(s.ring[i], s.ring[(i + 1) % s.ring_size()]);
}
double fan_area(const FlatStar& s, unsigned apex, unsigned j) {
  const unsigned n = s.ring_size();
  return orientation(s.ring[apex], s.ring[(apex + 1 + j) % n], s.ring[(apex + 2 + j) % n]);
}

TEST(CarryLoads, KeepsTheLoadPerSquaredArea) {
  // What a triangle carries grows with the square of its planar area; divided by it, nothing is
  // made or lost.
  for (const bool boundary : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
      std::mt19937_64 random(seed);
      const LoadedStar s = random_loaded_star(random, boundary);
      std::array<double, kMaxRing> load{};
      const double sum = carry_loads(s.star, s.apex, s.wedge_load, load);
      double before = 0;
      double after = 0;
      double total = 0;
      for (unsigned i = 0; i < s.star.wedges; ++i) {
        before += s.wedge_load[i] / std::pow(wedge_area(s.star, i), 2);
      }
      for (unsigned j = 0; j + 2 < s.star.ring_size(); ++j) {
        after += load[j] / std::pow(fan_area(s.star, s.apex, j), 2);
        total += load[j];
      }
      ASSERT_NEAR(after / before, 1, 1e-9) << "seed " << seed;
      ASSERT_NEAR(sum / total, 1, 1e-12) << "seed " << seed;
    }
  }
}

TEST(CarryLoads, AgreesWithCountingPoints) {
  // Points spread evenly over each wedge are handed to the fan triangle that they fall in.
  for (const bool boundary : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (boundary ? ", boundary" : ""));
      std::mt19937_64 random(seed);
      const LoadedStar s = random_loaded_star(random, boundary);
      const unsigned n = s.star.ring_size();
      std::array<double, kMaxRing> load{};
      carry_loads(s.star, s.apex, s.wedge_load, load);
      std::array<double, kMaxRing> counted{};
      constexpr int kSteps = 60;
      for (unsigned i = 0; i < s.star.wedges; ++i) {
        const GridPoint a = s.star.ring[i];
        const GridPoint b = s.star.ring[(i + 1) % n];
        const double each =
            s.wedge_load[i] / std::pow(wedge_area(s.star, i), 2) / (kSteps * (kSteps + 1) / 2);
        for (int x = 0; x < kSteps; ++x) {
          for (int y = 0; x + y < kSteps; ++y) {
            const double u = (x + 1.0 / 3) / kSteps;
            const double v = (y + 1.0 / 3) / kSteps;
            const PlanarPoint p{u * a.x + v * b.x, u * a.y + v * b.y};
            unsigned best = 0;
            double best_least = -1e300;
            for (unsigned j = 0; j + 2 < n; ++j) {
              const GridPoint t0 = s.star.ring[s.apex];
              const GridPoint t1 = s.star.ring[(s.apex + 1 + j) % n];
              const GridPoint t2 = s.star.ring[(s.apex + 2 + j) % n];
              const double least = std::min(
                  {orientation(t0, t1, p), orientation(t1, t2, p), orientation(t2, t0, p)});
              if (least > best_least) best_least = least, best = j;
            }
            counted[best] += each * std::pow(fan_area(s.star, s.apex, best), 2);
          }
        }
      }
      double largest = 0;
      for (unsigned j = 0; j + 2 < n; ++j) largest = std::max(largest, counted[j]);
      for (unsigned j = 0; j + 2 < n; ++j) EXPECT_NEAR(load[j], counted[j], 0.05 * largest) << j;
    }
  }
}

TEST(InitializeLoads, MeasuresFlatGroundByItsLeastCurvature) {
  const test::Shape shape = test::disk(5);
  Segment s = test::whole_segment(shape);
  Patch patch;
  patch.build(s.vertex_id.size(), s.own_vertices, s.triangle);
  const double diagonal = test::diagonal_of(shape);
  initialize_loads(patch, diagonal, s);
  for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
    const LocalTriangle& t = s.triangle[f];
    const Vec3 a = widen(s.position[t[0]]);
    const double area = 0.5 * norm(cross(widen(s.position[t[1]]) - a, widen(s.position[t[2]]) - a));
    EXPECT_NEAR(s.load[f], std::pow(area, 3) / (diagonal * diagonal), 1e-4 * s.load[f]);
  }
  // Inside the disk only moving up costs; at its rim moving across the rim does too.
  EXPECT_GT(s.quadric[0]({0, 0, 0.1}), 1e-4 * s.quadric[0]({0, 0, 1}));
  EXPECT_NEAR(s.quadric[0]({0.3, 0.2, 0}), 0, 1e-9);
  const auto rim = static_cast<LocalIndex>(s.position.size() - 30);  // at (1, 0, 0)
  EXPECT_GT(s.quadric[rim]({0.1, 0, 0}), 0);
}

TEST(InitializeLoads, KnowsTheCurvatureOfASphere) {
  for (const double radius : {1.0, 3.0}) {
    test::Shape shape = test::icosphere(4);
    for (Vec3& p : shape.position) p = radius * p;
    Segment s = test::whole_segment(shape);
    Patch patch;
    patch.build(s.vertex_id.size(), s.own_vertices, s.triangle);
    initialize_loads(patch, 1e6, s);
    for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
      const LocalTriangle& t = s.triangle[f];
      const Vec3 a = widen(s.position[t[0]]);
      const double area =
          0.5 * norm(cross(widen(s.position[t[1]]) - a, widen(s.position[t[2]]) - a));
      EXPECT_NEAR(s.load[f] / std::pow(area, 3), 1 / (radius * radius), 0.15 / (radius * radius));
    }
  }
}

}  // namespace
}  // namespace remaps::simplify
