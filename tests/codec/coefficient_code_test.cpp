#include "remaps/codec/coefficient_code.h"

#include <gtest/gtest.h>

#include "codec/codec_shapes.h"

namespace remaps::codec {
namespace {

constexpr std::uint64_t kMemory = 256u << 20;

/// Magnitudes below 2^planes; one of so many is not 0, and they fall from level to level.
Coefficients random_coefficients(const SubdivisionHierarchy& hierarchy, unsigned planes,
                                 unsigned one_of, std::mt19937_64& random) {
  Coefficients result;
  result.resize(hierarchy.vertices());
  unsigned level = 0;
  for (std::uint32_t v = 0; v < hierarchy.vertices(); ++v) {
    while (level < hierarchy.levels() && v >= hierarchy.vertices(level)) ++level;
    for (unsigned c = 0; c < 3; ++c) {
      if (random() % one_of != 0) continue;
      const unsigned bits =
          planes - std::min(planes, static_cast<unsigned>(random() % (level + 2)));
      result.magnitude[v][c] =
          static_cast<std::uint32_t>(random() & ((std::uint64_t{1} << bits) - 1));
      if (result.magnitude[v][c] != 0 && random() % 2 == 0) {
        result.negative[v] |= static_cast<std::uint8_t>(1 << c);
      }
    }
  }
  return result;
}

/// What is known of `decoded` is what `original` has above its plane.
void expect_prefix_of(const Coefficients& decoded, const Coefficients& original) {
  ASSERT_EQ(decoded.magnitude.size(), original.magnitude.size());
  ASSERT_EQ(decoded.negative.size(), original.negative.size());
  ASSERT_EQ(decoded.plane.size(), original.plane.size());
  for (std::size_t v = 0; v < original.magnitude.size(); ++v) {
    for (unsigned c = 0; c < 3; ++c) {
      const unsigned plane = decoded.plane[v][c];
      const std::uint32_t known = original.magnitude[v][c] >> plane << plane;
      ASSERT_EQ(decoded.magnitude[v][c], known) << "vertex " << v << " component " << c;
      if (known != 0) {
        ASSERT_EQ(decoded.negative[v] >> c & 1, original.negative[v] >> c & 1);
      }
    }
  }
}

std::size_t known_bits(const Coefficients& coefficients) {
  std::size_t sum = 0;
  for (const auto& vertex : coefficients.plane) {
    for (const std::uint8_t plane : vertex) sum += 30u - plane;
  }
  return sum;
}

Coefficients decode(const SubdivisionHierarchy& hierarchy, store::ByteSpan code, unsigned planes) {
  Coefficients result;
  decode_coefficients(hierarchy, code, planes, result);
  return result;
}

TEST(CoefficientCode, GivesBackWhatWasCoded) {
  std::mt19937_64 random(1);
  for (const test::CodecBase& base : test::codec_bases()) {
    for (const unsigned levels : {0u, 1u, 3u}) {
      MemoryBudget budget(kMemory);
      const SubdivisionHierarchy hierarchy(base.vertices(), base.face, levels, budget);
      for (const unsigned planes : {1u, 12u, 30u}) {
        for (const unsigned one_of : {1u, 20u, 1000000u}) {
          SCOPED_TRACE(base.name + ", levels " + std::to_string(levels) + ", planes " +
                       std::to_string(planes) + ", one of " + std::to_string(one_of));
          const Coefficients given = random_coefficients(hierarchy, planes, one_of, random);
          const Coefficients back =
              decode(hierarchy, encode_coefficients(hierarchy, given, planes), planes);
          ASSERT_EQ(back.magnitude, given.magnitude);
          ASSERT_EQ(back.negative, given.negative);
        }
      }
    }
  }
}

TEST(CoefficientCode, GivesBackFiveLevels) {
  std::mt19937_64 random(2);
  for (const test::Shape& shape : {test::octahedron(), test::cone(5), test::torus(3, 5)}) {
    const test::CodecBase base = test::base_of(shape);
    MemoryBudget budget(kMemory);
    const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 5, budget);
    for (const unsigned one_of : {1u, 500u}) {
      const Coefficients given = random_coefficients(hierarchy, 12, one_of, random);
      const Coefficients back = decode(hierarchy, encode_coefficients(hierarchy, given, 12), 12);
      EXPECT_EQ(back.magnitude, given.magnitude) << shape.name;
      EXPECT_EQ(back.negative, given.negative) << shape.name;
    }
  }
}

TEST(CoefficientCode, EveryPrefixIsACoarserVersion) {
  std::mt19937_64 random(3);
  for (const test::Shape& shape :
       {test::tetrahedron(), test::cone(5), test::together(test::octahedron(), test::disk(1))}) {
    SCOPED_TRACE(shape.name);
    const test::CodecBase base = test::base_of(shape);
    MemoryBudget budget(kMemory);
    const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 3, budget);
    for (const unsigned one_of : {1u, 20u}) {
      const Coefficients given = random_coefficients(hierarchy, 14, one_of, random);
      const store::Bytes code = encode_coefficients(hierarchy, given, 14);
      std::size_t before = 0;
      for (std::size_t bytes = 0; bytes <= code.size(); bytes += 1 + bytes / 50) {
        const Coefficients part = decode(hierarchy, std::span(code).first(bytes), 14);
        expect_prefix_of(part, given);
        ASSERT_FALSE(testing::Test::HasFatalFailure()) << bytes << " of " << code.size();
        const std::size_t known = known_bits(part);
        ASSERT_GE(known, before) << bytes;
        before = known;
      }
    }
  }
}

TEST(CoefficientCode, OfNoBytesIsNothing) {
  const test::CodecBase base = test::base_of(test::cone(5));
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 3, budget);
  const Coefficients none = decode(hierarchy, {}, 12);
  ASSERT_EQ(none.magnitude.size(), hierarchy.vertices());
  for (std::uint32_t v = 0; v < hierarchy.vertices(); ++v) {
    EXPECT_EQ(none.magnitude[v], (std::array<std::uint32_t, 3>{}));
    EXPECT_EQ(none.plane[v], (std::array<std::uint8_t, 3>{12, 12, 12}));
  }
}

TEST(CoefficientCode, OfNothingIsShort) {
  const test::CodecBase base = test::base_of(test::icosphere(0));
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 5, budget);
  Coefficients nothing;
  nothing.resize(hierarchy.vertices());
  EXPECT_LT(encode_coefficients(hierarchy, nothing, 12).size(), 40u);
}

TEST(CoefficientCode, IsTheSameEachTime) {
  std::mt19937_64 random(4);
  const test::CodecBase base = test::base_of(test::octahedron());
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 3, budget);
  const Coefficients given = random_coefficients(hierarchy, 12, 10, random);
  const store::Bytes code = encode_coefficients(hierarchy, given, 12);
  EXPECT_EQ(encode_coefficients(hierarchy, given, 12), code);
  const Coefficients back = decode(hierarchy, code, 12);
  EXPECT_EQ(encode_coefficients(hierarchy, back, 12), code);
}

TEST(CoefficientCode, SurvivesAnyBytes) {
  std::mt19937_64 random(5);
  for (const test::Shape& shape : {test::octahedron(), test::cone(4), test::torus(3, 3)}) {
    const test::CodecBase base = test::base_of(shape);
    for (const unsigned levels : {0u, 1u, 3u}) {
      MemoryBudget budget(kMemory);
      const SubdivisionHierarchy hierarchy(base.vertices(), base.face, levels, budget);
      const store::Bytes code =
          encode_coefficients(hierarchy, random_coefficients(hierarchy, 12, 5, random), 12);
      for (unsigned round = 0; round < 150; ++round) {
        store::Bytes bytes = code;
        if (round % 3 == 0) {
          bytes.resize(random() % 2000);
          for (std::byte& b : bytes) b = static_cast<std::byte>(random());
        } else if (round % 3 == 1) {
          bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
        } else {
          bytes.assign(random() % 500, static_cast<std::byte>(random()));
        }
        const auto planes = static_cast<unsigned>(1 + random() % 30);
        const Coefficients any = decode(hierarchy, bytes, planes);
        for (std::uint32_t v = 0; v < hierarchy.vertices(); ++v) {
          for (unsigned c = 0; c < 3; ++c) {
            ASSERT_LT(any.magnitude[v][c], std::uint64_t{1} << planes);
            ASSERT_LE(any.plane[v][c], planes);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace remaps::codec
