#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "remaps/pipeline/repair_input.h"
#include "support/surface_check.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

/// Triangles among few vertices: nearly every edge has many faces.
struct Soup {
  std::vector<Vec3f> position;
  std::vector<Triangle> triangle;
};

Soup random_soup(std::uint64_t seed, std::size_t vertices, std::size_t faces) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> place(0, 1);
  Soup soup;
  for (std::size_t v = 0; v < vertices; ++v)
    soup.position.push_back({place(random), place(random), place(random)});
  while (soup.triangle.size() < faces) {
    const Triangle t{random() % vertices, random() % vertices, random() % vertices};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) soup.triangle.push_back(t);
  }
  return soup;
}

/// Boxes of a grid with outward faces, some of which touch along edges and at corners.
Soup random_boxes(std::uint64_t seed, std::size_t boxes) {
  std::mt19937_64 random(seed);
  Soup soup;
  std::map<std::array<int, 3>, VertexId> number;
  std::set<std::array<int, 3>> taken;
  const auto vertex = [&](std::array<int, 3> at) {
    const auto [found, is_new] = number.emplace(at, soup.position.size());
    if (is_new) soup.position.push_back({float(at[0]), float(at[1]), float(at[2])});
    return found->second;
  };
  while (taken.size() < boxes)
    taken.insert({int(random() % 4), int(random() % 4), int(random() % 4)});
  for (const auto& box : taken) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        std::array<int, 3> beyond = box;
        beyond[axis] += 2 * side - 1;
        if (taken.contains(beyond)) continue;
        std::array<VertexId, 4> corner{};
        for (std::size_t i = 0; i < 4; ++i) {
          std::array<int, 3> at = box;
          at[axis] += side;
          at[(axis + 1) % 3] += i == 1 || i == 2;
          at[(axis + 2) % 3] += i > 1;
          corner[i] = vertex(at);
        }
        if (side == 0) std::swap(corner[1], corner[3]);
        soup.triangle.push_back({corner[0], corner[1], corner[2]});
        soup.triangle.push_back({corner[0], corner[2], corner[3]});
      }
    }
  }
  return soup;
}

class RepairSoup : public test::TempFiles {
 protected:
  struct Result {
    bool one_sided = false;
    Repairs repairs;
    std::vector<std::pair<FaceId, Triangle>> face;  // by number
    std::map<VertexId, Vec3f> position;
  };

  Result repair(const Soup& soup, std::size_t segments, unsigned threads) {
    const std::filesystem::path work = directory() / "work";
    std::filesystem::remove_all(work);
    std::filesystem::create_directory(work);
    std::vector<Vec3f> sample = soup.position;
    const SpaceCut cut(sample, segments, 0);
    Ingested ingested;
    ingested.vertices = soup.position.size();
    ingested.faces = soup.triangle.size();
    ingested.level = std::make_unique<DomainLevel>(0, cut, work, 1 << 16, budget_);
    const auto routed = [&](VertexId v) {
      return RoutedVertex{v, soup.position[v], cut.segment_of(soup.position[v])};
    };
    for (VertexId v = 0; v < soup.position.size(); ++v) ingested.level->add_vertex(routed(v), {});
    for (FaceId f = 0; f < soup.triangle.size(); ++f) {
      const Triangle& t = soup.triangle[f];
      ingested.level->add_face({routed(t[0]), routed(t[1]), routed(t[2])}, {f, 0, {}});
    }
    MemoryPlan plan;
    plan.bucket_bytes = 1 << 16;
    plan.sweep_threads = threads;
    Progress progress;
    Result result;
    result.one_sided = !repair_input(ingested, {}, plan, work, budget_, progress, result.repairs)
                            .one_sided.empty();
    collect(*ingested.level, result);
    return result;
  }

  static void collect(DomainLevel& level, Result& result) {
    VertexIndex index;
    Segment s;
    std::vector<FaceLink> origin;
    Patch patch;
    for (std::size_t i = 0; i < level.segments(); ++i) {
      level.load(i, index, s, origin);
      if (!result.one_sided) {
        EXPECT_EQ(patch.build(s.vertex_id.size(), s.own_vertices, s.triangle).kind,
                  ManifoldDefect::Kind::kNone);
      }
      for (LocalIndex f = 0; f < s.home_faces; ++f) {
        const LocalTriangle& t = s.triangle[f];
        result.face.emplace_back(s.face_id[f],
                                 Triangle{s.vertex_id[t[0]], s.vertex_id[t[1]], s.vertex_id[t[2]]});
        for (const LocalIndex v : t) {
          const auto [found, is_new] = result.position.emplace(s.vertex_id[v], s.position[v]);
          EXPECT_EQ(found->second, s.position[v]) << "one vertex at two places";
        }
      }
    }
    std::sort(result.face.begin(), result.face.end());
  }

  /// A manifold of the same triangles in space, each once; the same for any cut and threads.
  Result expect_sound(const Soup& soup) {
    const Result whole = repair(soup, 1, 1);
    for (const std::size_t segments : {1u, 2u, 5u, 16u}) {
      for (const unsigned threads : {1u, 3u}) {
        SCOPED_TRACE(std::to_string(segments) + " segments, " + std::to_string(threads));
        const Result result = repair(soup, segments, threads);
        EXPECT_EQ(result.one_sided, whole.one_sided);
        if (result.one_sided) continue;
        std::vector<Triangle> faces;
        for (const auto& [number, t] : result.face) faces.push_back(t);
        const test::CountedSurface counted = test::count_surface(faces);
        EXPECT_EQ(counted.defect, "");
        expect_same_places(soup, result);
        EXPECT_EQ(result.repairs.nonmanifold_edges, whole.repairs.nonmanifold_edges);
        EXPECT_EQ(result.repairs.duplicate_faces, whole.repairs.duplicate_faces);
        EXPECT_EQ(result.repairs.split_vertices, whole.repairs.split_vertices);
        EXPECT_EQ(result.face.size() + result.repairs.duplicate_faces, soup.triangle.size());
      }
    }
    return whole;
  }

  static void expect_same_places(const Soup& soup, const Result& result) {
    for (const auto& [number, t] : result.face) {
      std::set<std::array<float, 3>> before, after;
      for (const VertexId v : soup.triangle[number])
        before.insert({soup.position[v].x, soup.position[v].y, soup.position[v].z});
      for (const VertexId v : t) {
        const Vec3f& p = result.position.at(v);
        after.insert({p.x, p.y, p.z});
      }
      ASSERT_EQ(before, after) << "face " << number;
    }
  }

  MemoryBudget budget_{std::uint64_t{64} << 20};
};

TEST_F(RepairSoup, MakesAManifoldOfAnythingThatCanBeOriented) {
  std::size_t done = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Result result = expect_sound(random_soup(seed, 12 + seed % 30, 10 + 3 * seed));
    done += !result.one_sided;
  }
  EXPECT_GT(done, 20u) << "the test tests little";
}

TEST_F(RepairSoup, KeepsSolidsClosedThatTouch) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Result result = expect_sound(random_boxes(seed, 8 + seed));
    EXPECT_FALSE(result.one_sided);
    EXPECT_EQ(result.repairs.flipped_faces, 0u);
    std::vector<Triangle> faces;
    for (const auto& [number, t] : result.face) faces.push_back(t);
    EXPECT_EQ(test::count_surface(faces).topology.boundary_edges, 0u);
  }
}

}  // namespace
}  // namespace remaps::pipeline
