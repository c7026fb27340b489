#include "remaps/codec/subdivision_hierarchy.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "codec/codec_shapes.h"
#include "support/surface_check.h"

namespace remaps::codec {
namespace {

constexpr std::uint64_t kMemory = 256u << 20;
constexpr unsigned kLevels = 3;

/// Calls check(hierarchy) for all bases at kLevels.
template <class Check>
void for_hierarchies(Check&& check) {
  for (const test::CodecBase& base : test::codec_bases()) {
    SCOPED_TRACE(base.name);
    MemoryBudget budget(kMemory);
    const SubdivisionHierarchy hierarchy(base.vertices(), base.face, kLevels, budget);
    check(hierarchy, base);
  }
}

std::vector<Triangle> triangles(std::span<const Face> faces) {
  std::vector<Triangle> result;
  for (const Face& f : faces) result.push_back({f[0], f[1], f[2]});
  return result;
}

TEST(SubdivisionHierarchy, IsTheSameSurfaceAtEveryLevel) {
  for_hierarchies([](const SubdivisionHierarchy& hierarchy, const test::CodecBase& base) {
    for (unsigned j = 0; j < kLevels; ++j) {
      const SubdivisionLevel& level = hierarchy.level(j);
      EXPECT_EQ(std::int64_t{level.vertices} - level.edges() + level.faces(),
                base.euler_characteristic);
      EXPECT_EQ(level.vertices, hierarchy.vertices(j));
      EXPECT_EQ(level.faces(), base.face.size() << (2 * j));
      const test::CountedSurface counted = test::count_surface(triangles(level.vertex));
      EXPECT_EQ(counted.defect, "");
      EXPECT_EQ(counted.topology.euler_characteristic(), base.euler_characteristic);
    }
    const test::CountedSurface finest =
        test::count_surface(triangles(test::finest_faces(hierarchy)));
    EXPECT_EQ(finest.defect, "");
    EXPECT_EQ(finest.topology.vertices, hierarchy.vertices());
    EXPECT_EQ(finest.topology.euler_characteristic(), base.euler_characteristic);
  });
}

TEST(SubdivisionHierarchy, JoinsSidesOfTheSameEnds) {
  for_hierarchies([](const SubdivisionHierarchy& hierarchy, const test::CodecBase&) {
    for (unsigned j = 0; j < kLevels; ++j) {
      const SubdivisionLevel& level = hierarchy.level(j);
      std::map<std::pair<std::uint32_t, std::uint32_t>, Side> side_of;
      for (std::uint32_t f = 0; f < level.faces(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const Side s(f, k);
          EXPECT_TRUE(side_of.emplace(std::pair(level.from(s), level.to(s)), s).second);
        }
      }
      std::vector<int> sides(level.edges(), 0);
      for (const auto& [ends, s] : side_of) {
        const Side twin = level.twin_of(s);
        const auto found = side_of.find({ends.second, ends.first});
        ASSERT_EQ(twin, found == side_of.end() ? Side() : found->second);
        const std::uint32_t e = level.edge[s.face()][s.corner()];
        ASSERT_LT(e, level.edges());
        ++sides[e];
        if (!twin.none()) {
          ASSERT_EQ(e, level.edge[twin.face()][twin.corner()]);
        }
      }
      for (std::uint32_t e = 0; e < level.edges(); ++e) {
        const Side s = level.side[e];
        ASSERT_EQ(level.edge[s.face()][s.corner()], e);
        ASSERT_EQ(sides[e], level.twin_of(s).none() ? 1 : 2);
      }
    }
  });
}

TEST(SubdivisionHierarchy, NumbersChildrenByTheirParents) {
  for_hierarchies([](const SubdivisionHierarchy& hierarchy, const test::CodecBase&) {
    for (unsigned j = 0; j < kLevels; ++j) {
      const SubdivisionLevel& level = hierarchy.level(j);
      for (std::uint32_t f = 0; f < level.faces(); ++f) {
        const Face& v = level.vertex[f];
        Face m;
        for (unsigned k = 0; k < 3; ++k) m[k] = level.vertices + level.edge[f][k];
        const Face expected[4] = {
            {v[0], m[0], m[2]}, {m[0], v[1], m[1]}, {m[2], m[1], v[2]}, {m[1], m[2], m[0]}};
        for (std::uint32_t c = 0; c < 4; ++c) {
          const Face& child = j + 1 < kLevels ? hierarchy.level(j + 1).vertex[4 * f + c]
                                              : hierarchy.finest_face(4 * std::uint64_t{f} + c);
          ASSERT_EQ(child, expected[c]);
        }
      }
    }
  });
}

TEST(SubdivisionHierarchy, NumbersEdgesByTheirParents) {
  for_hierarchies([](const SubdivisionHierarchy& hierarchy, const test::CodecBase&) {
    for (unsigned j = 0; j + 1 < kLevels; ++j) {
      const SubdivisionLevel &coarse = hierarchy.level(j), &fine = hierarchy.level(j + 1);
      const auto ends = [](const SubdivisionLevel& level, std::uint32_t e) {
        const Side s = level.side[e];
        return std::set<std::uint32_t>{level.from(s), level.to(s)};
      };
      for (std::uint32_t e = 0; e < coarse.edges(); ++e) {
        const std::uint32_t middle = coarse.vertices + e;
        const Side s = coarse.side[e];
        ASSERT_EQ(ends(fine, 2 * e), (std::set{coarse.from(s), middle}));
        ASSERT_EQ(ends(fine, 2 * e + 1), (std::set{coarse.to(s), middle}));
      }
      for (std::uint32_t f = 0; f < coarse.faces(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          // Parallel to edge k: it joins the middles of the two others.
          ASSERT_EQ(ends(fine, 2 * coarse.edges() + 3 * f + k),
                    (std::set{coarse.vertices + coarse.edge[f][(k + 1) % 3],
                              coarse.vertices + coarse.edge[f][(k + 2) % 3]}));
        }
      }
      ASSERT_EQ(fine.edges(), 2 * coarse.edges() + 3 * coarse.faces());
    }
  });
}

TEST(SubdivisionHierarchy, KnowsValenceAndBoundary) {
  for_hierarchies([](const SubdivisionHierarchy& hierarchy, const test::CodecBase& base) {
    const std::vector<Face> faces = test::finest_faces(hierarchy);
    std::set<std::pair<std::uint32_t, std::uint32_t>> directed;
    for (const Face& f : faces) {
      for (unsigned k = 0; k < 3; ++k) directed.insert({f[k], f[(k + 1) % 3]});
    }
    std::vector<std::uint32_t> edges(hierarchy.vertices(), 0);
    std::vector<bool> boundary(hierarchy.vertices(), false);
    for (const auto& [a, b] : directed) {
      ++edges[a];
      if (directed.contains({b, a})) continue;
      ++edges[b];
      boundary[a] = boundary[b] = true;
    }
    bool any = false;
    for (std::uint32_t v = 0; v < hierarchy.vertices(); ++v) {
      ASSERT_EQ(hierarchy.on_boundary(v), boundary[v]) << "vertex " << v;
      any = any || boundary[v];
      const std::uint32_t expected = v < hierarchy.vertices(0) ? hierarchy.valence(v)
                                     : boundary[v]             ? 4u
                                                               : 6u;
      ASSERT_EQ(edges[v], expected) << "vertex " << v;
    }
    EXPECT_EQ(any, base.boundary);
  });
}

TEST(SubdivisionHierarchy, OfNoLevelIsTheBase) {
  for (const test::CodecBase& base : test::codec_bases()) {
    MemoryBudget budget(kMemory);
    const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 0, budget);
    EXPECT_EQ(hierarchy.vertices(), base.vertices());
    EXPECT_EQ(hierarchy.vertices(0), base.vertices());
    EXPECT_EQ(test::finest_faces(hierarchy), base.face) << base.name;
    bool any = false;
    for (std::uint32_t v = 0; v < base.vertices(); ++v) any = any || hierarchy.on_boundary(v);
    EXPECT_EQ(any, base.boundary) << base.name;
  }
}

std::string refusal(std::uint32_t vertices, std::vector<Face> base, unsigned levels = 1) {
  try {
    MemoryBudget budget(kMemory);
    SubdivisionHierarchy hierarchy(vertices, base, levels, budget);
  } catch (const GeometryError& error) {
    return error.what();
  }
  return "";
}

TEST(SubdivisionHierarchy, RefusesBasesThatAreNoManifolds) {
  const auto expect_part = [](const std::string& why, const std::string& part) {
    EXPECT_NE(why.find(part), std::string::npos) << why;
  };
  for (const unsigned levels : {0u, 1u, 3u}) {
    expect_part(refusal(3, {{0, 1, 3}}, levels), "three different corners among the 3");
    expect_part(refusal(3, {{0, 1, 1}}, levels), "three different corners");
    expect_part(refusal(4, {{0, 1, 2}, {0, 1, 3}}, levels), "another of the same direction");
    expect_part(refusal(3, {{0, 1, 2}, {0, 1, 2}}, levels), "another of the same direction");
    expect_part(refusal(4, {{0, 1, 2}}, levels), "base vertex 3 has no face");
    expect_part(refusal(5, {{0, 1, 2}, {0, 3, 4}}, levels), "vertex 0 are not one fan");
    EXPECT_EQ(refusal(3, {{0, 1, 2}}, levels), "");
  }
}

TEST(SubdivisionHierarchy, RefusesWhatIsTooLarge) {
  const std::vector<Face> one{{0, 1, 2}};
  EXPECT_NE(refusal(3, one, 15), "");
  const test::CodecBase ball = test::base_of(test::icosphere(2));  // 320 faces
  EXPECT_NE(refusal(ball.vertices(), ball.face, 11), "");
  MemoryBudget small(1 << 20);
  EXPECT_THROW(SubdivisionHierarchy(3, one, 9, small), BudgetError);
  EXPECT_EQ(small.available(), small.total());
}

}  // namespace
}  // namespace remaps::codec
