#include "remaps/map/level_map.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/map/base_carrier.h"
#include "support/simplified_shape.h"
#include "support/temp_files.h"

namespace remaps::map {
namespace {

using Direction = SegmentMap::Direction;

struct Sent {
  FaceLink link;
  std::uint64_t tag;
  FacePoint at;

  friend bool operator==(const Sent&, const Sent&) = default;
};

/// A level of three segments, each a scan of its own.
class LevelMapTest : public test::TempFiles {
 protected:
  static constexpr std::uint32_t kNext = 4;

  LevelMapTest() {
    const std::vector<test::Shape> shapes = test::scan_shapes();
    store::SectionFileWriter writer(path(), kLogKind);
    for (const std::size_t i : {0u, 2u, 4u}) {
      const auto simplified = test::simplify_shape(shapes[i], test::simplify_options(100));
      log_.push_back(test::segment_log_of(simplified, kNext));
      writer.append(store::pack_section(encode_records(log_.back())));
      writer.append(store::pack_section(encode_survivors(log_.back())));
    }
    writer.seal();
  }
  std::filesystem::path path() const { return directory() / "log-0.bin"; }

  /// The same through SegmentMap alone.
  Sent carried(std::size_t segment, std::uint64_t tag, FacePoint p) const {
    SegmentMap map;
    map.build(log_[segment].records, log_[segment].faces, Direction::kForward);
    map.carry({&p, 1});
    const auto& survivor = log_[segment].survivor;
    const auto at = std::lower_bound(survivor.begin(), survivor.end(), p.face) - survivor.begin();
    const FaceLink link = log_[segment].next[static_cast<std::size_t>(at)];
    p.face = link.face;
    return {link, tag, p};
  }
  std::vector<Sent> carry(const LevelMap& level, Direction direction, PointBuckets& in,
                          unsigned threads, std::size_t map_buffer) const {
    std::vector<Sent> sent;
    CarryOptions options;
    options.threads = threads;
    options.map_buffer = map_buffer;
    carry_points(level, direction, in, options, [&](const FaceLink& link, const TaggedPoint& p) {
      sent.push_back({link, p.tag, p.at});
    });
    return sent;
  }
  void fill(PointBuckets& buckets, std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    for (std::uint64_t tag = 0; tag < 3000; ++tag) {
      const std::size_t segment = random() % log_.size();
      const auto face = static_cast<LocalIndex>(random() % log_[segment].faces);
      const double u = double(random() % 1000) / 1000;
      buckets.add(segment, {tag, {face, u, (1 - u) * 0.3}});
    }
  }

  std::vector<SegmentLog> log_;
  MemoryBudget budget_{std::uint64_t{64} << 20};
};

TEST_F(LevelMapTest, CarriesPointsOfAllSegmentsAsTheirLogsSay) {
  const store::SectionFile file(path(), kLogKind);
  const LevelMap level(file);
  EXPECT_EQ(level.segments(), 3u);
  std::vector<Sent> first;
  for (const unsigned threads : {1u, 2u, 4u}) {
    for (const std::size_t map_buffer : {7u, 100u, 1'000'000u}) {
      PointBuckets in(directory() / "points", 3, 1 << 16, budget_);
      fill(in, 1);
      const std::vector<Sent> sent = carry(level, Direction::kForward, in, threads, map_buffer);
      if (first.empty()) first = sent;
      EXPECT_EQ(sent, first) << threads << " threads, map buffer " << map_buffer;
      for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(in.count(i), 0u) << "not released";
    }
  }
  ASSERT_EQ(first.size(), 3000u);
  PointBuckets in(directory() / "points", 3, 1 << 16, budget_);
  fill(in, 1);
  std::size_t at = 0;
  for (std::size_t segment = 0; segment < 3; ++segment) {
    std::vector<TaggedPoint> points;
    in.read(segment, 0, in.count(segment), points);
    for (std::size_t i = 0; i < points.size(); i += 20) {
      EXPECT_EQ(first[at + i], carried(segment, points[i].tag, points[i].at));
    }
    at += points.size();
  }
}

TEST_F(LevelMapTest, CarriesPointsBack) {
  const store::SectionFile file(path(), kLogKind);
  const LevelMap level(file);
  PointBuckets in(directory() / "points", 3, 1 << 16, budget_);
  fill(in, 2);
  std::vector<std::vector<TaggedPoint>> start(3);
  std::map<std::uint64_t, std::size_t> segment_of;
  for (std::size_t s = 0; s < 3; ++s) {
    in.read(s, 0, in.count(s), start[s]);
    for (const TaggedPoint& p : start[s]) segment_of[p.tag] = s;
  }
  // Where a face of the next level was before.
  std::map<std::pair<std::uint64_t, std::pair<std::uint32_t, LocalIndex>>, LocalIndex> before;
  for (std::size_t s = 0; s < 3; ++s) {
    for (std::size_t i = 0; i < log_[s].survivor.size(); ++i) {
      before[{s, {log_[s].next[i].segment, log_[s].next[i].face}}] = log_[s].survivor[i];
    }
  }
  PointBuckets back(directory() / "back", 3, 1 << 16, budget_);
  for (const Sent& s : carry(level, Direction::kForward, in, 2, 50)) {
    const std::size_t segment = segment_of.at(s.tag);
    const LocalIndex face = before.at({segment, {s.link.segment, s.link.face}});
    back.add(segment, {s.tag, {face, s.at.u, s.at.v}});
  }
  std::map<std::uint64_t, Sent> returned;
  for (const Sent& s : carry(level, Direction::kInverse, back, 2, 50)) returned[s.tag] = s;
  ASSERT_EQ(returned.size(), 3000u);
  std::size_t same_face = 0;
  for (std::size_t s = 0; s < 3; ++s) {
    for (const TaggedPoint& p : start[s]) {
      const Sent& end = returned.at(p.tag);
      EXPECT_EQ(end.link.segment, s);
      EXPECT_EQ(end.link.face, end.at.face);
      if (end.at.face != p.at.face) continue;  // a point of an edge may come back on either side
      ++same_face;
      EXPECT_NEAR(end.at.u, p.at.u, 1e-5);
      EXPECT_NEAR(end.at.v, p.at.v, 1e-5);
    }
  }
  EXPECT_GT(same_face, 2950u);
}

TEST_F(LevelMapTest, SendsEveryRemovedVertexOnce) {
  const store::SectionFile file(path(), kLogKind);
  const store::SectionFile* const files[] = {&file};
  std::vector<TaggedPoint> first;
  for (const unsigned threads : {1u, 3u}) {
    CarryOptions options;
    options.threads = threads;
    std::vector<TaggedPoint> sent;
    BaseCarrier(files, 1 << 20, budget_)
        .carry_removed(options, [&](VertexId vertex, const FacePoint& at) {
          sent.push_back({vertex, at});
        });
    if (!first.empty()) {
      ASSERT_EQ(sent.size(), first.size());
    }
    for (std::size_t i = 0; i < first.size(); ++i) {
      ASSERT_EQ(sent[i].tag, first[i].tag);
      ASSERT_EQ(sent[i].at, first[i].at);
    }
    first = sent;
  }
  std::size_t at = 0;
  for (std::size_t s = 0; s < 3; ++s) {
    const RetriangulationLog& records = log_[s].records;
    // A vertex starts as a corner of the first face of the record that removed it.
    for (std::size_t r = 0; r < records.size(); ++r, ++at) {
      ASSERT_EQ(first[at].tag, log_[s].removed[r]);
      ASSERT_GE(first[at].at.u, 0);
      ASSERT_GE(first[at].at.v, 0);
      ASSERT_LE(first[at].at.u + first[at].at.v, 1 + 1e-15);
    }
  }
  EXPECT_EQ(at, first.size());
}

TEST_F(LevelMapTest, RefusesDamagedSectionsAndPointsOnFacesThatAreNot) {
  const std::string whole = bytes_of(path());
  std::mt19937_64 random(5);
  for (int i = 0; i < 40; ++i) {
    std::string damaged = whole;
    damaged[16 + random() % (whole.size() - 16)] ^= 4;
    make_file("log-0.bin", damaged);
    const auto load_all = [&] {
      const store::SectionFile file(path(), kLogKind);
      const LevelMap level(file);
      for (std::size_t s = 0; s < level.segments(); ++s) level.load(s, Direction::kForward);
    };
    EXPECT_THROW(load_all(), CorruptionError);
  }
  make_file("log-0.bin", whole);
  const store::SectionFile file(path(), kLogKind);
  for (const auto direction : {Direction::kForward, Direction::kInverse}) {
    PointBuckets in(directory() / "points", 3, 1 << 16, budget_);
    in.add(1, {0, {log_[1].faces, 0.1, 0.1}});
    EXPECT_THROW(carry(LevelMap(file), direction, in, 2, 100), CorruptionError);
  }
}

TEST_F(LevelMapTest, StopsWhenCancelled) {
  const store::SectionFile file(path(), kLogKind);
  const LevelMap level(file);
  Progress progress;
  progress.cancel();
  CarryOptions options;
  options.threads = 2;
  options.progress = &progress;
  PointBuckets in(directory() / "points", 3, 1 << 16, budget_);
  fill(in, 3);
  const auto nothing = [](const FaceLink&, const TaggedPoint&) { FAIL() << "sent"; };
  EXPECT_THROW(carry_points(level, Direction::kForward, in, options, nothing), Cancelled);
  const store::SectionFile* const files[] = {&file};
  BaseCarrier carrier(files, 1 << 20, budget_);
  EXPECT_THROW(carrier.carry_removed(options, [](VertexId, const FacePoint&) { FAIL() << "sent"; }),
               Cancelled);
}

class PointBucketsTest : public test::TempFiles {};

TEST_F(PointBucketsTest, ReadsBackPiecesExactly) {
  MemoryBudget budget(1 << 20);
  PointBuckets buckets(directory() / "points", 5, 1 << 12, budget);
  std::mt19937_64 random(1);
  std::vector<std::vector<TaggedPoint>> model(5);
  for (int i = 0; i < 2000; ++i) {
    const TaggedPoint p{random() >> 24,
                        {static_cast<LocalIndex>(random()), 1.0 / double(1 + random() % 99),
                         std::nextafter(double(random() % 7) / 7, 2)}};
    const std::size_t segment = random() % 4;
    model[segment].push_back(p);
    buckets.add(segment, p);
  }
  EXPECT_EQ(buckets.count(4), 0u);
  std::vector<TaggedPoint> out;
  for (std::size_t s = 0; s < 4; ++s) {
    ASSERT_EQ(buckets.count(s), model[s].size());
    for (std::size_t first = 0; first < model[s].size(); first += 77) {
      const std::size_t n = std::min<std::size_t>(77, model[s].size() - first);
      buckets.read(s, first, n, out);
      ASSERT_EQ(out.size(), n);
      for (std::size_t i = 0; i < n; ++i) {
        ASSERT_EQ(out[i].tag, model[s][first + i].tag);
        ASSERT_EQ(out[i].at, model[s][first + i].at);
      }
    }
    buckets.release(s);
    EXPECT_EQ(buckets.count(s), 0u);
  }
}

}  // namespace
}  // namespace remaps::map
