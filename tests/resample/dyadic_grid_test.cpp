#include "remaps/resample/dyadic_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "support/shapes.h"
#include "support/surface_check.h"

namespace remaps::resample {
namespace {

using test::Shape;

DyadicGrid grid_of(const Shape& shape, unsigned level) {
  return {static_cast<std::uint32_t>(shape.position.size()), shape.triangle, level};
}

std::vector<Triangle> faces_of(const DyadicGrid& grid) {
  std::vector<Triangle> faces;
  for (std::uint64_t f = 0; f < grid.faces(); ++f) faces.push_back(grid.triangle(f));
  return faces;
}

std::vector<map::TaggedPoint> samples_of(const DyadicGrid& grid) {
  std::vector<map::TaggedPoint> samples(grid.vertices());
  grid.samples(0, samples);
  return samples;
}

/// Where each vertex lies on the flat base faces; fails unless each number comes once.
std::vector<Vec3> positions_of(const DyadicGrid& grid, const Shape& shape) {
  std::vector<Vec3> position(grid.vertices());
  std::vector<int> seen(grid.vertices(), 0);
  for (const auto& [number, at] : samples_of(grid)) {
    if (number >= position.size()) {
      ADD_FAILURE() << "number " << number;
      break;
    }
    ++seen[number];
    const LocalTriangle& t = shape.triangle[at.face];
    position[number] = (1 - at.u - at.v) * shape.position[t[0]] + at.u * shape.position[t[1]] +
                       at.v * shape.position[t[2]];
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ssize(seen));
  return position;
}

class DyadicGridTest : public testing::TestWithParam<unsigned> {
 protected:
  unsigned level() const { return GetParam(); }
  static std::vector<Shape> bases() {
    return {test::tetrahedron(), test::octahedron(),
            test::icosphere(0),  test::torus(4, 3),
            test::disk(1),       test::annulus(4, 1),
            test::cone(9),       test::together(test::tetrahedron(), test::disk(1))};
  }
};

TEST_P(DyadicGridTest, CountsWhatItNumbers) {
  const std::uint64_t n = std::uint64_t{1} << level();
  for (const Shape& shape : bases()) {
    const DyadicGrid grid = grid_of(shape, level());
    const std::uint64_t faces = shape.triangle.size();
    std::vector<Triangle> base;
    for (const LocalTriangle& t : shape.triangle) base.push_back({t[0], t[1], t[2]});
    const std::uint64_t boundary = test::count_surface(base).topology.boundary_edges;
    const std::uint64_t edges = (3 * faces + boundary) / 2;
    EXPECT_EQ(grid.faces(), faces * n * n) << shape.name;
    EXPECT_EQ(grid.vertices(),
              shape.position.size() + edges * (n - 1) + faces * (n - 1) * (n - 2) / 2)
        << shape.name;
    EXPECT_EQ(grid.level(), level());
  }
}

TEST_P(DyadicGridTest, IsAManifoldOfTheKindOfItsBase) {
  for (const Shape& shape : bases()) {
    SCOPED_TRACE(shape.name);
    const DyadicGrid grid = grid_of(shape, level());
    const test::CountedSurface counted = test::count_surface(faces_of(grid));
    EXPECT_EQ(counted.defect, "");
    EXPECT_EQ(counted.topology.vertices, grid.vertices());
    EXPECT_EQ(counted.topology.euler_characteristic(), shape.euler_characteristic);
    EXPECT_EQ(counted.topology.components, static_cast<std::uint64_t>(shape.components));
    EXPECT_EQ(counted.topology.boundary_loops, static_cast<std::uint64_t>(shape.boundary_loops));
  }
}

TEST_P(DyadicGridTest, NumbersTheBaseFirstThenEdgesThenFaces) {
  const std::uint64_t n = std::uint64_t{1} << level();
  for (const Shape& shape : bases()) {
    SCOPED_TRACE(shape.name);
    const DyadicGrid grid = grid_of(shape, level());
    const std::uint64_t base = shape.position.size();
    const std::uint64_t faces = shape.triangle.size();
    const std::uint64_t inner = (n - 1) * (n - 2) / 2;
    const std::uint64_t first_inner = grid.vertices() - faces * inner;
    for (std::uint32_t f = 0; f < faces; ++f) {
      for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i + j <= n; ++i) {
          const std::uint64_t number = grid.vertex(f, i, j);
          const std::uint64_t k = n - i - j;
          const int zeros = (i == 0) + (j == 0) + (k == 0);
          if (zeros == 2) {
            ASSERT_EQ(number, shape.triangle[f][k != 0 ? 0 : i != 0 ? 1 : 2]);
          } else if (zeros == 1) {
            ASSERT_GE(number, base);
            ASSERT_LT(number, first_inner);
          } else {
            ASSERT_GE(number, first_inner + f * inner);
            ASSERT_LT(number, first_inner + (f + 1) * inner);
          }
        }
      }
    }
  }
}

TEST_P(DyadicGridTest, PutsCoarsePointsOfAnEdgeOrFaceFirst) {
  const std::uint64_t n = std::uint64_t{1} << level();
  for (const Shape& shape : bases()) {
    const DyadicGrid grid = grid_of(shape, level());
    for (std::uint32_t f = 0; f < shape.triangle.size(); ++f) {
      std::vector<std::pair<std::uint64_t, int>> inner;  // number, times that it can be halved
      std::array<std::vector<std::pair<std::uint64_t, int>>, 3> edge;
      for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i + j <= n; ++i) {
          const auto k = static_cast<std::uint32_t>(n - i - j);
          const int halvings =
              std::min({std::countr_zero(i), std::countr_zero(j), std::countr_zero(k)});
          const int zeros = (i == 0) + (j == 0) + (k == 0);
          if (zeros == 0) inner.emplace_back(grid.vertex(f, i, j), halvings);
          if (zeros == 1)
            edge[i == 0 ? 0 : j == 0 ? 1 : 2].emplace_back(grid.vertex(f, i, j), halvings);
        }
      }
      for (auto* points : {&inner, &edge[0], &edge[1], &edge[2]}) {
        std::sort(points->begin(), points->end());
        for (std::size_t p = 1; p < points->size(); ++p) {
          ASSERT_EQ((*points)[p].first, (*points)[p - 1].first + 1) << shape.name;
          ASSERT_LE((*points)[p].second, (*points)[p - 1].second) << shape.name;
        }
      }
    }
  }
}

TEST_P(DyadicGridTest, SamplesEachVertexOnceWhereItIs) {
  for (const Shape& shape : bases()) {
    SCOPED_TRACE(shape.name);
    const DyadicGrid grid = grid_of(shape, level());
    const std::vector<Vec3> position = positions_of(grid, shape);
    const double n = double(1 << level());
    for (std::uint32_t f = 0; f < shape.triangle.size(); ++f) {
      const LocalTriangle& t = shape.triangle[f];
      for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i + j <= n; ++i) {
          const Vec3 expected = ((n - i - j) / n) * shape.position[t[0]] +
                                (i / n) * shape.position[t[1]] + (j / n) * shape.position[t[2]];
          ASSERT_LT(norm(position[grid.vertex(f, i, j)] - expected), 1e-12);
        }
      }
    }
  }
}

TEST_P(DyadicGridTest, OrdersChildrenByCorner) {
  if (level() == 0) return;
  for (const Shape& shape : bases()) {
    SCOPED_TRACE(shape.name);
    const DyadicGrid fine = grid_of(shape, level());
    const DyadicGrid coarse = grid_of(shape, level() - 1);
    const std::vector<Vec3> at = positions_of(fine, shape);
    const std::vector<Vec3> parent_at = positions_of(coarse, shape);
    for (std::uint64_t q = 0; q < coarse.faces(); ++q) {
      std::array<Vec3, 3> corner;
      for (std::size_t c = 0; c < 3; ++c) corner[c] = parent_at[coarse.triangle(q)[c]];
      for (std::uint64_t child = 0; child < 4; ++child) {
        const Triangle t = fine.triangle(4 * q + child);
        for (std::size_t c = 0; c < 3; ++c) {
          // Corner c of child c is the parent's; all others are middles of its edges, those of
          // child 3 opposite to the parent's corner of the same number.
          const Vec3 expected = child == 3   ? 0.5 * (corner[(c + 1) % 3] + corner[(c + 2) % 3])
                                : child == c ? corner[c]
                                             : 0.5 * (corner[c] + corner[child]);
          ASSERT_LT(norm(at[t[c]] - expected), 1e-12) << "child " << child << " corner " << c;
        }
      }
    }
  }
}

TEST_P(DyadicGridTest, KeepsTheNumbersOfFacesWithTheirBaseFace) {
  const Shape shape = test::icosphere(0);
  const DyadicGrid grid = grid_of(shape, level());
  EXPECT_EQ(grid.faces_per_base_face(), std::uint64_t{1} << (2 * level()));
  const std::uint32_t n = 1u << level();
  for (std::uint32_t f = 0; f < shape.triangle.size(); ++f) {
    std::set<std::uint64_t> own;
    for (std::uint32_t j = 0; j <= n; ++j) {
      for (std::uint32_t i = 0; i + j <= n; ++i) own.insert(grid.vertex(f, i, j));
    }
    for (std::uint64_t q = f * grid.faces_per_base_face(); q < (f + 1) * grid.faces_per_base_face();
         ++q) {
      for (const VertexId v : grid.triangle(q)) ASSERT_TRUE(own.contains(v));
    }
  }
}

TEST_P(DyadicGridTest, SamplesPointsOnTheFirstFaceThatHasThem) {
  const std::uint32_t n = 1u << level();
  for (const Shape& shape : bases()) {
    const DyadicGrid grid = grid_of(shape, level());
    std::map<std::uint64_t, map::FacePoint> expected;
    for (std::uint32_t f = 0; f < shape.triangle.size(); ++f) {
      for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i + j <= n; ++i) {
          expected.try_emplace(grid.vertex(f, i, j),
                               map::FacePoint{f, double(i) / n, double(j) / n});
        }
      }
    }
    for (const auto& [number, at] : samples_of(grid)) {
      ASSERT_EQ(at, expected.at(number)) << shape.name << ' ' << number;
    }
  }
}

TEST_P(DyadicGridTest, GivesSamplesAndFacesInPiecesOfAnySize) {
  for (const Shape& shape : bases()) {
    SCOPED_TRACE(shape.name);
    const DyadicGrid grid = grid_of(shape, level());
    const std::vector<map::TaggedPoint> samples = samples_of(grid);
    const std::vector<Triangle> faces = faces_of(grid);
    for (const std::uint64_t size : {1UL, 7UL, 255UL, 256UL, 257UL, 1000UL}) {
      std::vector<map::TaggedPoint> part;
      for (std::uint64_t first = 0; first < samples.size(); first += size) {
        part.resize(std::min(size, samples.size() - first));
        grid.samples(first, part);
        for (std::size_t i = 0; i < part.size(); ++i) {
          ASSERT_EQ(part[i].tag, samples[first + i].tag);
          ASSERT_EQ(part[i].at, samples[first + i].at);
        }
      }
      std::vector<Triangle> some;
      for (std::uint64_t first = 0; first < faces.size(); first += size) {
        some.resize(std::min(size, faces.size() - first));
        grid.triangles(first, some);
        ASSERT_TRUE(std::equal(some.begin(), some.end(), faces.begin() + std::ptrdiff_t(first)));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Levels, DyadicGridTest, testing::Range(0u, 7u));

/// 400 base faces.
Shape five_spheres() {
  Shape shape = test::icosphere(1);
  for (const Shape& more :
       {test::icosphere(1), test::icosphere(1), test::icosphere(1), test::icosphere(1)}) {
    shape = test::together(shape, more);
  }
  return shape;
}

TEST(DyadicGrid, CountsInSixtyFourBits) {
  // 1.1e11 faces at level 14, looked up here and there.
  const Shape shape = five_spheres();
  ASSERT_EQ(shape.triangle.size(), 400u);
  constexpr unsigned kLevel = 14;
  const DyadicGrid grid = grid_of(shape, kLevel);
  const std::uint64_t n = 1 << kLevel;
  EXPECT_EQ(grid.faces(), 400 * n * n);
  EXPECT_EQ(grid.vertices(), shape.position.size() + 600 * (n - 1) + 400 * (n - 1) * (n - 2) / 2);
  std::mt19937_64 random(1);
  for (int i = 0; i < 20'000; ++i) {
    const auto face = static_cast<std::uint32_t>(random() % 400);
    const auto u = static_cast<std::uint32_t>(random() % (n + 1));
    const auto v = static_cast<std::uint32_t>(random() % (n + 1 - u));
    ASSERT_LT(grid.vertex(face, u, v), grid.vertices());
    const Triangle t = grid.triangle(random() % grid.faces());
    ASSERT_NE(t[0], t[1]);
    ASSERT_NE(t[1], t[2]);
    ASSERT_NE(t[2], t[0]);
    for (const VertexId x : t) ASSERT_LT(x, grid.vertices());
  }
  // The inner points of the last face are the last numbers.
  EXPECT_GE(grid.vertex(399, 1, 1), grid.vertices() - (n - 1) * (n - 2) / 2);
}

/// Samples and faces beyond 2^32 and 2^40, in pieces across these borders and at the end: numbers,
/// places and faces agree with each other.
TEST(DyadicGrid, AgreesWithItselfBeyondFortyBits) {
  const Shape shape = five_spheres();
  for (const unsigned level : {14u, 16u, 20u}) {
    SCOPED_TRACE(level);
    const DyadicGrid grid = grid_of(shape, level);
    const double n = double(1u << level);
    std::mt19937_64 random(level);
    const auto starts_below = [&](std::uint64_t count) {
      std::vector<std::uint64_t> starts = {0, shape.position.size() - 10, count - 1000};
      for (const unsigned bits : {31u, 32u, 40u, 44u}) starts.push_back((1ULL << bits) - 500);
      for (int i = 0; i < 50; ++i) starts.push_back(random() % count);
      std::erase_if(starts, [&](std::uint64_t first) { return first > count - 1000; });
      return starts;
    };
    std::vector<map::TaggedPoint> samples(1000);
    for (const std::uint64_t first : starts_below(grid.vertices())) {
      grid.samples(first, samples);
      std::set<std::uint64_t> numbers;
      for (const auto& [number, at] : samples) {
        ASSERT_EQ(grid.vertex(at.face, static_cast<std::uint32_t>(at.u * n),
                              static_cast<std::uint32_t>(at.v * n)),
                  number);
        numbers.insert(number);
      }
      ASSERT_EQ(numbers.size(), samples.size());
      ASSERT_LT(*numbers.rbegin(), grid.vertices());
      // A piece that begins elsewhere says the same.
      std::vector<map::TaggedPoint> later(500);
      grid.samples(first + 500, later);
      for (std::size_t i = 0; i < later.size(); ++i) ASSERT_EQ(later[i].tag, samples[500 + i].tag);
    }
    std::vector<Triangle> faces(1000);
    for (const std::uint64_t first : starts_below(grid.faces())) {
      grid.triangles(first, faces);
      for (std::size_t f = 0; f < faces.size(); ++f) {
        ASSERT_EQ(faces[f], grid.triangle(first + f));
        ASSERT_LT(*std::max_element(faces[f].begin(), faces[f].end()), grid.vertices());
      }
    }
  }
}

/// At level 20 too both faces of an edge give its points the same numbers.
TEST(DyadicGrid, SharesEdgesAtTheLastLevel) {
  const Shape shape = five_spheres();
  const DyadicGrid grid = grid_of(shape, 20);
  const std::uint32_t n = 1u << 20;
  std::map<std::pair<LocalIndex, LocalIndex>, std::vector<std::uint64_t>> seen;
  std::size_t twice = 0;
  for (std::uint32_t f = 0; f < shape.triangle.size(); ++f) {
    for (std::size_t e = 0; e < 3; ++e) {
      const LocalIndex a = shape.triangle[f][e];
      const LocalIndex b = shape.triangle[f][(e + 1) % 3];
      std::vector<std::uint64_t> numbers;
      for (std::uint32_t m : {1u, 2u, 3u, 77'777u, n / 2, n / 4 * 3, n - 1}) {
        if (a > b) m = n - m;
        std::array<std::uint32_t, 3> weight{};
        weight[e] = n - m;
        weight[(e + 1) % 3] = m;
        numbers.push_back(grid.vertex(f, weight[1], weight[2]));
      }
      const auto [at, fresh] = seen.try_emplace({std::min(a, b), std::max(a, b)}, numbers);
      twice += !fresh;
      ASSERT_EQ(at->second, numbers);
    }
  }
  EXPECT_EQ(seen.size(), 600u);
  EXPECT_EQ(twice, 600u);
}

TEST(DyadicGrid, RefusesToPlaceABaseVertexWithoutAFace) {
  const std::vector<DyadicGrid::BaseTriangle> base = {{0, 1, 2}};
  const DyadicGrid grid(4, base, 2);
  std::vector<map::TaggedPoint> samples(grid.vertices());
  EXPECT_THROW(grid.samples(0, samples), CorruptionError);
  EXPECT_NO_THROW(grid.samples(4, std::span(samples).subspan(4)));
}

TEST(DyadicGrid, HasTheVerticesOfCoarserMeshesInTheirOrder) {
  const Shape shape = test::octahedron();
  for (unsigned fine_level = 0; fine_level <= 5; ++fine_level) {
    const DyadicGrid fine = grid_of(shape, fine_level);
    for (unsigned level = 0; level <= fine_level; ++level) {
      const DyadicGrid coarse = grid_of(shape, level);
      std::vector<std::uint64_t> number;  // in the fine mesh, of each vertex of the coarse one
      fine.coarse_vertices(level, [&](std::uint64_t first, std::uint64_t count) {
        for (std::uint64_t i = 0; i < count; ++i) number.push_back(first + i);
      });
      ASSERT_EQ(number.size(), coarse.vertices());
      const std::uint32_t n = 1u << level;
      const std::uint32_t step = 1u << (fine_level - level);
      for (std::uint32_t f = 0; f < shape.triangle.size(); ++f) {
        for (std::uint32_t j = 0; j <= n; ++j) {
          for (std::uint32_t i = 0; i + j <= n; ++i) {
            ASSERT_EQ(number[coarse.vertex(f, i, j)], fine.vertex(f, step * i, step * j));
          }
        }
      }
    }
  }
}

TEST(DyadicGrid, SharesInteriorEdgesOfTwoFaces) {
  const Shape shape = test::octahedron();
  const DyadicGrid grid = grid_of(shape, 4);
  const std::uint32_t n = 16;
  // All points of each edge from both sides: (face, edge) -> numbers, from its lower vertex on.
  std::map<std::pair<LocalIndex, LocalIndex>, std::vector<std::vector<std::uint64_t>>> seen;
  for (std::uint32_t f = 0; f < shape.triangle.size(); ++f) {
    for (std::size_t e = 0; e < 3; ++e) {
      const LocalIndex a = shape.triangle[f][e];
      const LocalIndex b = shape.triangle[f][(e + 1) % 3];
      std::vector<std::uint64_t> numbers;
      for (std::uint32_t m = 0; m <= n; ++m) {
        std::array<std::uint32_t, 3> weight{};
        weight[e] = n - m;
        weight[(e + 1) % 3] = m;
        numbers.push_back(grid.vertex(f, weight[1], weight[2]));
      }
      if (a > b) std::reverse(numbers.begin(), numbers.end());
      seen[{std::min(a, b), std::max(a, b)}].push_back(numbers);
    }
  }
  EXPECT_EQ(seen.size(), 12u);
  for (const auto& [edge, sides] : seen) {
    ASSERT_EQ(sides.size(), 2u);
    EXPECT_EQ(sides[0], sides[1]);
  }
}

}  // namespace
}  // namespace remaps::resample
