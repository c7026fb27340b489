#include "remaps/codec/base_code.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "codec/codec_shapes.h"
#include "remaps/base/errors.h"

namespace remaps::codec {
namespace {

/// A base in its order, with positions on a grid of so many cells.
GridBase grid_base(const test::CodecBase& base, double cells) {
  const BaseOrder order = order_base(base.vertices(), base.face);
  GridBase result;
  result.position.resize(base.vertices());
  result.face.resize(base.face.size());
  for (std::size_t v = 0; v < base.position.size(); ++v) {
    const Vec3& p = base.position[v];
    result.position[order.vertex[v]] = {static_cast<std::int32_t>(cells * p.x),
                                        static_cast<std::int32_t>(cells * p.y),
                                        static_cast<std::int32_t>(cells * p.z)};
  }
  for (std::size_t f = 0; f < base.face.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      result.face[order.face[f]][(k + order.rotation[f]) % 3] = order.vertex[base.face[f][k]];
    }
  }
  return result;
}

GridBase decode(store::ByteSpan code, const GridBase& base) {
  return decode_base(code, static_cast<std::uint32_t>(base.position.size()),
                     static_cast<std::uint32_t>(base.face.size()));
}

TEST(BaseCode, GivesBackEveryBase) {
  for (const test::CodecBase& base : test::codec_bases()) {
    for (const double cells : {0.0, 1.0, 300.0, 1e6}) {
      const GridBase coded = grid_base(base, cells);
      const GridBase decoded = decode(encode_base(coded), coded);
      EXPECT_EQ(decoded.face, coded.face) << base.name;
      EXPECT_EQ(decoded.position, coded.position) << base.name;
    }
  }
}

TEST(BaseCode, TheOrderOfAnOrderedBaseIsItsOwn) {
  for (const test::CodecBase& base : test::codec_bases()) {
    const GridBase coded = grid_base(base, 100);
    const BaseOrder order = order_base(base.vertices(), coded.face);
    for (std::uint32_t v = 0; v < order.vertex.size(); ++v) EXPECT_EQ(order.vertex[v], v);
    for (std::uint32_t f = 0; f < order.face.size(); ++f) {
      EXPECT_EQ(order.face[f], f);
      EXPECT_EQ(order.rotation[f], 0);
    }
  }
}

TEST(BaseCode, ShuffledBasesTakeAboutTheSame) {
  test::CodecBase base = test::base_of(test::icosphere(2));
  const std::size_t bytes = encode_base(grid_base(base, 300)).size();
  // Connectivity of a regular mesh is nearly free, positions take what they must.
  EXPECT_LT(double(bytes), 3.5 * double(base.vertices()));
  std::mt19937_64 random(3);
  for (int round = 0; round < 5; ++round) {
    std::shuffle(base.face.begin(), base.face.end(), random);
    const GridBase coded = grid_base(base, 300);
    const store::Bytes code = encode_base(coded);
    EXPECT_EQ(decode(code, coded).face, coded.face);
    EXPECT_LT(double(code.size()), 1.1 * double(bytes));
  }
}

/// Whose border is as long as the base is large: a step for each of its edges would never end.
TEST(BaseCode, TakesLongBordersInLinearTime) {
  constexpr std::uint32_t kFaces = 200'000;
  test::CodecBase fan;
  fan.position.assign(kFaces + 2, Vec3{});
  for (std::uint32_t i = 0; i < kFaces; ++i) fan.face.push_back({0, i + 1, i + 2});
  const GridBase coded = grid_base(fan, 1);
  const GridBase decoded = decode(encode_base(coded), coded);
  EXPECT_EQ(decoded.face, coded.face);
}

TEST(BaseCode, RefusesCodesOfSomethingElse) {
  const GridBase base = grid_base(test::base_of(test::torus(4, 5)), 300);
  const store::Bytes code = encode_base(base);
  const auto vertices = static_cast<std::uint32_t>(base.position.size());
  const auto faces = static_cast<std::uint32_t>(base.face.size());
  EXPECT_THROW(decode_base(code, vertices - 1, faces), GeometryError);
  EXPECT_THROW(decode_base(code, vertices + 1, faces), GeometryError);
  EXPECT_THROW(decode_base(code, vertices, faces + 1), GeometryError);
  for (std::size_t size = 0; size + 4 < code.size(); ++size) {
    EXPECT_THROW(decode_base(store::ByteSpan(code).first(size), vertices, faces), GeometryError)
        << size;
  }
}

TEST(BaseCode, RefusesTwoFacesOnOneSide) {
  EXPECT_THROW(order_base(4, std::vector<Face>{{0, 1, 2}, {0, 1, 3}}), GeometryError);
}

}  // namespace
}  // namespace remaps::codec
