#include "remaps/codec/subdivision_recovery.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "codec/codec_shapes.h"
#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::codec {
namespace {

class SubdivisionRecoveryFiles : public test::TempFiles {};

constexpr std::uint64_t kMemory = 256u << 20;

struct Mesh {
  std::uint32_t vertices = 0;
  std::vector<Face> face;
};

Mesh subdivided(const test::CodecBase& base, unsigned levels) {
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(base.vertices(), base.face, levels, budget);
  return {hierarchy.vertices(), test::finest_faces(hierarchy)};
}

/// Vertices and faces in any order, and any corner first.
Mesh shuffled(const Mesh& mesh, std::mt19937_64& random) {
  Mesh result = mesh;
  std::vector<std::uint32_t> number(mesh.vertices);
  std::iota(number.begin(), number.end(), 0);
  std::shuffle(number.begin(), number.end(), random);
  for (Face& face : result.face) {
    for (std::uint32_t& v : face) v = number[v];
    std::rotate(face.begin(), face.begin() + random() % 3, face.end());
  }
  std::shuffle(result.face.begin(), result.face.end(), random);
  return result;
}

SemiRegularConnectivity recover(const Mesh& mesh, unsigned least, unsigned most = 14) {
  MemoryBudget budget(kMemory);
  return recover_subdivision(mesh.vertices, mesh.face, least, most, budget);
}

std::string refusal(const Mesh& mesh, unsigned least = 1, unsigned most = 14) {
  try {
    recover(mesh, least, most);
  } catch (const GeometryError& error) {
    return error.what();
  }
  return "";
}

Face smallest_first(Face face) {
  std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return face;
}

/// The hierarchy of what was recovered, in the numbers of the given mesh, has its faces.
void expect_same_mesh(const SemiRegularConnectivity& found, const Mesh& mesh) {
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(found.base_vertices, found.base, found.levels, budget);
  ASSERT_EQ(found.vertex.size(), mesh.vertices);
  ASSERT_EQ(hierarchy.vertices(), mesh.vertices);
  EXPECT_EQ(std::set<std::uint32_t>(found.vertex.begin(), found.vertex.end()).size(),
            mesh.vertices);
  std::set<Face> given, rebuilt;
  for (const Face& face : mesh.face) given.insert(smallest_first(face));
  for (std::uint64_t f = 0; f < hierarchy.faces(); ++f) {
    const Face face = hierarchy.finest_face(f);
    rebuilt.insert(
        smallest_first({found.vertex[face[0]], found.vertex[face[1]], found.vertex[face[2]]}));
  }
  EXPECT_EQ(rebuilt, given);
}

std::map<std::uint32_t, int> valences(std::span<const Face> faces) {
  std::map<std::uint32_t, int> of_vertex, number;
  for (const Face& face : faces) {
    for (const std::uint32_t v : face) ++of_vertex[v];
  }
  for (const auto& [v, n] : of_vertex) ++number[static_cast<std::uint32_t>(n)];
  return number;
}

TEST(SubdivisionRecovery, FindsTheBaseOfShuffledMeshes) {
  std::mt19937_64 random(1);
  for (const test::CodecBase& base : test::codec_bases()) {
    for (const unsigned levels : {1u, 2u, 3u, 5u}) {
      SCOPED_TRACE(base.name + ", level " + std::to_string(levels));
      const Mesh mesh = shuffled(subdivided(base, levels), random);
      const bool ends_there = !refusal({base.vertices(), base.face}).empty();
      const SemiRegularConnectivity found = recover(mesh, 1, ends_there ? 14 : levels);
      EXPECT_EQ(found.levels, levels);
      EXPECT_EQ(found.base_vertices, base.vertices());
      EXPECT_EQ(found.base.size(), base.face.size());
      EXPECT_EQ(valences(found.base), valences(base.face));
      expect_same_mesh(found, mesh);
    }
  }
}

TEST(SubdivisionRecovery, StopsAtTheMostLevels) {
  std::mt19937_64 random(2);
  for (const test::CodecBase& base : test::codec_bases()) {
    SCOPED_TRACE(base.name);
    const Mesh mesh = shuffled(subdivided(base, 3), random);
    for (const unsigned most : {0u, 1u, 2u}) {
      const SemiRegularConnectivity found = recover(mesh, most, most);
      EXPECT_EQ(found.levels, most);
      EXPECT_EQ(found.base.size(), base.face.size() << (2 * (3 - most)));
      expect_same_mesh(found, mesh);
    }
  }
}

TEST(SubdivisionRecovery, IsStable) {
  std::mt19937_64 random(3);
  std::vector<test::CodecBase> bases = test::codec_bases();
  bases.push_back(test::base_of(test::torus(4, 8)));
  bases.push_back(test::base_of(test::torus(12, 6)));
  for (const test::CodecBase& base : bases) {
    SCOPED_TRACE(base.name);
    const SemiRegularConnectivity once = recover(shuffled(subdivided(base, 2), random), 2);
    MemoryBudget budget(kMemory);
    const SubdivisionHierarchy hierarchy(once.base_vertices, once.base, once.levels, budget);
    const SemiRegularConnectivity twice =
        recover({hierarchy.vertices(), test::finest_faces(hierarchy)}, 2);
    EXPECT_EQ(twice.levels, once.levels);
    EXPECT_EQ(twice.base, once.base);
    for (std::uint32_t v = 0; v < hierarchy.vertices(); ++v) ASSERT_EQ(twice.vertex[v], v);
  }
}

TEST(SubdivisionRecovery, GoesAsDeepAsARegularTorusAllows) {
  // All four parts of the first face fit at every level: 24 x 40 down to 3 x 5.
  std::mt19937_64 random(4);
  const test::CodecBase torus = test::base_of(test::torus(24, 40));
  const Mesh mesh = shuffled({torus.vertices(), torus.face}, random);
  const SemiRegularConnectivity found = recover(mesh, 1);
  EXPECT_EQ(found.levels, 3u);
  EXPECT_EQ(found.base_vertices, 15u);
  expect_same_mesh(found, mesh);
  // 32 x 32: 4 x 4 is the last without double edges.
  const test::CodecBase square = test::base_of(test::torus(32, 32));
  EXPECT_EQ(recover({square.vertices(), square.face}, 1).base_vertices, 16u);
}

TEST(SubdivisionRecovery, GivesAllComponentsTheSameLevels) {
  std::mt19937_64 random(5);
  const test::CodecBase one = test::base_of(test::octahedron());
  const Mesh coarse = subdivided(one, 2), fine = subdivided(one, 4);
  Mesh both = coarse;
  for (Face face : fine.face) {
    for (std::uint32_t& v : face) v += coarse.vertices;
    both.face.push_back(face);
  }
  both.vertices += fine.vertices;
  both = shuffled(both, random);
  const SemiRegularConnectivity found = recover(both, 1);
  EXPECT_EQ(found.levels, 2u);
  EXPECT_EQ(found.base.size(), 8u + 8 * 16);
  expect_same_mesh(found, both);
  EXPECT_NE(refusal(both, 3).find("of 2 levels only"), std::string::npos) << refusal(both, 3);
}

TEST(SubdivisionRecovery, KeepsNeighboursTogether) {
  std::mt19937_64 random(6);
  const Mesh mesh =
      shuffled(subdivided(test::base_of(test::bumpy(test::icosphere(3), 3, 0, 1)), 1), random);
  const SemiRegularConnectivity found = recover(mesh, 1, 1);
  std::size_t together = 0;
  for (std::size_t f = 1; f < found.base.size(); ++f) {
    const Face &a = found.base[f - 1], &b = found.base[f];
    std::size_t common = 0;
    for (const std::uint32_t v : b) common += std::find(a.begin(), a.end(), v) != a.end() ? 1u : 0u;
    together += common == 2 ? 1u : 0u;
  }
  EXPECT_GT(together, found.base.size() * 9 / 10);
}

TEST(SubdivisionRecovery, RefusesAFlippedEdge) {
  std::mt19937_64 random(7);
  std::size_t tried = 0;
  for (const test::CodecBase& base : test::codec_bases()) {
    const Mesh mesh = subdivided(base, 2);
    for (unsigned i = 0; i < 20; ++i) {
      Mesh broken = mesh;
      Face& a = broken.face[random() % broken.face.size()];
      Face* b = nullptr;
      for (Face& face : broken.face) {
        for (unsigned k = 0; k < 3; ++k) {
          if (face[k] != a[1] || face[(k + 1) % 3] != a[0]) continue;
          b = &face;
          std::rotate(face.begin(), face.begin() + k, face.end());
        }
      }
      if (b == nullptr) continue;
      const std::uint32_t left = a[2], right = (*b)[2];
      const bool joined = std::any_of(broken.face.begin(), broken.face.end(), [&](const Face& f) {
        return std::count(f.begin(), f.end(), left) + std::count(f.begin(), f.end(), right) == 2;
      });
      if (joined) continue;
      *b = {left, right, a[1]};
      a = {right, left, a[0]};
      ++tried;
      const std::string why = refusal(shuffled(broken, random));
      EXPECT_NE(why.find("no subdivision connectivity"), std::string::npos) << base.name << why;
    }
  }
  EXPECT_GT(tried, 200u);
}

TEST(SubdivisionRecovery, RefusesRemovedFaces) {
  std::mt19937_64 random(8);
  for (const test::CodecBase& base : test::codec_bases()) {
    const Mesh mesh = subdivided(base, 2);
    for (const unsigned removed : {1u, 4u}) {
      Mesh broken = shuffled(mesh, random);
      broken.face.resize(broken.face.size() - removed);
      EXPECT_NE(refusal(broken), "") << base.name;
    }
  }
}

TEST(SubdivisionRecovery, RefusesOtherMeshes) {
  for (const test::Shape& shape : test::all_shapes()) {
    const test::CodecBase base = test::base_of(shape);
    const std::string why = refusal({base.vertices(), base.face}, 3);
    EXPECT_NE(why.find("subdivision connectivity"), std::string::npos) << shape.name << why;
  }
}

TEST(SubdivisionRecovery, SaysWhatDoesNotFit) {
  const test::CodecBase base = test::base_of(test::octahedron());
  const Mesh mesh = subdivided(base, 1);
  const auto with = [&](auto&& change) {
    Mesh changed = mesh;
    change(changed);
    return refusal(changed);
  };
  const auto expect_part = [](const std::string& why, const std::string& part) {
    EXPECT_NE(why.find(part), std::string::npos) << why;
  };
  expect_part(with([](Mesh& m) { m.face[3][1] = 99; }), "face 3 does not have three different");
  expect_part(with([](Mesh& m) { m.face[3][1] = m.face[3][0]; }), "face 3 does not have three");
  expect_part(with([](Mesh& m) { std::swap(m.face[5][0], m.face[5][1]); }), "same direction");
  expect_part(with([](Mesh& m) { m.face.push_back(m.face[0]); }), "same direction");
  expect_part(with([](Mesh& m) { ++m.vertices; }), "vertex 18 has no face");
  expect_part(with([](Mesh& m) { m.vertices = 4'000'000'000; }), "vertices without a face");
  expect_part(with([](Mesh& m) { m = {0, {}}; }), "is empty");
  expect_part(with([](Mesh& m) { m.face.pop_back(); }), "its 31 faces are not a multiple of 4");
  expect_part(refusal({base.vertices(), base.face}), "its 8 faces cannot be joined by fours");
  // Two fans that touch.
  expect_part(refusal({5, {{0, 1, 2}, {0, 3, 4}}}), "vertex 0 are not one fan");
  EXPECT_THROW(recover(mesh, 3, 2), std::invalid_argument);
  MemoryBudget small(1000);
  EXPECT_THROW(recover_subdivision(mesh.vertices, mesh.face, 1, 14, small), BudgetError);
  EXPECT_EQ(small.available(), small.total());
}

TEST(SubdivisionRecovery, SurvivesRandomFaces) {
  std::mt19937_64 random(9);
  for (unsigned i = 0; i < 3000; ++i) {
    Mesh mesh{static_cast<std::uint32_t>(3 + random() % 8), {}};
    for (std::size_t f = 4 * (1 + random() % 4); f > 0; --f) {
      Face face;
      for (std::uint32_t& v : face) v = static_cast<std::uint32_t>(random() % mesh.vertices);
      mesh.face.push_back(face);
    }
    EXPECT_NE(refusal(mesh), "") << "round " << i;
  }
}

TEST_F(SubdivisionRecoveryFiles, FindsTheBaseOfARemeshedScan) {
  pipeline::RemeshOptions options =
      test::remesh_options(directory(), REMAPS_TEST_DATA "/../../data/koala.ply");
  options.level = 4;
  Progress progress;
  pipeline::remesh(options, progress);
  const test::MeshLists base = test::read_lists(options.bundle / "base.ply");
  const test::MeshLists lists = test::read_lists(options.output);
  Mesh mesh{static_cast<std::uint32_t>(lists.position.size()), {}};
  for (const Triangle& t : lists.triangle) {
    mesh.face.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
                         static_cast<std::uint32_t>(t[2])});
  }
  std::mt19937_64 random(10);
  for (const Mesh& given : {mesh, shuffled(mesh, random)}) {
    const SemiRegularConnectivity found = recover(given, 1);
    EXPECT_EQ(found.levels, 4u);
    EXPECT_EQ(found.base.size(), base.triangle.size());
    EXPECT_EQ(found.base_vertices, base.position.size());
    expect_same_mesh(found, given);
  }
}

}  // namespace
}  // namespace remaps::codec
