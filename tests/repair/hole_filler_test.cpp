#include "remaps/repair/hole_filler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

namespace remaps::repair {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Hole circle(std::size_t n) {
  Hole hole;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2 * M_PI * double(i) / double(n);
    hole.vertex.push_back(i);
    hole.position.push_back(to_float({std::cos(angle), std::sin(angle), 0}));
  }
  return hole;
}

double area_of(const Hole& hole, const Triangles& triangles) {
  double sum = 0;
  for (const auto& t : triangles) {
    const Vec3 a = widen(hole.position[t[0]]);
    sum += 0.5 * norm(cross(widen(hole.position[t[1]]) - a, widen(hole.position[t[2]]) - a));
  }
  return sum;
}

/// Each side of the loop is on one triangle, in the order of the loop; each other one on two that
/// agree.
void expect_fills(const Hole& hole, const Triangles& triangles) {
  const auto n = static_cast<std::uint32_t>(hole.position.size());
  ASSERT_EQ(triangles.size(), n - 2);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> half_edges;
  for (const auto& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++half_edges[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : half_edges) {
    EXPECT_EQ(count, 1);
    const bool side = (edge.first + 1) % n == edge.second;
    EXPECT_EQ(half_edges.contains({edge.second, edge.first}), !side);
  }
  for (std::uint32_t i = 0; i < n; ++i) EXPECT_TRUE(half_edges.contains({i, (i + 1) % n}));
}

TEST(HoleFiller, FillsFlatHolesExactly) {
  for (const std::size_t n : {3u, 4u, 5u, 17u, 128u}) {
    const Hole hole = circle(n);
    const Triangles triangles = triangulate_hole(hole);
    expect_fills(hole, triangles);
    EXPECT_NEAR(area_of(hole, triangles), 0.5 * double(n) * std::sin(2 * M_PI / double(n)), 1e-5);
  }
}

TEST(HoleFiller, TakesTheLeastArea) {
  // A saddle: of the two ways to fill it the other one is larger.
  Hole hole = circle(4);
  hole.position[0].z = hole.position[2].z = 0.5f;
  hole.position[1].x = 0.2f;
  const Triangles least = triangulate_hole(hole);
  const double area = area_of(hole, least);
  EXPECT_LE(area, area_of(hole, {{0, 1, 2}, {0, 2, 3}}) + 1e-12);
  EXPECT_LE(area, area_of(hole, {{0, 1, 3}, {1, 2, 3}}) + 1e-12);
}

TEST(HoleFiller, MakesNoEdgeThatExists) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 50; ++round) {
    Hole hole = circle(9);
    for (std::uint32_t i = 0; i < 9; ++i) {
      for (std::uint32_t j = i + 2; j < 9; ++j) {
        if (random() % 3 == 0) hole.joined.emplace_back(i, j);
      }
    }
    const Triangles triangles = triangulate_hole(hole);
    if (triangles.empty()) continue;
    expect_fills(hole, triangles);
    for (const auto& t : triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::pair side{std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3])};
        if (side == std::pair{0u, 8u}) continue;  // the last side of the loop
        EXPECT_FALSE(std::binary_search(hole.joined.begin(), hole.joined.end(), side));
      }
    }
  }
}

TEST(HoleFiller, LeavesWhatItCannotFillToAMiddle) {
  Hole hole = circle(4);
  hole.joined = {{0, 2}, {1, 3}};
  EXPECT_TRUE(triangulate_hole(hole).empty());
  Hole around = circle(3);
  around.of_one_face = true;
  EXPECT_TRUE(triangulate_hole(around).empty()) << "that would be the face, turned";
  EXPECT_TRUE(triangulate_hole(circle(129)).empty());
}

}  // namespace
}  // namespace remaps::repair
