#include "remaps/mesh/patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "support/shapes.h"
#include "support/surface_check.h"

namespace remaps {
namespace {

using test::Shape;
using Kind = ManifoldDefect::Kind;

Patch patch_of(const Shape& shape) {
  Patch patch;
  const ManifoldDefect defect =
      patch.build(shape.position.size(), shape.position.size(), shape.triangle);
  EXPECT_EQ(defect.kind, Kind::kNone) << shape.name;
  return patch;
}

ManifoldDefect defect_of(std::size_t vertices, const std::vector<LocalTriangle>& triangles,
                         std::size_t own = 1000) {
  Patch patch;
  return patch.build(vertices, std::min(own, vertices), triangles);
}

void expect_same_kind_of_surface(const Patch& patch, const Shape& shape) {
  const test::CountedSurface counted = test::count_surface(test::alive_faces(patch));
  EXPECT_EQ(counted.defect, "");
  EXPECT_EQ(counted.topology.euler_characteristic(), shape.euler_characteristic);
  EXPECT_EQ(counted.topology.components, static_cast<std::uint64_t>(shape.components));
  EXPECT_EQ(counted.topology.boundary_loops, static_cast<std::uint64_t>(shape.boundary_loops));
}

/// All (vertex, apex) that may be removed.
std::vector<std::pair<LocalIndex, unsigned>> legal_removals(const Patch& patch) {
  std::vector<std::pair<LocalIndex, unsigned>> legal;
  Star star;
  for (LocalIndex v = 0; v < patch.vertex_slots(); ++v) {
    if (!patch.vertex_alive(v) || !patch.star(v, star)) continue;
    for (unsigned apex = 0; apex < star.ring_size(); ++apex) {
      if (patch.fan_keeps_topology(star, apex)) legal.emplace_back(v, apex);
    }
  }
  return legal;
}

/// Removes a vertex and checks what the record promises about face ids.
void remove(Patch& patch, LocalIndex v, unsigned apex) {
  Star star;
  ASSERT_TRUE(patch.star(v, star));
  const unsigned n = star.ring_size();
  patch.retriangulate(v, star, apex);
  for (unsigned j = 0; j + 2 < n; ++j) {
    const LocalTriangle expected{star.ring[apex], star.ring[(apex + 1 + j) % n],
                                 star.ring[(apex + 2 + j) % n]};
    ASSERT_EQ(patch.face(face_of(star.corner[j])), expected);
  }
  for (unsigned i = n - 2; i < star.wedges; ++i)
    ASSERT_FALSE(patch.face_alive(face_of(star.corner[i])));
  ASSERT_FALSE(patch.vertex_alive(v));
}

TEST(Patch, BuildsEveryShape) {
  for (const Shape& shape : test::all_shapes()) {
    SCOPED_TRACE(shape.name);
    const Patch patch = patch_of(shape);
    EXPECT_EQ(test::patch_defect(patch), "");
    expect_same_kind_of_surface(patch, shape);
    EXPECT_EQ(patch.face_slots(), shape.triangle.size());
    EXPECT_EQ(patch.vertex_slots(), shape.position.size());
  }
}

TEST(Patch, IsTheSameAfterBeingUsedForAnotherMesh) {
  Patch patch = patch_of(test::torus(20, 20));
  for (const Shape& shape : test::all_shapes()) {
    patch.build(shape.position.size(), shape.position.size(), shape.triangle);
    EXPECT_EQ(test::patch_defect(patch), "") << shape.name;
  }
  EXPECT_EQ(patch.build(0, 0, {}).kind, Kind::kNone);
  EXPECT_EQ(patch.face_slots(), 0u);
}

TEST(Patch, LeavesVerticesWithoutFacesDead) {
  Patch patch;
  const std::vector<LocalTriangle> triangles{{0, 2, 4}};
  EXPECT_EQ(patch.build(6, 6, triangles).kind, Kind::kNone);
  for (LocalIndex v = 0; v < 6; ++v) EXPECT_EQ(patch.vertex_alive(v), v % 2 == 0 && v < 5);
  EXPECT_EQ(test::patch_defect(patch), "");
}

TEST(Patch, AnswersWhichVerticesAreJoined) {
  for (const Shape& shape : {test::icosphere(1), test::annulus(5, 2), test::bipyramid(30)}) {
    const Patch patch = patch_of(shape);
    std::set<std::pair<LocalIndex, LocalIndex>> edges;
    for (const LocalTriangle& t : shape.triangle) {
      for (std::size_t i = 0; i < 3; ++i) {
        edges.emplace(t[i], t[(i + 1) % 3]);
        edges.emplace(t[(i + 1) % 3], t[i]);
      }
    }
    for (LocalIndex a = 0; a < patch.vertex_slots(); ++a) {
      for (LocalIndex b = 0; b < patch.vertex_slots(); ++b) {
        ASSERT_EQ(patch.has_edge(a, b), edges.contains({a, b})) << shape.name << a << ' ' << b;
      }
    }
  }
}

TEST(Patch, StaysAManifoldOfTheSameKindDownToTheLeast) {
  for (const Shape& shape : test::all_shapes()) {
    for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      Patch patch = patch_of(shape);
      std::size_t left = shape.position.size();
      while (true) {
        const auto legal = legal_removals(patch);
        if (legal.empty()) break;
        const auto [v, apex] = legal[random() % legal.size()];
        remove(patch, v, apex);
        --left;
        if (HasFatalFailure()) return;
        ASSERT_EQ(test::patch_defect(patch), "") << "after removing " << v << ", apex " << apex;
        expect_same_kind_of_surface(patch, shape);
        if (HasFailure()) return;
      }
      EXPECT_GE(left, static_cast<std::size_t>(shape.least_vertices));
      EXPECT_LE(left, static_cast<std::size_t>(shape.most_vertices));
    }
  }
}

TEST(Patch, AllowsExactlyTheFansThatKeepTheSurfaceAManifold) {
  // Against the definition: put the fan in and count what comes out.
  for (const std::uint64_t seed : {1u, 2u}) {
    for (const Shape& shape :
         {test::tetrahedron(), test::octahedron(), test::torus(4, 4), test::torus(3, 3),
          test::disk(2), test::annulus(4, 1), test::annulus(3, 2), test::bipyramid(3)}) {
      SCOPED_TRACE(shape.name + ", seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      Patch patch = patch_of(shape);
      while (true) {
        Star star;
        for (LocalIndex v = 0; v < patch.vertex_slots(); ++v) {
          if (!patch.vertex_alive(v) || !patch.star(v, star) || star.ring_size() < 3) continue;
          for (unsigned apex = 0; apex < star.ring_size(); ++apex) {
            std::vector<Triangle> faces = test::alive_faces(patch);
            std::erase_if(faces, [&](const Triangle& t) {
              return std::find(t.begin(), t.end(), v) != t.end();
            });
            const unsigned n = star.ring_size();
            for (unsigned j = 0; j + 2 < n; ++j) {
              faces.push_back(
                  {star.ring[apex], star.ring[(apex + 1 + j) % n], star.ring[(apex + 2 + j) % n]});
            }
            const test::CountedSurface counted = test::count_surface(faces);
            std::set<std::set<VertexId>> sets;
            for (const Triangle& t : faces) sets.emplace(t.begin(), t.end());
            const bool sound =
                counted.defect.empty() && sets.size() == faces.size() &&
                counted.topology.euler_characteristic() == shape.euler_characteristic &&
                counted.topology.boundary_loops ==
                    static_cast<std::uint64_t>(shape.boundary_loops) &&
                counted.topology.components == static_cast<std::uint64_t>(shape.components);
            if (patch.fan_keeps_topology(star, apex)) {
              ASSERT_TRUE(sound) << "vertex " << v << ", apex " << apex << ": allowed";
            } else {
              ASSERT_FALSE(sound) << "vertex " << v << ", apex " << apex << ": refused";
            }
          }
        }
        const auto legal = legal_removals(patch);
        if (legal.empty()) break;
        const auto [v, apex] = legal[random() % legal.size()];
        remove(patch, v, apex);
      }
    }
  }
}

TEST(Patch, RefusesToRemoveAVertexOfATetrahedron) {
  EXPECT_TRUE(legal_removals(patch_of(test::tetrahedron())).empty());
}

TEST(Patch, RefusesToShortenALoopOfThree) {
  EXPECT_TRUE(legal_removals(patch_of(test::annulus(3, 1))).empty());
  const Shape three{"triangle", {{}, {}, {}}, {{0, 1, 2}}, 1, 1, 1, 3, 3};
  EXPECT_TRUE(legal_removals(patch_of(three)).empty());
}

TEST(Patch, RefusesTheEdgeOfAnHourglass) {
  // Two pyramids of six faces with a common waist 0 1 2, which is no face: no vertex of the waist
  // may be merged into another.
  const Shape hourglass{"hourglass",
                        {{}, {}, {}, {}, {}, {}, {}, {}, {}},
                        {{0, 1, 3},
                         {1, 4, 3},
                         {1, 2, 4},
                         {2, 5, 4},
                         {2, 0, 5},
                         {0, 3, 5},
                         {3, 4, 5},
                         {1, 0, 6},
                         {7, 1, 6},
                         {2, 1, 7},
                         {8, 2, 7},
                         {0, 2, 8},
                         {6, 0, 8},
                         {7, 6, 8}}};
  const Patch patch = patch_of(hourglass);
  ASSERT_EQ(test::patch_defect(patch), "");
  for (LocalIndex v = 0; v < 3; ++v) {
    Star star;
    ASSERT_TRUE(patch.star(v, star));
    for (unsigned apex = 0; apex < star.ring_size(); ++apex) {
      if (star.ring[apex] < 3) {
        EXPECT_FALSE(patch.fan_keeps_topology(star, apex)) << v;
      }
    }
  }
  EXPECT_FALSE(legal_removals(patch).empty());
}

TEST(Patch, HandlesAPoleOfValence4320) {
  for (const bool closed : {true, false}) {
    Shape shape = closed ? test::bipyramid(4320) : test::cone(4320);
    Patch patch = patch_of(shape);
    EXPECT_EQ(patch.valence(0), 4320u);
    Star star;
    EXPECT_FALSE(patch.star(0, star));
    EXPECT_EQ(test::patch_defect(patch), "");
    // Rim vertices go, each into its neighbour on the rim, until the pole itself can go.
    for (LocalIndex v = 4320; v > 5; --v) {
      ASSERT_TRUE(patch.star(v, star));
      unsigned apex = 0;
      while (star.ring[apex] != v - 1) ++apex;
      ASSERT_TRUE(patch.fan_keeps_topology(star, apex)) << v;
      patch.retriangulate(v, star, apex);
    }
    EXPECT_EQ(patch.valence(0), 5u);
    EXPECT_TRUE(patch.star(0, star));
    EXPECT_EQ(test::patch_defect(patch), "");
    expect_same_kind_of_surface(patch, shape);
  }
}

TEST(Patch, CountsValencesBeyondSixteenBits) {
  // A count that sticks at 65535 would end far below the truth, and a star would run over.
  Patch patch = patch_of(test::bipyramid(70'000));
  EXPECT_EQ(patch.valence(0), 70'000u);
  Star star;
  for (LocalIndex v = 70'000; v > 4465; --v) {
    ASSERT_TRUE(patch.star(v, star));
    unsigned apex = 0;
    while (star.ring[apex] != v - 1) ++apex;
    patch.retriangulate(v, star, apex);
  }
  EXPECT_EQ(patch.valence(0), 4465u);
  EXPECT_FALSE(patch.star(0, star));
}

TEST(Patch, ReportsDegenerateFaces) {
  for (const LocalTriangle& t :
       {LocalTriangle{3, 3, 1}, LocalTriangle{1, 3, 3}, LocalTriangle{3, 1, 3}}) {
    const ManifoldDefect defect = defect_of(4, {{0, 1, 2}, t});
    EXPECT_EQ(defect.kind, Kind::kDegenerateFace);
    EXPECT_EQ(std::set({defect.vertex_a, defect.vertex_b}), std::set<LocalIndex>({1, 3}));
  }
  EXPECT_EQ(defect_of(4, {{0, 1, 2}, {3, 3, 3}}).kind, Kind::kDegenerateFace);
}

TEST(Patch, ReportsAnEdgeWithThreeFaces) {
  const std::vector<LocalTriangle> book{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  const ManifoldDefect defect = defect_of(5, book);
  EXPECT_EQ(defect.kind, Kind::kEdgeFaces);
  EXPECT_EQ(std::set({defect.vertex_a, defect.vertex_b}), std::set<LocalIndex>({0, 1}));
  EXPECT_EQ(defect_of(5, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}).kind, Kind::kEdgeFaces);
  EXPECT_EQ(defect_of(5, book, 0).kind, Kind::kEdgeFaces) << "edges are checked at all vertices";
}

TEST(Patch, ReportsFacesOrientedAgainstEachOther) {
  const ManifoldDefect defect = defect_of(4, {{0, 1, 2}, {0, 1, 3}});
  EXPECT_EQ(defect.kind, Kind::kOrientation);
  EXPECT_EQ(std::set({defect.vertex_a, defect.vertex_b}), std::set<LocalIndex>({0, 1}));
  EXPECT_EQ(defect_of(3, {{0, 1, 2}, {0, 1, 2}}).kind, Kind::kOrientation) << "a doubled face";
}

TEST(Patch, ReportsTwoFansAtAVertexThatIsOwn) {
  const std::vector<LocalTriangle> bow{{2, 0, 1}, {2, 3, 4}};
  const ManifoldDefect defect = defect_of(5, bow);
  EXPECT_EQ(defect.kind, Kind::kVertexFans);
  EXPECT_EQ(defect.vertex_a, 2u);
  EXPECT_EQ(defect_of(5, bow, 3).kind, Kind::kVertexFans);
  EXPECT_EQ(defect_of(5, bow, 2).kind, Kind::kNone) << "of a foreign vertex part may be missing";

  const Shape ball = test::icosphere(1);  // two closed surfaces that touch in a point
  std::vector<LocalTriangle> touching = ball.triangle;
  for (LocalTriangle t : ball.triangle) {
    for (LocalIndex& v : t) v = v == 5 ? 5 : v + 42;
    touching.push_back(t);
  }
  EXPECT_EQ(defect_of(84, touching).kind, Kind::kVertexFans);
  EXPECT_EQ(defect_of(84, touching).vertex_a, 5u);
}

}  // namespace
}  // namespace remaps
