#include "remaps/simplify/feature_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "remaps/map/segment_map.h"
#include "simplify/replay_log.h"
#include "support/cut_shape.h"
#include "support/temp_files.h"

namespace remaps::simplify {
namespace {

using test::Shape;
using test::SimplifiedShape;

constexpr double kAngle = std::numbers::pi / 6;

using Edge = std::pair<VertexId, VertexId>;

FeatureOptions options(double angle_rad, double loose, double per_corner) {
  FeatureOptions result;
  result.angle_rad = angle_rad;
  result.least_loose = loose;
  result.least_per_corner = per_corner;
  return result;
}

/// Shapes with sharp edges, moved a little along their sides so that nothing is regular.
std::vector<Shape> sharp_shapes() {
  std::vector<Shape> shapes{test::cube(16), test::drum(10, 8),
                            test::together(test::cube(7), test::drum(6, 5))};
  for (Vec3& p : shapes[0].position) {
    const auto move = [](double x, double y) { return x + 0.02 * (1 - x * x) * std::sin(9 * y); };
    p = {move(p.x, p.y + p.z), move(p.y, p.z - p.x), move(p.z, p.x * p.y)};
  }
  return shapes;
}

Patch patch_of(const Segment& s) {
  Patch patch;
  EXPECT_EQ(patch.build(s.vertex_id.size(), s.own_vertices, s.triangle).kind,
            ManifoldDefect::Kind::kNone);
  return patch;
}

Edge edge_of(const Patch& patch, const Segment& s, LocalIndex corner) {
  const VertexId a = s.vertex_id[patch.corner_vertex(next_corner(corner))];
  const VertexId b = s.vertex_id[patch.corner_vertex(previous_corner(corner))];
  return {std::min(a, b), std::max(a, b)};
}

/// Edges with a mark; both faces must agree.
std::map<Edge, int> marked_edges(const Patch& patch, const Segment& s) {
  std::map<Edge, int> marked;
  for (LocalIndex f = 0; f < patch.face_slots(); ++f) {
    if (!patch.face_alive(f)) continue;
    for (LocalIndex i = 0; i < 3; ++i) {
      if (patch.is_feature(corner_of(f, i))) ++marked[edge_of(patch, s, corner_of(f, i))];
    }
  }
  return marked;
}

/// A sheet with a fold along the x axis that fades out on both sides of the middle.
Shape folded_sheet(double reach) {
  constexpr unsigned kSide = 40;
  const auto height = [reach](double x, double y) {
    const double fade = std::cos(0.5 * std::numbers::pi * std::min(1.0, std::fabs(x) / reach));
    return fade * fade * std::fabs(y) * std::exp(-y * y / 0.09);
  };
  Shape s;
  for (unsigned i = 0; i <= kSide; ++i) {
    for (unsigned j = 0; j <= kSide; ++j) {
      const double x = 2.0 * i / kSide - 1;
      const double y = 2.0 * j / kSide - 1;
      s.position.push_back({x, y, height(x, y)});
      if (i == kSide || j == kSide) continue;
      const LocalIndex a = i * (kSide + 1) + j;
      const LocalIndex b = a + kSide + 1;
      s.triangle.push_back({a, b, b + 1});
      s.triangle.push_back({a, b + 1, a + 1});
    }
  }
  return s;
}

TEST(FeatureEdges, AreThoseSharperThanTheAngle) {
  struct Case {
    Shape shape;
    std::uint64_t edges, corners;
  };
  for (const Case& c : {Case{test::cube(9), 12 * 9, 8}, Case{test::drum(10, 8), 2 * 60, 0},
                        Case{test::icosphere(3), 0, 0}}) {
    SCOPED_TRACE(c.shape.name);
    Segment s = test::whole_segment(c.shape);
    Patch patch = patch_of(s);
    const FeatureCounts counts = find_features(options(kAngle, 0, 0), patch, s);
    EXPECT_EQ(counts.edges, c.edges);
    EXPECT_EQ(counts.corners, c.corners);
    EXPECT_EQ(counts.dropped, 0u);
    EXPECT_EQ(count_features(patch), c.edges);
    EXPECT_EQ(std::count(s.locked.begin(), s.locked.end(), 1), static_cast<long>(c.corners));
    for (const auto& [edge, faces] : marked_edges(patch, s)) EXPECT_EQ(faces, 2);
  }
  // Sharper than a right angle nothing is.
  Segment s = test::whole_segment(test::cube(5));
  Patch patch = patch_of(s);
  EXPECT_EQ(find_features(options(0.51 * std::numbers::pi, 0, 0), patch, s).edges, 0u);
}

TEST(FeatureEdges, WithLooseEndsGoWhenTheyAreShort) {
  const Shape shape = folded_sheet(0.5);
  const auto find = [&](double least, Segment& s) {
    s = test::whole_segment(shape);
    Patch patch = patch_of(s);
    const FeatureCounts counts = find_features(options(kAngle, least, 0), patch, s);
    EXPECT_EQ(count_features(patch), counts.edges - counts.dropped);
    return counts;
  };
  Segment s;
  const FeatureCounts kept = find(0.05, s);
  EXPECT_GT(kept.edges, 8u);
  EXPECT_EQ(kept.dropped, 0u);
  EXPECT_EQ(kept.corners, 2u);
  const FeatureCounts dropped = find(2, s);
  EXPECT_EQ(dropped.edges, kept.edges);
  EXPECT_EQ(dropped.dropped, kept.edges);
  EXPECT_EQ(dropped.corners, 0u);
  // The sheet's border ends a feature as well as a corner does.
  const Shape through = folded_sheet(50);
  s = test::whole_segment(through);
  Patch patch = patch_of(s);
  const FeatureCounts all = find_features(options(kAngle, 100, 0), patch, s);
  EXPECT_EQ(all.edges, 40u);
  EXPECT_EQ(all.dropped, 0u);
  EXPECT_EQ(all.corners, 2u);
}

TEST(FeatureEdges, GoWhereTheyAreRichInCornersAndPoorInLength) {
  // One vertex pulled out of a smooth sheet, and a cube's edges.
  Shape spike = test::disk(20);
  spike.position[30].z = 0.1;
  const Shape shape = test::together(spike, test::cube(8));
  Segment s = test::whole_segment(shape);
  Patch patch = patch_of(s);
  const FeatureCounts all = find_features(options(kAngle, 0, 0), patch, s);
  EXPECT_GE(all.edges, 12u * 8 + 6);
  EXPECT_GT(all.corners, 8u);
  s = test::whole_segment(shape);
  patch = patch_of(s);
  const FeatureCounts counts = find_features(options(kAngle, 0, 0.2), patch, s);
  EXPECT_EQ(counts.edges, all.edges);
  EXPECT_EQ(counts.dropped, all.edges - 12 * 8);
  EXPECT_EQ(counts.corners, 8u);
  EXPECT_EQ(count_features(patch), 12u * 8);
  // The rims of a drum are loops without a corner: of 30 edges, and of 6.
  for (const unsigned rings : {5u, 1u}) {
    s = test::whole_segment(test::drum(rings, 4));
    patch = patch_of(s);
    EXPECT_EQ(find_features(options(1.2, 0, 5.9), patch, s).dropped, 0u);
    s = test::whole_segment(test::drum(rings, 4));
    patch = patch_of(s);
    const FeatureCounts rims = find_features(options(1.2, 0, 6.5), patch, s);
    EXPECT_EQ(rims.edges, 12u * rings);
    EXPECT_EQ(rims.dropped, rings == 1 ? rims.edges : 0u);
  }
  // What a locked vertex touches may go on in another segment.
  s = test::whole_segment(shape);
  s.locked[30] = 1;
  patch = patch_of(s);
  EXPECT_EQ(find_features(options(kAngle, 0, 0.2), patch, s).dropped, 0u);
}

class FeatureEdgesOnDisk : public test::TempFiles {};

TEST_F(FeatureEdgesOnDisk, AreTheSameInEverySegmentAndAtTheNextLevel) {
  MemoryBudget budget(std::uint64_t{64} << 20);
  std::ptrdiff_t left_open = 0;
  for (const Shape& shape : sharp_shapes()) {
    SCOPED_TRACE(shape.name);
    Segment whole = test::whole_segment(shape);
    Patch whole_patch = patch_of(whole);
    find_features(options(kAngle, 0, 0), whole_patch, whole);
    const std::map<Edge, int> expected = marked_edges(whole_patch, whole);

    // Checks the edges at own vertices, of which nothing may be missing.
    const auto check = [&](const Patch& patch, const Segment& s) {
      for (LocalIndex f = 0; f < patch.face_slots(); ++f) {
        for (LocalIndex i = 0; i < 3; ++i) {
          const LocalIndex c = corner_of(f, i);
          const bool own = patch.corner_vertex(next_corner(c)) < s.own_vertices ||
                           patch.corner_vertex(previous_corner(c)) < s.own_vertices;
          if (own) {
            ASSERT_EQ(patch.is_feature(c), expected.contains(edge_of(patch, s, c)));
          }
        }
      }
    };
    constexpr std::size_t kSegments = 60;
    const auto first = test::cut_shape(shape, kSegments, 0, directory(), budget);
    std::vector<Vec3f> sample = test::float_positions(shape);
    DomainLevel next(1, SpaceCut(sample, kSegments, 1), directory(), 1 << 16, budget);
    next.carry_features();
    VertexIndex scratch;
    Segment s;
    std::vector<FaceLink> origin;
    std::map<Edge, int> unknown;
    std::uint64_t edges = 0;
    for (std::size_t i = 0; i < kSegments; ++i) {
      first->load(i, scratch, s, origin);
      Patch patch = patch_of(s);
      edges += find_features(options(kAngle, 0, 0), patch, s).edges;
      check(patch, s);
      const auto routed = [&](LocalIndex v) {
        return RoutedVertex{s.vertex_id[v], s.position[v], next.cut().segment_of(s.position[v])};
      };
      for (LocalIndex v = 0; v < s.own_vertices; ++v) next.add_vertex(routed(v), {});
      for (LocalIndex f = 0; f < s.home_faces; ++f) {
        for (LocalIndex k = 0; k < 3; ++k) {
          if ((patch.marks(f) >> (k + 3)) & 1u) ++unknown[edge_of(patch, s, corner_of(f, k))];
        }
        const LocalTriangle t = patch.face(f);
        next.add_face({routed(t[0]), routed(t[1]), routed(t[2])},
                      {0, 0, {static_cast<std::uint32_t>(i), f}, patch.marks(f)});
      }
    }
    EXPECT_EQ(edges, expected.size());
    left_open += std::count_if(unknown.begin(), unknown.end(), [&](const auto& edge) {
      return edge.second == 2 && expected.contains(edge.first);
    });
    edges = 0;
    for (std::size_t i = 0; i < kSegments; ++i) {
      next.load(i, scratch, s, origin);
      ASSERT_EQ(s.feature.size(), s.triangle.size());
      Patch patch = patch_of(s);
      edges += find_features(options(kAngle, 0, 0), patch, s).edges;
      check(patch, s);
    }
    EXPECT_EQ(edges, expected.size());
  }
  EXPECT_GT(left_open, 0) << "the next level had nothing to decide";
}

/// Both simplifiers.
class FeatureRemoval : public testing::TestWithParam<bool> {
 protected:
  static SimplifiedShape simplify(const Shape& shape, std::size_t target) {
    return test::simplify_shape(shape, test::simplify_options(target), {}, GetParam(), kAngle);
  }
};

TEST_P(FeatureRemoval, ObeysTheRulesAndGoesAlongFeaturesOnly) {
  for (const Shape& shape : sharp_shapes()) {
    SCOPED_TRACE(shape.name);
    const SimplifiedShape run = simplify(shape, 0);
    EXPECT_LT(run.left, shape.position.size() / 10) << "stopped early";
    replay(shape, run, test::simplify_options(0));
    EXPECT_EQ(test::patch_defect(run.patch), "");

    Segment s = test::whole_segment(shape);
    Patch patch = patch_of(s);
    const FeatureCounts counts = find_features(options(kAngle, 0, 0), patch, s);
    std::uint64_t features = counts.edges;
    std::size_t along = 0;
    for (std::size_t r = 0; r < run.log.size(); ++r) {
      const RecordView record = run.log.view(r);
      Star star;
      ASSERT_TRUE(patch.star(run.removed[r], star));
      ASSERT_FALSE(s.locked[run.removed[r]]) << "a corner went";
      const Crease crease = crease_of(patch, star);
      if (crease.exists()) {
        ++along;
        ASSERT_LT(crease.to, star.ring_size());
        ASSERT_TRUE(record.apex == crease.from || record.apex == crease.to);
        ASSERT_EQ(record.ring[crease.from].y, 0);
        ASSERT_EQ(record.ring[crease.to].y, 0);
        --features;
      }
      patch.retriangulate(run.removed[r], star, record.apex);
    }
    EXPECT_EQ(count_features(patch), features);
    EXPECT_EQ(marked_edges(patch, s), marked_edges(run.patch, run.segment));
    for (const auto& [edge, faces] : marked_edges(patch, s)) EXPECT_EQ(faces, 2);
    EXPECT_GT(along, counts.edges / 2);
  }
}

TEST_P(FeatureRemoval, LeavesPointsOfFeaturesOnFeatures) {
  for (const Shape& shape : sharp_shapes()) {
    SCOPED_TRACE(shape.name);
    const SimplifiedShape run = simplify(shape, 60);
    Segment s = test::whole_segment(shape);
    Patch input = patch_of(s);
    find_features(options(kAngle, 0, 0), input, s);
    std::vector<std::uint8_t> on_feature(shape.position.size(), 0);
    for (const auto& [edge, faces] : marked_edges(input, s)) {
      on_feature[edge.first] = on_feature[edge.second] = 1;
    }
    // The least weight on a corner opposite to a feature of its face.
    const auto distance = [](const Patch& patch, const map::FacePoint& p) {
      const std::array<double, 3> weight{1 - p.u - p.v, p.u, p.v};
      double least = 1;
      for (LocalIndex i = 0; i < 3; ++i) {
        if (patch.is_feature(corner_of(p.face, i))) least = std::min(least, std::fabs(weight[i]));
      }
      return least;
    };
    map::SegmentMap forward;
    forward.build(run.log, run.segment.home_faces, map::SegmentMap::Direction::kForward);
    std::vector<map::FacePoint> on_base(run.log.size());
    forward.carry_removed(on_base);
    std::size_t tried = 0;
    for (std::size_t r = 0; r < on_base.size(); ++r) {
      if (!on_feature[run.removed[r]]) continue;
      ++tried;
      ASSERT_LT(distance(run.patch, on_base[r]), 1e-12);
    }
    EXPECT_GT(tried, 50u);

    std::vector<map::FacePoint> point;
    for (LocalIndex f = 0; f < run.patch.face_slots(); ++f) {
      if (!run.patch.face_alive(f)) continue;
      for (LocalIndex i = 0; i < 3; ++i) {
        if (!run.patch.is_feature(corner_of(f, i))) continue;
        for (unsigned k = 0; k <= 64; ++k) {
          std::array<double, 3> weight{};
          weight[(i + 1) % 3] = k / 64.0;
          weight[(i + 2) % 3] = 1 - k / 64.0;
          point.push_back({f, weight[1], weight[2]});
        }
      }
    }
    map::SegmentMap inverse;
    inverse.build(run.log, run.segment.home_faces, map::SegmentMap::Direction::kInverse);
    std::vector<map::FacePoint> back = point;
    inverse.carry(back);
    for (const map::FacePoint& p : back) {
      const LocalTriangle t = input.face(p.face);
      const std::array<double, 3> weight{1 - p.u - p.v, p.u, p.v};
      const auto most = std::max_element(weight.begin(), weight.end());
      const bool at_vertex = *most > 1 - 1e-12 && on_feature[t[std::size_t(most - weight.begin())]];
      ASSERT_TRUE(at_vertex || distance(input, p) < 1e-12);
    }
    // And forward again.
    forward.carry(back);
    const auto place = [&](const map::FacePoint& p) {
      const LocalTriangle t = run.patch.face(p.face);
      return (1 - p.u - p.v) * shape.position[t[0]] + p.u * shape.position[t[1]] +
             p.v * shape.position[t[2]];
    };
    for (std::size_t i = 0; i < point.size(); ++i) {
      ASSERT_LT(norm(place(back[i]) - place(point[i])), 1e-9);
    }
  }
}

TEST_P(FeatureRemoval, RemovesAsBeforeWhereNothingIsSharp) {
  for (const Shape& shape : test::scan_shapes()) {
    const auto run = [&](double angle_rad) {
      return test::simplify_shape(shape, test::simplify_options(60), {}, GetParam(), angle_rad);
    };
    const SimplifiedShape with = run(std::numbers::pi);  // nothing is sharper
    const SimplifiedShape without = run(0);
    EXPECT_TRUE(with.patch.has_features());
    EXPECT_FALSE(without.patch.has_features());
    EXPECT_TRUE(std::equal(with.log.words().begin(), with.log.words().end(),
                           without.log.words().begin(), without.log.words().end()))
        << shape.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Simplifiers, FeatureRemoval, testing::Bool(),
                         [](const auto& test) { return test.param ? "Draft" : "Careful"; });

}  // namespace
}  // namespace remaps::simplify
