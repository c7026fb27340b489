#include "remaps/mesh/segment_log.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>

#include "remaps/base/errors.h"
#include "support/random_records.h"

namespace remaps {
namespace {

using store::Bytes;

Tile random_tile(std::mt19937_64& random) {
  Tile tile;
  const auto vertices = static_cast<LocalIndex>(3 + random() % 60);
  tile.own_vertices = static_cast<LocalIndex>(random() % (vertices + 1));
  for (LocalIndex v = 0; v < vertices; ++v) {
    tile.vertex_id.push_back(random() >> 25);
    tile.position.push_back({static_cast<float>(random() % 1000), -1.5f, static_cast<float>(v)});
  }
  for (std::size_t f = random() % 90; f > 0; --f) {
    tile.triangle.push_back({static_cast<LocalIndex>(random() % vertices),
                             static_cast<LocalIndex>(random() % vertices),
                             static_cast<LocalIndex>(random() % vertices)});
    tile.face_id.push_back(random() >> 25);
  }
  return tile;
}

void expect_same(const RetriangulationLog& a, const RetriangulationLog& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_TRUE(std::equal(a.words().begin(), a.words().end(), b.words().begin(), b.words().end()));
}

/// Decodes damaged bytes: either they are refused as corrupt, or they still make sense.
void expect_refused_or_read(const Bytes& bytes, const std::function<void(const Bytes&)>& decode) {
  const Bytes own_copy(bytes.begin(), bytes.end());
  try {
    decode(own_copy);
  } catch (const CorruptionError& error) {
    EXPECT_NE(std::string(error.what()), "");
  }
}

void damage_everywhere(const Bytes& whole, std::uint64_t seed,
                       const std::function<void(const Bytes&)>& decode) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes part(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    EXPECT_THROW(decode(part), CorruptionError) << size << " of " << whole.size() << " bytes";
  }
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_THROW(decode(longer), CorruptionError);
  for (int i = 0; i < 3000; ++i) {
    Bytes damaged = whole;
    for (std::size_t n = 1 + random() % 4; n > 0; --n) {
      damaged[random() % damaged.size()] = static_cast<std::byte>(random());
    }
    if (i % 7 == 0) damaged.resize(random() % damaged.size());
    expect_refused_or_read(damaged, decode);
  }
  for (int i = 0; i < 300; ++i) {
    Bytes garbage(random() % 100);
    for (std::byte& b : garbage) b = static_cast<std::byte>(random() >> (random() % 64));
    expect_refused_or_read(garbage, decode);
  }
}

class SegmentLogTest : public testing::TestWithParam<unsigned> {};

TEST_P(SegmentLogTest, DecodesWhatWasEncoded) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const SegmentLog log = test::random_segment_log(random, GetParam(), random() % 40);
    SegmentLog back = test::random_segment_log(random, 1, 3);  // what was there before goes
    decode_records(encode_records(log), "log", back);
    decode_survivors(encode_survivors(log), "log", back);
    EXPECT_EQ(back.level, log.level);
    EXPECT_EQ(back.faces, log.faces);
    EXPECT_EQ(back.origin, log.origin);
    EXPECT_EQ(back.removed, log.removed);
    EXPECT_EQ(back.survivor, log.survivor);
    EXPECT_EQ(back.next, log.next);
    expect_same(back.records, log.records);
  }
}

TEST_P(SegmentLogTest, RefusesDamagedRecordsOrReadsThem) {
  std::mt19937_64 random(8);
  SegmentLog log = test::random_segment_log(random, GetParam(), 6);
  damage_everywhere(encode_records(log), 80, [&](const Bytes& bytes) {
    SegmentLog back;
    decode_records(bytes, "log", back);
    for (std::size_t r = 0; r < back.records.size(); ++r) {
      for (unsigned i = 0; i < back.records.wedges(r); ++i) {
        EXPECT_LT(back.records.face(r, i), back.faces);
        EXPECT_LE(back.records.turn(r, i), 2u);
      }
    }
    EXPECT_EQ(back.removed.size(), back.records.size());
    EXPECT_EQ(back.origin.size(), back.level == 0 ? 0u : back.faces);
  });
}

TEST_P(SegmentLogTest, RefusesDamagedSurvivorsOrReadsThem) {
  std::mt19937_64 random(9);
  const SegmentLog log = test::random_segment_log(random, GetParam(), 2);
  damage_everywhere(encode_survivors(log), 90, [&](const Bytes& bytes) {
    SegmentLog back;
    back.faces = log.faces;
    decode_survivors(bytes, "log", back);
    EXPECT_EQ(back.next.size(), back.survivor.size());
    for (const LocalIndex f : back.survivor) EXPECT_LT(f, back.faces);
  });
}

INSTANTIATE_TEST_SUITE_P(Levels, SegmentLogTest, testing::Values(0u, 1u, 5u));

TEST(SegmentLog, NamesTheFileInItsRefusals) {
  SegmentLog log;
  try {
    decode_records(Bytes(3), "a/log-0.bin: segment 7", log);
    FAIL() << "decoded";
  } catch (const CorruptionError& error) {
    EXPECT_NE(std::string(error.what()).find("log-0.bin: segment 7"), std::string::npos);
  }
}

TEST(SegmentLog, RefusesFacesThatTheSegmentDoesNotHave) {
  std::mt19937_64 random(10);
  SegmentLog log = test::random_segment_log(random, 0, 4);
  const LocalIndex named = log.records.face(2, 1);
  log.faces = named;
  SegmentLog back;
  EXPECT_THROW(decode_records(encode_records(log), "log", back), CorruptionError);
  SegmentLog survivors;
  survivors.faces = 4;
  survivors.survivor = {1, 4};
  survivors.next.resize(2);
  back.faces = 4;
  EXPECT_THROW(decode_survivors(encode_survivors(survivors), "log", back), CorruptionError);
  survivors.survivor = {3, 2};
  EXPECT_THROW(decode_survivors(encode_survivors(survivors), "log", back), CorruptionError);
  survivors.survivor = {2, 3};
  EXPECT_NO_THROW(decode_survivors(encode_survivors(survivors), "log", back));
}

TEST(Tile, DecodesWhatWasEncoded) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Tile tile = random_tile(random);
    Tile back = random_tile(random);
    decode_tile(encode_tile(tile), "tile", back);
    EXPECT_EQ(back.own_vertices, tile.own_vertices);
    EXPECT_EQ(back.vertex_id, tile.vertex_id);
    EXPECT_EQ(back.position, tile.position);
    EXPECT_EQ(back.triangle, tile.triangle);
    EXPECT_EQ(back.face_id, tile.face_id);
    decode_tile_surface(encode_tile(tile), "tile", back);
    EXPECT_EQ(back.own_vertices, tile.own_vertices);
    EXPECT_EQ(back.position, tile.position);
    EXPECT_EQ(back.triangle, tile.triangle);
    EXPECT_TRUE(back.vertex_id.empty() && back.face_id.empty());
  }
  Tile empty;
  decode_tile(encode_tile({}), "tile", empty);
  EXPECT_TRUE(empty.triangle.empty());
}

TEST(Tile, RefusesADamagedSurfaceOrReadsIt) {
  std::mt19937_64 random(13);
  Bytes whole = encode_tile(random_tile(random));
  for (int i = 0; i < 3000; ++i) {
    Bytes bytes = whole;
    bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    bytes.resize(bytes.size() - random() % 3 * (random() % bytes.size()) / 2);
    expect_refused_or_read(bytes, [](const Bytes& damaged) {
      Tile back;
      decode_tile_surface(damaged, "tile", back);
      for (const auto& t : back.triangle) {
        for (const LocalIndex v : t) EXPECT_LT(v, back.position.size());
      }
    });
  }
}

TEST(Tile, RefusesDamageOrReadsIt) {
  std::mt19937_64 random(12);
  damage_everywhere(encode_tile(random_tile(random)), 120, [&](const Bytes& bytes) {
    Tile back;
    decode_tile(bytes, "tile", back);
    EXPECT_LE(back.own_vertices, back.position.size());
    EXPECT_EQ(back.vertex_id.size(), back.position.size());
    EXPECT_EQ(back.face_id.size(), back.triangle.size());
    for (const auto& t : back.triangle) {
      for (const LocalIndex v : t) EXPECT_LT(v, back.position.size());
    }
  });
}

}  // namespace
}  // namespace remaps
