#include "remaps/measure/sample_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <random>
#include <thread>
#include <vector>

#include "measure/test_surfaces.h"
#include "remaps/measure/morton.h"
#include "remaps/mesh/point_triangle.h"

namespace remaps {
namespace {

using test::bumpy_sphere;
using test::Soup;

std::vector<SurfacePiece> pieces_of(const Soup& soup, std::size_t size) {
  std::vector<SurfacePiece> pieces;
  for (std::size_t i = 0; i < soup.size(); ++i) {
    if (i % size == 0) pieces.emplace_back();
    SurfacePiece& piece = pieces.back();
    const auto first = static_cast<LocalIndex>(piece.position.size());
    piece.position.insert(piece.position.end(), soup[i].begin(), soup[i].end());
    piece.triangle.push_back({first, first + 1, first + 2});
  }
  return pieces;
}

std::vector<SurfacePoint> random_points(std::size_t n, double reach, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-reach, reach);
  Box3 box;
  box.add({-reach, -reach, -reach});
  box.add({reach, reach, reach});
  const MortonCurve curve(box, 20);
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
    points.push_back({p, curve.place(p)});
  }
  return points;
}

double least_distance2(const Vec3& p, const Soup& soup) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : soup) least = std::min(least, triangle_distance2(p, t[0], t[1], t[2]));
  return least;
}

/// Each distance is the least of all, to the last bit, whatever the pieces and their order.
void expect_exact(const Soup& soup, const std::vector<SurfacePoint>& points, double scale = 0.25) {
  std::vector<Vec3> scouts;
  for (std::size_t i = 0; i < soup.size(); i += 1 + soup.size() / 50) scouts.push_back(soup[i][0]);
  for (const std::size_t size : {soup.size(), std::size_t{100}, std::size_t{7}}) {
    std::vector<SurfacePiece> pieces = pieces_of(soup, size);
    std::shuffle(pieces.begin(), pieces.end(), std::mt19937_64(size));
    SampleTree tree(points, SampleTree::Repeats::keep);
    tree.bound_by(scouts, scale);
    PieceTree piece_tree;
    SampleTree::Scratch scratch;
    for (const SurfacePiece& piece : pieces) {
      piece_tree.build(piece, scale);
      tree.approach(piece_tree, scratch);
    }
    ASSERT_EQ(tree.points().size(), points.size());
    for (const SurfacePoint& point : tree.points()) {
      ASSERT_EQ(point.distance2(), least_distance2(point.position, soup)) << size;
    }
  }
}

TEST(SampleTree, FindsTheLeastDistanceAtEverySize) {
  const Soup soup = bumpy_sphere(12, 0.05, 1);
  for (const std::size_t n :
       std::initializer_list<std::size_t>{0, 1, 15, 16, 17, 256, 257, 1'000}) {
    expect_exact(soup, random_points(n, 1.5, 2));
  }
}

TEST(SampleTree, FindsTheLeastDistanceToAnyShapes) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto any = [&] { return Vec3{coordinate(random), coordinate(random), coordinate(random)}; };
  Soup soup;
  for (int i = 0; i < 600; ++i) {
    const Vec3 a = any(), b = any();
    const double size = std::pow(10.0, -i % 7);
    TrianglePositions t{a, a + size * (b - a), a + size * (any() - a)};
    if (i % 5 == 0) t[2] = t[0] + 0.3 * (t[1] - t[0]);
    if (i % 11 == 0) t[1] = t[2] = t[0];
    soup.push_back(t);
  }
  expect_exact(soup, random_points(700, 1.2, 4));
}

TEST(SampleTree, FindsTheLeastDistanceToOneHugeTriangleAmongMany) {
  Soup soup = bumpy_sphere(12, 0.01, 5);
  soup.insert(soup.begin() + 100, {{{-500, -500, 0.1}, {500, -500, 0.1}, {0, 700, 0.1}}});
  expect_exact(soup, random_points(700, 1.2, 6), 0x1p-10);
}

TEST(SampleTree, FindsTheLeastDistanceFromFarAway) {
  Soup soup = bumpy_sphere(12, 0.01, 7);
  for (auto& t : soup) {
    for (Vec3& corner : t) corner = corner + Vec3{1e6, -3e5, 20};
  }
  expect_exact(soup, random_points(300, 1, 8), 0x1p-20);
  std::vector<SurfacePoint> near = random_points(300, 1.5, 9);
  for (SurfacePoint& point : near) point.position = point.position + Vec3{1e6, -3e5, 20};
  expect_exact(soup, near);
}

TEST(SampleTree, FindsTheLeastDistanceBetweenConcentricSpheres) {
  const Soup inner = bumpy_sphere(16, 0, 10);
  std::vector<SurfacePoint> points;
  for (const auto& t : bumpy_sphere(16, 0, 11)) points.push_back({1.5 * t[0], 0});
  expect_exact(inner, points);
}

TEST(SampleTree, IsTheSameWhenThreadsApproachAtOnce) {
  const Soup soup = bumpy_sphere(40, 0.05, 12);
  const std::vector<SurfacePiece> pieces = pieces_of(soup, 97);
  SampleTree tree(random_points(5'000, 1.2, 13), SampleTree::Repeats::keep);
  tree.bound_by(std::vector<Vec3>{soup[0][0]}, 0.5);
  {
    std::vector<std::jthread> threads;
    for (std::size_t first = 0; first < 4; ++first) {
      threads.emplace_back([&, first] {
        PieceTree piece_tree;
        SampleTree::Scratch scratch;
        for (std::size_t i = first; i < pieces.size(); i += 4) {
          piece_tree.build(pieces[i], 0.5);
          tree.approach(piece_tree, scratch);
        }
      });
    }
  }
  for (const SurfacePoint& point : tree.points()) {
    ASSERT_EQ(point.distance2(), least_distance2(point.position, soup));
  }
}

TEST(SampleTree, KnowsWhatIsTooFarAway) {
  SampleTree tree(random_points(1'000, 1, 14), SampleTree::Repeats::keep);
  tree.bound_by(std::vector<Vec3>{{0, 0, 0}}, 0.5);  // no point has more than sqrt(3) from there
  const auto box_at = [](double x) {
    Box3 box;
    box.add({x, -0.1, -0.1});
    box.add({x + 0.2, 0.1, 0.1});
    return box;
  };
  EXPECT_TRUE(tree.any_near(box_at(0)));
  EXPECT_TRUE(tree.any_near(box_at(1.2)));
  EXPECT_FALSE(tree.any_near(box_at(3)));
  EXPECT_FALSE(tree.any_near(Box3{}));
  SampleTree none;
  EXPECT_FALSE(none.any_near(box_at(0)));
}

TEST(SampleTree, DropsRepeatsOnRequest) {
  std::vector<SurfacePoint> points = random_points(100, 1, 15);
  points.insert(points.end(), points.begin(), points.begin() + 60);
  EXPECT_EQ(SampleTree(points, SampleTree::Repeats::keep).points().size(), 160u);
  EXPECT_EQ(SampleTree(points, SampleTree::Repeats::drop).points().size(), 100u);
}

}  // namespace
}  // namespace remaps
