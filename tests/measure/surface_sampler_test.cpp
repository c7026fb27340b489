#include "remaps/measure/surface_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "measure/test_surfaces.h"

namespace remaps {
namespace {

using test::bumpy_sphere;
using test::Soup;
using test::source_of;
using test::square;

constexpr std::uint64_t kMemory = 16 << 20;  // pieces of 4,096 triangles

SurfacePoints sample_all(const SurfacePieces& pieces, const SurfaceSummary& summary,
                         const SamplingPlan& plan, unsigned threads) {
  const SurfaceSampler sampler(summary, plan);
  SurfacePoints all;
  pieces.stream(
      threads, [&](std::size_t i) { return sampler.touches(i); },
      [&](std::size_t i, const SurfacePiece& piece, unsigned) -> Commit {
        std::vector<double> areas;
        SurfacePoints points;
        sampler.sample(i, piece, areas, points);
        return [&all, points] {
          all.samples.insert(all.samples.end(), points.samples.begin(), points.samples.end());
          all.corners.insert(all.corners.end(), points.corners.begin(), points.corners.end());
        };
      });
  return all;
}

void expect_same(const std::vector<SurfacePoint>& a, const std::vector<SurfacePoint>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].position, b[i].position) << i;
    ASSERT_EQ(a[i].word, b[i].word) << i;
  }
}

TEST(SurfaceSampler, SummarisesASurface) {
  const Soup soup = bumpy_sphere(60, 0, 1);
  double area = 0;
  Box3 box;
  for (const auto& t : soup) {
    area += 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
    for (const Vec3& corner : t) box.add(corner);
  }
  const TriangleSource source = source_of(soup);
  const SurfaceSummary summary = summarise_surface(StreamedPieces(source, kMemory), 300, 2);
  EXPECT_EQ(summary.triangles, soup.size());
  EXPECT_NEAR(summary.area, area, 1e-10);
  EXPECT_EQ(summary.box.low, box.low);
  EXPECT_EQ(summary.box.high, box.high);
  EXPECT_EQ(summary.pieces.size(), (soup.size() + 4095) / 4096);
  EXPECT_EQ(summary.pieces.back().triangles_before, 4096 * (summary.pieces.size() - 1));
}

TEST(SurfaceSampler, SpreadsScoutsOverTheArea) {
  Soup soup = bumpy_sphere(60, 0, 1);  // 14,160 tiny triangles, and a square of 8 times their area
  for (TrianglePositions t : square(0, 4)) {
    for (Vec3& corner : t) corner = {10 * corner.x, 10 * corner.y, corner.z};
    soup.push_back(t);
  }
  const TriangleSource source = source_of(soup);
  for (const std::size_t most : std::initializer_list<std::size_t>{1, 2, 50, 300, 1'000}) {
    const SurfaceSummary summary = summarise_surface(StreamedPieces(source, kMemory), most, 1);
    ASSERT_LE(summary.scouts.size(), most);
    ASSERT_GE(summary.scouts.size(), 1u);
    if (most < 50) continue;
    EXPECT_GE(summary.scouts.size(), most / 5);
    const auto on_square = std::count_if(summary.scouts.begin(), summary.scouts.end(),
                                         [](const Vec3& p) { return p.z == 4; });
    EXPECT_GT(on_square, static_cast<std::ptrdiff_t>(summary.scouts.size() / 4));
    EXPECT_LT(on_square, static_cast<std::ptrdiff_t>(summary.scouts.size()));
  }
}

TEST(SurfaceSampler, TakesTheSamePointsInPartsAndOnThreads) {
  const Soup soup = bumpy_sphere(60, 0, 1);
  const TriangleSource source = source_of(soup, 777);
  const StreamedPieces pieces(source, kMemory);
  const SurfaceSummary summary = summarise_surface(pieces, 100, 1);
  const std::uint64_t corners = 3 * soup.size();
  const SamplingPlan whole{
      .samples = 10'000, .seed = 1, .last_sample = 10'000, .last_corner = corners};
  const SurfacePoints all = sample_all(pieces, summary, whole, 1);
  ASSERT_EQ(all.samples.size(), 10'000u);
  ASSERT_EQ(all.corners.size(), corners);
  for (std::size_t i = 0; i < corners; ++i) {
    ASSERT_EQ(all.corners[i].position, soup[i / 3][i % 3]);
  }
  SurfacePoints parts;
  for (std::uint64_t part = 0; part < 7; ++part) {
    SamplingPlan plan = whole;
    plan.first_sample = 10'000 * part / 7, plan.last_sample = 10'000 * (part + 1) / 7;
    plan.first_corner = corners * part / 7, plan.last_corner = corners * (part + 1) / 7;
    const SurfacePoints some = sample_all(pieces, summary, plan, 3);
    parts.samples.insert(parts.samples.end(), some.samples.begin(), some.samples.end());
    parts.corners.insert(parts.corners.end(), some.corners.begin(), some.corners.end());
  }
  expect_same(parts.samples, all.samples);
  expect_same(parts.corners, all.corners);
}

TEST(SurfaceSampler, PassesOverPiecesWithoutPoints) {
  const Soup soup = bumpy_sphere(80, 0, 1);
  const TriangleSource source = source_of(soup);
  const SurfaceSummary summary = summarise_surface(StreamedPieces(source, kMemory), 100, 1);
  const SurfaceSampler sampler(summary,
                               {.samples = 1'000, .seed = 1, .first_sample = 0, .last_sample = 10});
  EXPECT_TRUE(sampler.touches(0));
  for (std::size_t i = 1; i < summary.pieces.size(); ++i) EXPECT_FALSE(sampler.touches(i));
}

}  // namespace
}  // namespace remaps
