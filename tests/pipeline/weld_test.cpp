#include "remaps/pipeline/weld.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "pipeline/welded_lists.h"
#include "remaps/base/errors.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::equal_roots;
using test::expected_of;
using test::MeshLists;
using test::soup_of;

/// A mesh in memory as if it came from a file.
class ListReader final : public IndexedMeshReader {
 public:
  ListReader(const MeshLists& mesh, bool is_float, VertexSharing sharing)
      : mesh_(mesh), is_float_(is_float), sharing_(sharing) {}

  void read_positions(PositionSink sink) override { send(std::span(mesh_.position), sink); }
  void read_triangles(IndexSink sink) override { send(std::span(mesh_.triangle), sink); }
  bool positions_are_float() const override { return is_float_; }
  VertexSharing vertex_sharing() const override { return sharing_; }
  double pass_fraction() const override { return fraction_; }
  std::uint64_t bytes_total() const override { return 7; }
  std::uint64_t bytes_read() const override { return 7; }
  std::uint64_t bytes_read_total() const override { return 7; }

 private:
  template <class T, class Sink>
  void send(std::span<const T> all, Sink sink) {
    for (std::size_t at = 0; at < all.size(); at += 1000) {
      fraction_ = double(at) / double(all.size());
      sink(all.subspan(at, std::min<std::size_t>(1000, all.size() - at)));
    }
    fraction_ = 1;
  }

  const MeshLists& mesh_;
  bool is_float_;
  VertexSharing sharing_;
  double fraction_ = 0;
};

std::vector<VertexId> near_roots(const MeshLists& mesh, double distance) {
  std::vector<VertexId> root;
  for (VertexId v = 0; v < mesh.position.size(); ++v) {
    VertexId to = 0;
    while (norm2(mesh.position[to] - mesh.position[v]) > distance * distance) ++to;
    root.push_back(to == v ? v : root[to]);
  }
  return root;
}

class Weld : public test::TempFiles {
 protected:
  MeshLists weld(const MeshLists& mesh, double distance, std::uint64_t memory_bytes, bool is_float,
                 VertexSharing sharing = VertexSharing::split) {
    ListReader reader(mesh, is_float, sharing);
    MeshLists result;
    {
      Progress progress;
      const auto welded =
          weld_vertices(reader, {distance, directory(), memory_bytes}, budget_, progress);
      EXPECT_EQ(welded->positions_are_float(), is_float);
      EXPECT_EQ(welded->position_array().has_value(), is_float);
      EXPECT_EQ(welded->vertex_sharing(), VertexSharing::shared);
      for (int pass = 0; pass < 2; ++pass) {
        result = {};
        welded->read_triangles([&](std::span<const Triangle> chunk) {
          result.triangle.insert(result.triangle.end(), chunk.begin(), chunk.end());
        });
        welded->read_positions([&](std::span<const Vec3> chunk) {
          result.position.insert(result.position.end(), chunk.begin(), chunk.end());
        });
      }
      EXPECT_EQ(welded->welded_vertices(), mesh.position.size() - result.position.size());
      EXPECT_EQ(budget_.available(), budget_.total()) << "memory is given back";
    }
    EXPECT_EQ(entries_in(directory()), 0U) << "files go with the mesh";
    return result;
  }

  static void expect_same(const MeshLists& a, const MeshLists& b) {
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.triangle, b.triangle);
  }

  MemoryBudget budget_{std::uint64_t{64} << 20};
};

constexpr std::uint64_t kTiny = std::uint64_t{64} << 10;
constexpr std::uint64_t kAmple = std::uint64_t{32} << 20;

TEST_F(Weld, UndoesSoups) {
  for (const bool shuffled : {false, true}) {
    const MeshLists soup = soup_of(test::scan(BaseShape::kTorus, 20'000, shuffled));
    const MeshLists expected = expected_of(soup, equal_roots(soup));
    EXPECT_LT(expected.position.size(), soup.position.size() / 5);
    for (const std::uint64_t memory : {kTiny, 16 * kTiny, kAmple}) {
      for (const bool is_float : {true, false}) {
        expect_same(weld(soup, 0, memory, is_float, VertexSharing::none), expected);
        expect_same(weld(soup, 0, memory, is_float, VertexSharing::split), expected);
      }
    }
  }
}

/// Vertices at few places, in any order, with faces of any vertices.
TEST_F(Weld, JoinsManyVerticesAtOnePlace) {
  std::mt19937_64 random(5);
  for (const std::uint64_t places : {1u, 3u, 1000u, 1'000'000u}) {
    for (const std::size_t vertices : {1u, 1023u, 1024u, 1025u, 40'000u}) {
      MeshLists mesh;
      for (std::size_t v = 0; v < vertices; ++v)
        mesh.position.push_back({double(random() % places), 0.5, -1});
      for (std::size_t f = 0; f < vertices; ++f)
        mesh.triangle.push_back({random() % vertices, random() % vertices, f});
      const MeshLists expected = expected_of(mesh, equal_roots(mesh));
      for (const std::uint64_t memory : {kTiny, kAmple})
        expect_same(weld(mesh, 0, memory, true), expected);
    }
  }
}

TEST_F(Weld, TellsPositionsApartExactlyButForTheSignOfZero) {
  const double tiny = std::nextafter(1.0, 2.0);
  const MeshLists mesh{{{0, 0, 1}, {-0.0, 0, 1}, {0, -0.0, 1}, {0, 0, tiny}, {0, 0, 1}},
                       {{0, 1, 2}, {2, 3, 4}}};
  const MeshLists welded = weld(mesh, 0, kTiny, false);
  EXPECT_EQ(welded.position, (std::vector<Vec3>{{0, 0, 1}, {0, 0, tiny}}));
  EXPECT_EQ(welded.triangle, (std::vector<Triangle>{{0, 0, 0}, {0, 1, 0}}));
}

TEST_F(Weld, PassesOnWhatHasNothing) {
  for (const double distance : {0.0, 1.0}) {
    expect_same(weld({}, distance, kTiny, true), {});
    expect_same(weld({{{1, 2, 3}}, {}}, distance, kTiny, true), {{{1, 2, 3}}, {}});
  }
}

TEST_F(Weld, JoinsNearVerticesByDefinition) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double distance : {1e-9, 0.01, 0.05, 0.3, 1.0, 10.0, 1e30}) {
    MeshLists mesh;
    for (int v = 0; v < 3000; ++v)
      mesh.position.push_back(widen(to_float({unit(random), unit(random), 0.1 * unit(random)})));
    // On the cells' faces, and exactly a distance apart.
    for (int v = 0; v < 300; ++v)
      mesh.position.push_back(widen(to_float({double(v % 17 - 8) * distance, distance, 0})));
    for (VertexId v = 2; v < mesh.position.size(); ++v) mesh.triangle.push_back({v - 2, v - 1, v});
    const MeshLists expected = expected_of(mesh, near_roots(mesh, distance));
    for (const std::uint64_t memory : {kTiny, kAmple}) {
      for (const bool is_float : {true, false})
        expect_same(weld(mesh, distance, memory, is_float), expected);
    }
  }
}

TEST_F(Weld, JoinsNoVertexThatIsNotFinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  MeshLists mesh = soup_of(test::scan(BaseShape::kTorus, 3'000));
  const std::size_t finite = expected_of(mesh, equal_roots(mesh)).position.size();
  std::vector<VertexId> wild;
  for (VertexId v = 1; v < mesh.position.size(); v += 97) {
    // Each place of the torus has several vertices: one of them stays.
    mesh.position[v] = v % 2 == 0 ? Vec3{std::nan(""), 0, 0} : Vec3{0, infinity, -infinity};
    wild.push_back(v);
  }
  for (const double distance : {0.0, 1e-9}) {
    for (const std::uint64_t memory : {kTiny, kAmple}) {
      for (const bool is_float : {true, false}) {
        const MeshLists welded = weld(mesh, distance, memory, is_float);
        ASSERT_EQ(welded.triangle.size(), mesh.triangle.size());
        EXPECT_EQ(welded.position.size(), finite + wild.size());
        std::size_t found = 0;
        for (const Vec3& p : welded.position) found += !std::isfinite(p.x + p.y + p.z);
        EXPECT_EQ(found, wild.size());
        for (const VertexId v : wild) {
          const Vec3& p = welded.position[welded.triangle[v / 3][v % 3]];
          EXPECT_FALSE(std::isfinite(p.x + p.y + p.z));
        }
      }
    }
  }
}

TEST_F(Weld, MendsASoupWithNoise) {
  const MeshLists mesh = test::scan(BaseShape::kIcosahedron, 5'000);
  MeshLists soup = soup_of(mesh);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
  for (Vec3& p : soup.position) p = p + Vec3{noise(random), noise(random), noise(random)};
  const MeshLists welded = weld(soup, 1e-5, kTiny, false);
  EXPECT_EQ(welded.position.size(), mesh.position.size());
  EXPECT_EQ(welded.triangle.size(), mesh.triangle.size());
}

TEST_F(Weld, RefusesADistanceThatGathersTheMeshInOnePlace) {
  MeshLists mesh;
  for (int v = 0; v < 200'000; ++v) mesh.position.push_back({double(v), 0, 0});
  ListReader reader(mesh, true, VertexSharing::shared);
  MemoryBudget budget(std::uint64_t{8} << 20);
  Progress progress;
  EXPECT_THROW(weld_vertices(reader, {1e9, directory(), std::uint64_t{4} << 20}, budget, progress),
               BudgetError);
  EXPECT_EQ(budget.available(), budget.total());
  EXPECT_EQ(entries_in(directory()), 0U);
}

TEST_F(Weld, CanBeCancelled) {
  const MeshLists soup = soup_of(test::scan(BaseShape::kTorus, 2'000));
  ListReader reader(soup, true, VertexSharing::none);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(weld_vertices(reader, {0, directory(), kTiny}, budget_, progress), Cancelled);
  EXPECT_EQ(entries_in(directory()), 0U);
}

}  // namespace
}  // namespace remaps::pipeline
