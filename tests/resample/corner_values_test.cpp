#include "remaps/resample/corner_values.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

namespace remaps::resample {
namespace {

using Uv = std::array<float, 2>;

const std::vector<AttributeSpec> kSpecs = {
    {"uv",
     AttributeKind::uv,
     AttributePer::corner,
     {{"u", ScalarType::float32}, {"v", ScalarType::float32}},
     false}};

/// The four points of a face: its corners at the given places in input faces of one vertex each,
/// where all corners have the same value; the centre in an input face of its own.
struct Case {
  std::array<FaceSample, 4> sample;
  std::vector<std::byte> rows;

  Case() {
    for (std::uint8_t slot = 0; slot < 4; ++slot) {
      sample[slot].slot = slot;
      sample[slot].there = 1;
      sample[slot].vertex = {10, 11, 12};
      sample[slot].u = sample[slot].v = 1.0 / 3;
    }
    rows.resize(4 * 3 * 16);
  }
  void put(std::size_t slot, std::array<VertexId, 3> vertex, std::array<Uv, 3> uv) {
    for (std::size_t i = 0; i < 3; ++i) {
      std::byte* const row = rows.data() + (3 * slot + i) * 16;
      std::memcpy(row, &vertex[i], 8);
      std::memcpy(row + 8, &uv[i], 8);
    }
  }
  std::array<Uv, 3> find() {
    CornerValues values(kSpecs);
    std::vector<std::byte> out(24);
    values.find(sample, rows, out);
    std::array<Uv, 3> result;
    std::memcpy(&result, out.data(), 24);
    return result;
  }
};

/// A face of the grid with corners (0, 0), (3, 0), (0, 3) on a plane, where uv is x, y.
Case plane() {
  Case c;
  const std::array<Vec3f, 3> corner = {Vec3f{0, 0, 0}, Vec3f{3, 0, 0}, Vec3f{0, 3, 0}};
  for (std::size_t i = 0; i < 3; ++i) {
    c.sample[i].position[0] = corner[i];
    const Uv uv = {corner[i].x, corner[i].y};
    c.put(i, {10, 11, 12}, {uv, uv, uv});
  }
  c.sample[kCentre].position = {Vec3f{1, 1, 0}, Vec3f{2, 1, 0}, Vec3f{1, 2, 0}};
  c.put(kCentre, {10, 11, 12}, {Uv{1, 1}, Uv{2, 1}, Uv{1, 2}});
  return c;
}

TEST(CornerValues, AreTheirOwnWhereTheyContinueTheCentre) {
  EXPECT_EQ(plane().find(), (std::array{Uv{0, 0}, Uv{3, 0}, Uv{0, 3}}));
}

TEST(CornerValues, KeepWhatBendsALittle) {
  Case c = plane();
  c.put(1, {10, 11, 12}, {Uv{5, 1}, Uv{5, 1}, Uv{5, 1}});
  EXPECT_EQ(c.find()[1], (Uv{5, 1}));
}

TEST(CornerValues, ContinueTheCentreAcrossASeam) {
  Case c = plane();
  c.put(1, {10, 11, 12}, {Uv{70, 80}, Uv{70, 80}, Uv{70, 80}});
  const auto found = c.find();
  EXPECT_EQ(found[0], (Uv{0, 0}));
  EXPECT_NEAR(found[1][0], 3, 1e-6);
  EXPECT_NEAR(found[1][1], 0, 1e-6);
  EXPECT_EQ(found[2], (Uv{0, 3}));
}

TEST(CornerValues, FindTheRowOfAVertexInAFaceThatWasTurned) {
  Case c = plane();
  c.put(0, {12, 11, 10}, {Uv{0, 0.5F}, Uv{0, 0}, Uv{0.5F, 0}});
  c.sample[0].u = 0.25;
  c.sample[0].v = 0;
  EXPECT_EQ(c.find()[0], (Uv{0.375F, 0}));
  // The centre's too, or the seam would be seen where there is none.
  c = plane();
  c.put(kCentre, {11, 12, 10}, {Uv{2, 1}, Uv{1, 2}, Uv{1, 1}});
  EXPECT_EQ(c.find(), (std::array{Uv{0, 0}, Uv{3, 0}, Uv{0, 3}}));
}

TEST(CornerValues, TrustThemselvesWhereTheCentreForetellsNothing) {
  Case c = plane();
  c.put(1, {10, 11, 12}, {Uv{70, 80}, Uv{70, 80}, Uv{70, 80}});
  c.sample[kCentre].position = {Vec3f{1, 1, 0}, Vec3f{1, 1, 0}, Vec3f{1, 1, 0}};
  EXPECT_EQ(c.find()[1], (Uv{70, 80}));
  c = plane();
  c.put(1, {10, 11, 12}, {Uv{70, 80}, Uv{70, 80}, Uv{70, 80}});
  c.put(kCentre, {10, 11, 12}, {Uv{1, 1}, Uv{1, 1}, Uv{1, 1}});
  EXPECT_EQ(c.find()[1], (Uv{70, 80}));
}

TEST(CornerValues, AreThoseOfTheNextCornerWhereTheInputHasNone) {
  Case c = plane();
  c.sample[1].there = 0;
  EXPECT_EQ(c.find(), (std::array{Uv{0, 0}, Uv{0, 3}, Uv{0, 3}}));
  c.sample[2].there = 0;
  c.put(0, {10, 11, 12}, {Uv{7, 8}, Uv{7, 8}, Uv{7, 8}});
  EXPECT_EQ(c.find(), (std::array{Uv{7, 8}, Uv{7, 8}, Uv{7, 8}}));
  c.sample[0].there = 0;
  EXPECT_EQ(c.find(), (std::array{Uv{0, 0}, Uv{0, 0}, Uv{0, 0}}));
}

}  // namespace
}  // namespace remaps::resample
