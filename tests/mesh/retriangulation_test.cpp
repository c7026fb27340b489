#include "remaps/mesh/retriangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "support/random_records.h"

namespace remaps {
namespace {

void expect_same(const Retriangulation& a, const Retriangulation& b) {
  ASSERT_EQ(a.wedges, b.wedges);
  ASSERT_EQ(a.boundary, b.boundary);
  ASSERT_EQ(a.apex, b.apex);
  for (unsigned i = 0; i < a.wedges; ++i) {
    EXPECT_EQ(a.face[i], b.face[i]);
    EXPECT_EQ(a.turn[i], b.turn[i]);
  }
  for (unsigned i = 0; i < a.ring_size(); ++i) EXPECT_EQ(a.ring[i], b.ring[i]);
}

/// A record of any size that need not be valid in the plane: the log does not ask.
Retriangulation any_record(std::mt19937_64& random) {
  Retriangulation r;
  r.boundary = random() % 2 == 0;
  const unsigned least = r.boundary ? 2 : 3;
  r.wedges = static_cast<std::uint8_t>(least + random() % (kMaxStarFaces - least + 1));
  r.apex = static_cast<std::uint8_t>(random() % r.ring_size());
  for (unsigned i = 0; i < r.wedges; ++i) {
    r.face[i] = static_cast<LocalIndex>(random());
    r.turn[i] = static_cast<std::uint8_t>(random() % 3);
  }
  for (unsigned i = 0; i < r.ring_size(); ++i) {
    r.ring[i] = {static_cast<std::int16_t>(random() % 32767 - 16383),
                 static_cast<std::int16_t>(random() % 32767 - 16383)};
  }
  return r;
}

TEST(RetriangulationLog, ReadsBackWhatWasAppended) {
  constexpr std::uint64_t kSeed = 1;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  RetriangulationLog log;
  std::vector<Retriangulation> model;
  for (int i = 0; i < 500; ++i) {
    model.push_back(any_record(random));
    log.append(model.back());
  }
  ASSERT_EQ(log.size(), model.size());
  for (std::size_t r = 0; r < model.size(); ++r) {
    expect_same(log[r], model[r]);
    EXPECT_EQ(log.wedges(r), model[r].wedges);
    EXPECT_EQ(log.boundary(r), model[r].boundary);
    EXPECT_EQ(log.apex(r), model[r].apex);
    EXPECT_EQ(log.words()[log.face_offset(r) + 1], model[r].face[1]);
  }
  RetriangulationLog copy;
  ASSERT_TRUE(copy.assign({log.words().begin(), log.words().end()}));
  ASSERT_EQ(copy.size(), model.size());
  for (std::size_t r = 0; r < model.size(); ++r) expect_same(copy[r], model[r]);
  log.clear();
  EXPECT_TRUE(log.empty());
  EXPECT_TRUE(log.words().empty());
}

TEST(RetriangulationLog, RefusesWordsThatAreNotWholeRecords) {
  std::mt19937_64 random(2);
  RetriangulationLog log;
  for (int i = 0; i < 5; ++i) log.append(any_record(random));
  const std::vector<std::uint32_t> whole(log.words().begin(), log.words().end());
  std::vector<std::size_t> ends{0};
  for (std::size_t r = 1; r < log.size(); ++r) ends.push_back(log.face_offset(r) - 2);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    RetriangulationLog copy;
    const bool ends_a_record = std::find(ends.begin(), ends.end(), size) != ends.end();
    EXPECT_EQ(copy.assign({whole.begin(), whole.begin() + std::ptrdiff_t(size)}), ends_a_record);
    if (!ends_a_record) {
      EXPECT_TRUE(copy.empty());
    }
  }
}

TEST(RetriangulationLog, RefusesFirstWordsThatBreakTheFormat) {
  const auto accepts = [](std::uint32_t first) {
    std::vector<std::uint32_t> words(40, 0);
    words[0] = first;
    const unsigned k = first & 15u;
    words.resize(2 + k + k + ((first >> 4) & 1u));
    RetriangulationLog log;
    return log.assign(words);
  };
  EXPECT_TRUE(accepts(3));
  EXPECT_TRUE(accepts(2 | 16));
  EXPECT_TRUE(accepts(14 | 16 | 14 << 8));
  EXPECT_FALSE(accepts(0));
  EXPECT_FALSE(accepts(2)) << "an interior star of two triangles";
  EXPECT_FALSE(accepts(1 | 16)) << "a boundary star of one triangle";
  EXPECT_FALSE(accepts(15)) << "too many triangles";
  EXPECT_FALSE(accepts(3 | 3 << 8)) << "the apex is not on the ring";
  for (const unsigned bit : {5u, 6u, 7u, 12u, 20u, 31u}) {
    EXPECT_FALSE(accepts(3 | 1u << bit)) << "unused bit " << bit << " is set";
  }
}

TEST(RetriangulationLog, SurvivesGarbage) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<std::uint32_t> words(random() % 60);
    for (std::uint32_t& word : words)
      word = static_cast<std::uint32_t>(random() >> (random() % 64));
    RetriangulationLog log;
    if (!log.assign(words)) {
      ASSERT_TRUE(log.empty()) << "seed " << seed;
      continue;
    }
    std::size_t length = 0;
    for (std::size_t r = 0; r < log.size(); ++r) {
      const Retriangulation record = log[r];
      ASSERT_LE(record.ring_size(), kMaxRing) << "seed " << seed;
      ASSERT_LT(record.apex, record.ring_size()) << "seed " << seed;
      length += 2u + record.wedges + record.ring_size();
    }
    ASSERT_EQ(length, words.size()) << "seed " << seed;
  }
}

TEST(Retriangulation, NumbersTheCornersOfTheFan) {
  Retriangulation r;
  r.wedges = 5;
  r.apex = 3;
  EXPECT_EQ(r.ring_size(), 5u);
  EXPECT_EQ(r.triangles(), 3u);
  const unsigned expected[3][3] = {{3, 4, 0}, {3, 0, 1}, {3, 1, 2}};
  for (unsigned j = 0; j < 3; ++j)
    for (unsigned c = 0; c < 3; ++c) EXPECT_EQ(r.corner(j, c), expected[j][c]);
  EXPECT_EQ(r.next(4), 0u);
  EXPECT_EQ(r.next(2), 3u);
}

TEST(Retriangulation, GivesExactSignsHoweverNearTheLine) {
  // Against 128-bit integers, coordinates in units of 2^-40.
  std::mt19937_64 random(4);
  const auto coordinate = [&] { return static_cast<std::int16_t>(random() % 32767 - 16383); };
  __extension__ using Wide = __int128;
  const auto in_units = [](double x) {  // exact: x is a multiple of 2^-40 here
    return static_cast<Wide>(std::ldexp(x, 40));
  };
  int zero = 0;
  int near = 0;
  for (int i = 0; i < 50'000; ++i) {
    const GridPoint a{coordinate(), coordinate()};
    const GridPoint b{coordinate(), coordinate()};
    const double t = double(random() % 4096) / 4096;
    // On the line, or off by a few units of 2^-38: far below what plain doubles tell apart.
    const double off = std::ldexp(double(static_cast<int>(random() % 5) - 2), -38);
    const PlanarPoint p = planar_point(a.x + t * (b.x - a.x) + off, a.y + t * (b.y - a.y));
    const Wide exact = (b.x - a.x) * (in_units(p.y) - in_units(a.y)) -
                       (b.y - a.y) * (in_units(p.x) - in_units(a.x));
    const double got = orientation(a, b, p);
    ASSERT_EQ((got > 0) - (got < 0), (exact > 0) - (exact < 0));
    zero += exact == 0;
    near += exact != 0 && std::abs(got) < 1e-6;
    const GridPoint c{coordinate(), coordinate()};
    ASSERT_EQ(double(orientation(a, b, c)),
              orientation(a, b, PlanarPoint{double(c.x), double(c.y)}));
    ASSERT_EQ(orientation(a, b), orientation(GridPoint{}, a, b));
  }
  EXPECT_GT(zero, 1000);
  EXPECT_GT(near, 1000);
}

TEST(Retriangulation, CountsTinyCoordinatesAsZero) {
  EXPECT_EQ(planar_point(0x1p-31, -0x1p-31).x, 0);
  EXPECT_EQ(planar_point(0x1p-31, -0x1p-31).y, 0);
  EXPECT_EQ(planar_point(0x1p-30, 1).x, 0x1p-30);
}

}  // namespace
}  // namespace remaps
