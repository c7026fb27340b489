#include "remaps/mesh/domain_level.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "support/cut_shape.h"
#include "support/temp_files.h"

namespace remaps {
namespace {

using test::Shape;

/// (number of segments, level)
class DomainLevelTest : public test::TempFiles,
                        public testing::WithParamInterface<std::pair<std::size_t, unsigned>> {
 protected:
  std::size_t segments() const { return GetParam().first; }
  unsigned level() const { return GetParam().second; }

  MemoryBudget budget_{std::uint64_t{64} << 20};
};

/// The face's corners as global ids, the least first, orientation kept.
Triangle canonical(const Segment& s, const LocalTriangle& t) {
  Triangle ids{s.vertex_id[t[0]], s.vertex_id[t[1]], s.vertex_id[t[2]]};
  std::rotate(ids.begin(), std::min_element(ids.begin(), ids.end()), ids.end());
  return ids;
}

TEST_P(DomainLevelTest, LoadsEachVertexAndFaceWhereItBelongs) {
  const Shape shape =
      test::bumpy(test::together(test::icosphere(3), test::annulus(20, 6)), 0.05, 0.01, 3);
  const std::vector<Vec3f> positions = test::float_positions(shape);
  const auto domain = test::cut_shape(shape, segments(), level(), directory(), budget_);
  ASSERT_EQ(domain->segments(), segments());
  EXPECT_EQ(domain->vertices(), positions.size());
  EXPECT_EQ(domain->faces(), shape.triangle.size());

  // Segments of the corners of each face, straight from the cut.
  std::map<Triangle, std::set<std::uint32_t>> segments_of;
  std::uint64_t mixed = 0;
  std::vector<bool> locked(positions.size(), false);
  const Segment whole = test::whole_segment(shape);
  for (const LocalTriangle& t : shape.triangle) {
    std::set<std::uint32_t>& segments = segments_of[canonical(whole, t)];
    for (const LocalIndex v : t) segments.insert(domain->cut().segment_of(positions[v]));
    if (segments.size() == 1) continue;
    ++mixed;
    for (const LocalIndex v : t) locked[v] = true;
  }
  EXPECT_EQ(domain->mixed_faces(), mixed);

  std::vector<int> owners(positions.size(), 0);
  std::map<Triangle, int> homes;
  std::uint64_t largest = 0;
  const std::uint64_t announced = domain->largest_segment();
  VertexIndex scratch;
  Segment s;
  std::vector<FaceLink> origin;
  for (std::uint32_t i = 0; i < segments(); ++i) {
    domain->load(i, scratch, s, origin);
    ASSERT_EQ(s.vertex_id.size(), s.position.size());
    ASSERT_EQ(s.vertex_id.size(), s.locked.size());
    ASSERT_LE(s.home_faces, s.triangle.size());
    largest = std::max<std::uint64_t>(largest, s.triangle.size());
    std::set<VertexId> unique(s.vertex_id.begin(), s.vertex_id.end());
    EXPECT_EQ(unique.size(), s.vertex_id.size());
    for (LocalIndex v = 0; v < s.vertex_id.size(); ++v) {
      const VertexId id = s.vertex_id[v];
      ASSERT_EQ(s.position[v], positions[id]);
      const bool own = domain->cut().segment_of(positions[id]) == i;
      ASSERT_EQ(v < s.own_vertices, own);
      owners[id] += own;
      EXPECT_EQ(s.locked[v] != 0, own ? bool(locked[id]) : true);
      if (own && level() > 0) {
        EXPECT_EQ(s.quadric[v].q[9], static_cast<float>(id));
      }
    }
    for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
      const Triangle ids = canonical(s, s.triangle[f]);
      ASSERT_TRUE(segments_of.contains(ids)) << "no such face";
      const std::set<std::uint32_t>& expected = segments_of.at(ids);
      EXPECT_TRUE(expected.contains(i));
      EXPECT_EQ(f < s.home_faces, *expected.begin() == i);
      homes[ids] += f < s.home_faces;
      const auto original = canonical(
          whole, shape.triangle[level() == 0 ? s.face_id[f] : static_cast<std::size_t>(s.load[f])]);
      EXPECT_EQ(original, ids);
    }
    ASSERT_EQ(origin.size(), level() == 0 ? 0u : s.home_faces);
    for (LocalIndex f = 0; f < origin.size(); ++f) {
      const auto number = static_cast<LocalIndex>(s.load[f]);
      EXPECT_EQ(origin[f], (FaceLink{number % 7, number}));
    }
    // A segment has every face with one of its own vertices.
    const auto expected = std::count_if(segments_of.begin(), segments_of.end(),
                                        [&](const auto& face) { return face.second.contains(i); });
    EXPECT_EQ(s.triangle.size(), static_cast<std::size_t>(expected));
  }
  EXPECT_EQ(announced, largest);
  EXPECT_EQ(std::count(owners.begin(), owners.end(), 1), std::ssize(owners));
  EXPECT_EQ(homes.size(), shape.triangle.size());
  for (const auto& [ids, count] : homes) EXPECT_EQ(count, 1);
}

TEST_P(DomainLevelTest, SaysWhereAFaceIsAtHome) {
  const Shape shape = test::bumpy(test::torus(20, 12), 0.05, 0.01, 4);
  const std::vector<Vec3f> positions = test::float_positions(shape);
  std::vector<Vec3f> sample = positions;
  DomainLevel domain(level(), SpaceCut(sample, segments(), level()), directory(), 1 << 16, budget_);
  const auto routed = [&](LocalIndex v) {
    return RoutedVertex{v, positions[v], domain.cut().segment_of(positions[v])};
  };
  for (LocalIndex v = 0; v < positions.size(); ++v) domain.add_vertex(routed(v), {});
  std::vector<FaceLink> link;
  for (const LocalTriangle& t : shape.triangle) {
    link.push_back(domain.add_face({routed(t[0]), routed(t[1]), routed(t[2])}, {}));
  }
  VertexIndex scratch;
  std::vector<Segment> loaded(segments());
  std::vector<FaceLink> origin;
  for (std::size_t i = 0; i < segments(); ++i) domain.load(i, scratch, loaded[i], origin);
  const Segment whole = test::whole_segment(shape);
  for (std::size_t f = 0; f < link.size(); ++f) {
    const Segment& s = loaded[link[f].segment];
    ASSERT_LT(link[f].face, s.home_faces);
    EXPECT_EQ(canonical(s, s.triangle[link[f].face]), canonical(whole, shape.triangle[f]));
  }
}

INSTANTIATE_TEST_SUITE_P(Cuts, DomainLevelTest,
                         testing::Values(std::pair{1u, 0u}, std::pair{2u, 0u}, std::pair{17u, 0u},
                                         std::pair{1u, 3u}, std::pair{2u, 1u}, std::pair{17u, 2u}),
                         [](const auto& test) {
                           return std::to_string(test.param.first) + "SegmentsLevel" +
                                  std::to_string(test.param.second);
                         });

class DomainLevelFiles : public test::TempFiles {};

TEST_F(DomainLevelFiles, FreesTheDiskWhenASegmentIsLoadedAndAtTheEnd) {
  MemoryBudget budget(std::uint64_t{64} << 20);
  {
    const auto domain = test::cut_shape(test::icosphere(4), 3, 0, directory(), budget);
    EXPECT_EQ(entries_in(directory()), 2u);
    VertexIndex scratch;
    Segment s;
    std::vector<FaceLink> origin;
    domain->load(1, scratch, s, origin);
    EXPECT_GT(s.own_vertices, 0u);
    domain->load(1, scratch, s, origin);
    EXPECT_EQ(s.own_vertices, 0u);
  }
  EXPECT_EQ(entries_in(directory()), 0u);
  EXPECT_EQ(budget.available(), budget.total());
}

TEST_F(DomainLevelFiles, TakesIdsOf39BitsAndRefusesLargerOnes) {
  MemoryBudget budget(std::uint64_t{64} << 20);
  DomainLevel domain(0, SpaceCut(), directory(), 1 << 16, budget);
  const VertexId last = (VertexId{1} << 39) - 1;
  const std::array<RoutedVertex, 3> corner{RoutedVertex{last, {0, 0, 0}, 0},
                                           RoutedVertex{last - 1, {1, 0, 0}, 0},
                                           RoutedVertex{0, {0, 1, 0}, 0}};
  for (const RoutedVertex& v : corner) domain.add_vertex(v, {});
  domain.add_face(corner, {last, 0, {}});
  EXPECT_THROW(domain.add_vertex({last + 1, {}, 0}, {}), GeometryError);
  EXPECT_THROW(domain.add_face(corner, {last + 1, 0, {}}), GeometryError);
  VertexIndex scratch;
  Segment s;
  std::vector<FaceLink> origin;
  domain.load(0, scratch, s, origin);
  EXPECT_EQ(s.vertex_id, (std::vector<VertexId>{last, last - 1, 0}));
  EXPECT_EQ(s.face_id, (std::vector<FaceId>{last}));
}

TEST_F(DomainLevelFiles, TakesAFewBytesARecordOfACoherentMesh) {
  MemoryBudget budget(std::uint64_t{64} << 20);
  DomainLevel domain(0, SpaceCut(), directory(), 1 << 16, budget);
  constexpr VertexId kWidth = 500;
  const std::uint64_t before = store::disk_usage().now;
  for (VertexId v = 0; v < kWidth * kWidth; ++v) domain.add_vertex({v, {}, 0}, {});
  const std::uint64_t vertices = store::disk_usage().now - before;
  FaceId f = 0;
  for (VertexId v = 0; v + kWidth + 1 < kWidth * kWidth; ++v) {
    const auto corner = [](VertexId id) { return RoutedVertex{id, {}, 0}; };
    domain.add_face({corner(v), corner(v + 1), corner(v + kWidth)}, {f++, 0, {}});
    domain.add_face({corner(v + 1), corner(v + kWidth + 1), corner(v + kWidth)}, {f++, 0, {}});
  }
  const std::uint64_t faces = store::disk_usage().now - before - vertices;
  EXPECT_LT(double(vertices), 13.1 * kWidth * kWidth);
  EXPECT_LT(double(faces), 7.1 * double(f));
}

TEST(VertexIndex, TakesATableWhereIdsAreDense) {
  VertexIndex index;
  for (const VertexId low : {VertexId{0}, VertexId{1} << 38}) {
    index.reset(100, low, low + 999);
    for (VertexId id = low; id < low + 1000; id += 3) {
      ASSERT_EQ(index[id], kNoIndex);
      index[id] = static_cast<LocalIndex>(id - low);
    }
    for (VertexId id = low; id < low + 1000; id += 3)
      ASSERT_EQ(index[id], static_cast<LocalIndex>(id - low));
  }
}

TEST(VertexIndex, FindsEveryIdAgain) {
  VertexIndex index;
  for (const std::size_t n : {0u, 1u, 100u, 5000u}) {
    index.reset(n);
    const auto id = [](std::size_t i) { return VertexId{i} * i * 7919 % (VertexId{1} << 39); };
    std::map<VertexId, LocalIndex> model;
    for (std::size_t i = 0; i < n; ++i) {
      LocalIndex& slot = index[id(i)];
      if (!model.contains(id(i))) {
        ASSERT_EQ(slot, kNoIndex);
        slot = static_cast<LocalIndex>(i);
        model[id(i)] = static_cast<LocalIndex>(i);
      }
    }
    for (const auto& [key, value] : model) ASSERT_EQ(index[key], value);
  }
}

}  // namespace
}  // namespace remaps
