#include "remaps/map/segment_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "support/random_records.h"
#include "support/simplified_shape.h"

namespace remaps::map {
namespace {

using test::Shape;
using test::SimplifiedShape;

std::array<double, 3> weights_of(const FacePoint& p) {
  return {1 - p.u - p.v, p.u, p.v};
}
/// A point of a face from its three weights, in the face's own order.
FacePoint point_on(LocalIndex face, const std::array<double, 3>& weight) {
  return {face, weight[1], weight[2]};
}
/// A point of wedge i with weight a on ring[i], b on the next ring point and the rest on the
/// origin.
FacePoint point_in_wedge(const Retriangulation& r, unsigned i, double a, double b) {
  std::array<double, 3> weight{};
  weight[r.turn[i]] = 1 - a - b;
  weight[(r.turn[i] + 1u) % 3] = a;
  weight[(r.turn[i] + 2u) % 3] = b;
  return point_on(r.face[i], weight);
}
FacePoint random_point(std::mt19937_64& random, LocalIndex face) {
  std::uniform_real_distribution<double> unit(0, 1);
  double u = unit(random);
  double v = unit(random);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {face, u, v};
}

/// Place in the plane of a record, in units of the star's radius.
PlanarPoint place_in_wedge(const Retriangulation& r, unsigned i, const FacePoint& p) {
  const auto w = weights_of(p);
  const double a = w[(r.turn[i] + 1u) % 3] / kGridRadius;
  const double b = w[(r.turn[i] + 2u) % 3] / kGridRadius;
  const GridPoint q = r.ring[i];
  const GridPoint s = r.ring[r.next(i)];
  return {a * q.x + b * s.x, a * q.y + b * s.y};
}
PlanarPoint place_in_fan(const Retriangulation& r, unsigned j, const FacePoint& p) {
  const auto w = weights_of(p);
  PlanarPoint place;
  for (unsigned c = 0; c < 3; ++c) {
    place.x += w[c] * r.ring[r.corner(j, c)].x / kGridRadius;
    place.y += w[c] * r.ring[r.corner(j, c)].y / kGridRadius;
  }
  return place;
}
double distance(const PlanarPoint& a, const PlanarPoint& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}
void expect_on_face(const FacePoint& p) {
  EXPECT_GE(p.u, 0);
  EXPECT_GE(p.v, 0);
  EXPECT_LE(p.u + p.v, 1 + 1e-15);
}

class OneRecord : public testing::TestWithParam<bool> {
 protected:
  Retriangulation record(std::mt19937_64& random) const {
    return test::random_record(random, GetParam());
  }
};

TEST_P(OneRecord, IsUndoneByItsInverse) {
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    std::mt19937_64 random(seed);
    const Retriangulation r = record(random);
    for (int k = 0; k < 10; ++k) {
      const auto wedge = static_cast<unsigned>(random() % r.wedges);
      const FacePoint start = random_point(random, r.face[wedge]);
      FacePoint p = start;
      const unsigned fan = apply_forward(r, wedge, p);
      ASSERT_EQ(p.face, r.face[fan]) << "seed " << seed;
      expect_on_face(p);
      ASSERT_LT(distance(place_in_fan(r, fan, p), place_in_wedge(r, wedge, start)), 1e-10);
      const unsigned back = apply_inverse(r, fan, p);
      ASSERT_EQ(p.face, r.face[back]) << "seed " << seed;
      expect_on_face(p);
      ASSERT_LT(distance(place_in_wedge(r, back, p), place_in_wedge(r, wedge, start)), 1e-10)
          << "seed " << seed;
    }
    for (int k = 0; k < 10; ++k) {
      const auto fan = static_cast<unsigned>(random() % r.triangles());
      const FacePoint start = random_point(random, r.face[fan]);
      FacePoint p = start;
      const unsigned wedge = apply_inverse(r, fan, p);
      const unsigned back = apply_forward(r, wedge, p);
      ASSERT_LT(distance(place_in_fan(r, back, p), place_in_fan(r, fan, start)), 1e-10)
          << "seed " << seed;
    }
  }
}

TEST_P(OneRecord, MapsCornersToCorners) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Retriangulation r = record(random);
    for (unsigned i = 0; i < r.wedges; ++i) {
      for (const bool second : {false, true}) {
        FacePoint p = point_in_wedge(r, i, second ? 0 : 1, second ? 1 : 0);
        const unsigned j = apply_forward(r, i, p);
        const auto w = weights_of(p);
        const auto corner = static_cast<unsigned>(std::find(w.begin(), w.end(), 1.0) - w.begin());
        ASSERT_LT(corner, 3u) << "not a corner: " << p.u << ' ' << p.v;
        ASSERT_EQ(r.corner(j, corner), second ? r.next(i) : i);
        const unsigned back = apply_inverse(r, j, p);
        const auto v = weights_of(p);
        const auto again = static_cast<unsigned>(std::find(v.begin(), v.end(), 1.0) - v.begin());
        ASSERT_LT(again, 3u);
        const unsigned in_wedge = (again + 3 - r.turn[back]) % 3;  // 0: the removed vertex
        ASSERT_NE(in_wedge, 0u);
        ASSERT_EQ(in_wedge == 1 ? back : r.next(back), second ? r.next(i) : i);
      }
    }
  }
}

TEST_P(OneRecord, SendsTheRemovedVertexToOnePlaceAndBackExactly) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Retriangulation r = record(random);
    FacePoint first = point_in_wedge(r, 0, 0, 0);
    const unsigned fan = apply_forward(r, 0, first);
    for (unsigned i = 1; i < r.wedges; ++i) {
      FacePoint p = point_in_wedge(r, i, 0, 0);
      apply_forward(r, i, p);
      ASSERT_EQ(p, first);
    }
    const unsigned wedge = apply_inverse(r, fan, first);
    ASSERT_NEAR(weights_of(first)[r.turn[wedge]], 1, 1e-9);
  }
}

TEST_P(OneRecord, IsContinuousAcrossEdges) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Retriangulation r = record(random);
    for (unsigned i = 0; i + 1 < r.ring_size() || !r.boundary; ++i) {
      const unsigned next = r.next(i);
      if (i >= r.wedges || next >= r.wedges) break;
      const double t = double(random() % (1 << 20)) / (1 << 20);
      // The spoke to ring[next], seen from wedge i and from wedge next.
      FacePoint a = point_in_wedge(r, i, 0, t);
      FacePoint b = point_in_wedge(r, next, t, 0);
      apply_forward(r, i, a);
      apply_forward(r, next, b);
      ASSERT_EQ(a, b);
      if (next == 0) break;
    }
    for (unsigned j = 0; j + 1 < r.triangles(); ++j) {
      // The diagonal from the apex, seen from fan triangles j and j + 1.
      const double t = double(random() % (1 << 20)) / (1 << 20);
      FacePoint a{r.face[j], 0, t};
      FacePoint b{r.face[j + 1], t, 0};
      apply_inverse(r, j, a);
      apply_inverse(r, j + 1, b);
      ASSERT_EQ(a, b);
    }
    for (unsigned i = 0; i < r.wedges; ++i) {
      // The outer edge stays where it is, for the face beyond it knows nothing of the record.
      const double t = double(random() % (1 << 20)) / (1 << 20);
      FacePoint p = point_in_wedge(r, i, 1 - t, t);
      const unsigned j = apply_forward(r, i, p);
      const auto w = weights_of(p);
      double on_edge = 0;
      double at_next = 0;
      for (unsigned c = 0; c < 3; ++c) {
        const bool next = r.corner(j, c) == r.next(i);
        if (next || r.corner(j, c) == i) on_edge += w[c];
        if (next) at_next += w[c];
      }
      ASSERT_NEAR(on_edge, 1, 1e-7);
      ASSERT_NEAR(at_next, t, 1e-7);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Places, OneRecord, testing::Bool(),
                         [](const auto& test) { return test.param ? "Boundary" : "Interior"; });

Vec3 position_of(const Shape& shape, const LocalTriangle& t, const FacePoint& p) {
  const auto w = weights_of(p);
  return w[0] * shape.position[t[0]] + w[1] * shape.position[t[1]] + w[2] * shape.position[t[2]];
}

class WholeSegment : public testing::TestWithParam<std::size_t> {
 protected:
  WholeSegment() : shape_(test::scan_shapes()[GetParam()]) {
    simplified_ = test::simplify_shape(shape_, test::simplify_options(60));
    forward_.build(simplified_.log, shape_.triangle.size(), SegmentMap::Direction::kForward);
    inverse_.build(simplified_.log, shape_.triangle.size(), SegmentMap::Direction::kInverse);
    diagonal_ = test::diagonal_of(shape_);
  }
  Vec3 on_input(const FacePoint& p) const {
    return position_of(shape_, shape_.triangle[p.face], p);
  }
  Vec3 on_base(const FacePoint& p) const {
    return position_of(shape_, simplified_.patch.face(p.face), p);
  }

  Shape shape_;
  SimplifiedShape simplified_;
  SegmentMap forward_, inverse_;
  double diagonal_ = 0;
};

TEST_P(WholeSegment, BringsPointsOfTheInputBack) {
  std::mt19937_64 random(1);
  double worst = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto face = static_cast<LocalIndex>(random() % shape_.triangle.size());
    const FacePoint start = random_point(random, face);
    FacePoint p = start;
    forward_.carry({&p, 1});
    ASSERT_TRUE(simplified_.patch.face_alive(p.face));
    expect_on_face(p);
    inverse_.carry({&p, 1});
    expect_on_face(p);
    worst = std::max(worst, norm(on_input(p) - on_input(start)));
  }
  EXPECT_LT(worst, 1e-6 * diagonal_);
}

TEST_P(WholeSegment, BringsPointsOfTheBaseBack) {
  std::mt19937_64 random(2);
  double worst = 0;
  for (LocalIndex f = 0; f < shape_.triangle.size(); ++f) {
    if (!simplified_.patch.face_alive(f)) continue;
    for (int i = 0; i < 100; ++i) {
      const FacePoint start = random_point(random, f);
      FacePoint p = start;
      inverse_.carry({&p, 1});
      ASSERT_LT(p.face, shape_.triangle.size());
      expect_on_face(p);
      forward_.carry({&p, 1});
      ASSERT_TRUE(simplified_.patch.face_alive(p.face));
      worst = std::max(worst, norm(on_base(p) - on_base(start)));
    }
  }
  EXPECT_LT(worst, 1e-6 * diagonal_);
}

TEST_P(WholeSegment, BringsEveryVertexBackFromAnyOfItsFaces) {
  for (LocalIndex f = 0; f < shape_.triangle.size(); ++f) {
    for (unsigned c = 0; c < 3; ++c) {
      FacePoint p{f, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
      forward_.carry({&p, 1});
      inverse_.carry({&p, 1});
      const Vec3 place = shape_.position[shape_.triangle[f][c]];
      ASSERT_LT(norm(on_input(p) - place), 1e-6 * diagonal_) << "face " << f << " corner " << c;
    }
  }
}

TEST_P(WholeSegment, KeepsTheVerticesThatStay) {
  for (LocalIndex f = 0; f < shape_.triangle.size(); ++f) {
    for (unsigned c = 0; c < 3; ++c) {
      const LocalIndex v = shape_.triangle[f][c];
      if (!simplified_.patch.vertex_alive(v)) continue;
      FacePoint p{f, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
      forward_.carry({&p, 1});
      const auto w = weights_of(p);
      const auto corner = static_cast<std::size_t>(std::find(w.begin(), w.end(), 1.0) - w.begin());
      ASSERT_LT(corner, 3u) << "vertex " << v;
      ASSERT_EQ(simplified_.patch.face(p.face)[corner], v);
    }
  }
}

TEST_P(WholeSegment, IsContinuousAcrossTheEdgesOfTheInput) {
  Patch input;
  input.build(shape_.position.size(), shape_.position.size(), shape_.triangle);
  std::mt19937_64 random(3);
  double worst = 0;
  const auto end = corner_of(static_cast<LocalIndex>(shape_.triangle.size()), 0);
  for (LocalIndex c = 0; c < end; c = after_corner(c)) {
    const LocalIndex d = input.opposite(c);
    if (d == kNoIndex) continue;
    const double t = double(random() % 1024) / 1024;
    const auto seen_from = [](LocalIndex corner, double at_next) {
      std::array<double, 3> weight{};
      weight[slot_of(next_corner(corner))] = at_next;
      weight[slot_of(previous_corner(corner))] = 1 - at_next;
      return point_on(face_of(corner), weight);
    };
    FacePoint a = seen_from(c, t);
    FacePoint b = seen_from(d, 1 - t);
    forward_.carry({&a, 1});
    forward_.carry({&b, 1});
    worst = std::max(worst, norm(on_base(a) - on_base(b)));
  }
  EXPECT_LT(worst, 1e-6 * diagonal_);
}

TEST_P(WholeSegment, CarriesManyPointsAsItCarriesOne) {
  std::mt19937_64 random(4);
  std::vector<FacePoint> many;
  for (int i = 0; i < 1000; ++i) {
    many.push_back(
        random_point(random, static_cast<LocalIndex>(random() % shape_.triangle.size())));
  }
  std::vector<FacePoint> one_by_one = many;
  forward_.carry(many);
  for (FacePoint& p : one_by_one) forward_.carry({&p, 1});
  EXPECT_EQ(many, one_by_one);
}

INSTANTIATE_TEST_SUITE_P(Scans, WholeSegment, testing::Range<std::size_t>(0, 5));

TEST(SegmentMap, IsTheIdentityForAnEmptyLog) {
  RetriangulationLog log;
  SegmentMap map;
  for (const auto direction : {SegmentMap::Direction::kForward, SegmentMap::Direction::kInverse}) {
    map.build(log, 3, direction);
    FacePoint p{2, 0.25, 0.5};
    map.carry({&p, 1});
    EXPECT_EQ(p, (FacePoint{2, 0.25, 0.5}));
  }
}

TEST(SegmentMap, RefusesARecordThatNamesAFaceTwice) {
  std::mt19937_64 random(1);
  Retriangulation r = test::random_record(random, false, 20);
  r.face[1] = r.face[0];
  RetriangulationLog log;
  log.append(r);
  SegmentMap map;
  EXPECT_THROW(map.build(log, 20, SegmentMap::Direction::kForward), CorruptionError);
  EXPECT_THROW(map.build(log, 20, SegmentMap::Direction::kInverse), CorruptionError);
}

}  // namespace
}  // namespace remaps::map
