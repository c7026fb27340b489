#include "remaps/resample/resampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "remaps/base/errors.h"
#include "support/simplified_shape.h"
#include "support/temp_files.h"

namespace remaps::resample {
namespace {

using map::FacePoint;
using map::SegmentMap;
using map::TaggedPoint;

/// A map of one level and one segment, on disk as a bundle has it.
class ResamplerTest : public test::TempFiles {
 protected:
  ResamplerTest() : shape_(test::scan_shapes()[0]) {
    simplified_ = test::simplify_shape(shape_, test::simplify_options(50));
    const SegmentLog log = test::segment_log_of(simplified_, 0);
    {
      store::SectionFileWriter writer(directory() / "log", kLogKind);
      writer.append(store::pack_section(encode_records(log)));
      writer.append(store::pack_section(encode_survivors(log)));
      writer.seal();
    }
    Tile tile;
    tile.own_vertices = simplified_.segment.own_vertices;
    tile.vertex_id = simplified_.segment.vertex_id;
    tile.position = simplified_.segment.position;
    tile.triangle.assign(shape_.triangle.begin(), shape_.triangle.end());
    tile.face_id = simplified_.segment.face_id;
    {
      store::SectionFileWriter writer(directory() / "tiles", kTileKind);
      writer.append(store::pack_section(encode_tile(tile)));
      writer.seal();
    }
    for (const LocalIndex f : log.survivor) base_.push_back(simplified_.patch.face(f));
    options_.temp_dir = directory() / "temp";
    options_.buffer_bytes = 1 << 20;
    std::filesystem::create_directory(options_.temp_dir);
    log_.emplace(directory() / "log", kLogKind);
    tiles_.emplace(directory() / "tiles", kTileKind);
  }
  MapFiles files() const { return {{&*log_}, &*tiles_}; }
  /// The base with its vertices numbered from 0, as a bundle has it.
  std::vector<DyadicGrid::BaseTriangle> base_numbered() const {
    std::map<LocalIndex, std::uint32_t> number;
    std::vector<DyadicGrid::BaseTriangle> base;
    for (const LocalTriangle& t : base_) {
      auto& face = base.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) {
        face[i] = number.try_emplace(t[i], static_cast<std::uint32_t>(number.size())).first->second;
      }
    }
    return base;
  }
  std::size_t base_vertices() const {
    std::size_t highest = 0;
    for (const auto& t : base_numbered())
      highest = std::max<std::size_t>(highest, std::max({t[0], t[1], t[2]}));
    return highest + 1;
  }

  test::Shape shape_;
  test::SimplifiedShape simplified_;
  std::vector<LocalTriangle> base_;
  ResampleOptions options_;
  std::optional<store::SectionFile> log_, tiles_;
  MemoryBudget budget_{std::uint64_t{64} << 20};
};

TEST_F(ResamplerTest, PullsPointsBackAsTheLogSays) {
  std::mt19937_64 random(1);
  std::map<std::uint64_t, FacePoint> asked;
  for (std::uint64_t tag = 0; tag < 2000; ++tag) {
    const double u = double(random() % 1000) / 1000;
    asked[tag * 7] = {static_cast<LocalIndex>(random() % base_.size()), u, (1 - u) * 0.4};
  }
  SegmentMap inverse;
  inverse.build(simplified_.log, shape_.triangle.size(), SegmentMap::Direction::kInverse);
  const SegmentLog log = test::segment_log_of(simplified_, 0);
  for (const unsigned threads : {1u, 3u}) {
    options_.carry.threads = threads;
    options_.carry.map_buffer = 100;
    std::size_t answers = 0;
    pull_back(
        files(),
        [&](const auto& add) {
          for (const auto& [tag, p] : asked) add({tag, p});
        },
        options_, budget_,
        [&](std::uint32_t number, const Tile& tile, std::span<const TaggedPoint> points) {
          EXPECT_EQ(number, 0u);
          EXPECT_EQ(tile.triangle.size(), shape_.triangle.size());
          for (const TaggedPoint& point : points) {
            FacePoint expected = asked.at(point.tag);
            expected.face = log.survivor[expected.face];
            inverse.carry({&expected, 1});
            EXPECT_EQ(point.at, expected);
            ++answers;
          }
        });
    EXPECT_EQ(answers, asked.size());
    EXPECT_EQ(entries_in(options_.temp_dir), 0u) << "temporary files are left";
  }
}

TEST_F(ResamplerTest, RefusesABaseFaceThatIsNot) {
  const auto ask = [&](const auto& add) {
    add({0, {static_cast<LocalIndex>(base_.size()), 0, 0}});
  };
  const auto sink = [](std::uint32_t, const Tile&, std::span<const TaggedPoint>) {};
  EXPECT_THROW(pull_back(files(), ask, options_, budget_, sink), GeometryError);
}

/// Through many blocks on disk, and on several threads: the same positions as one by one.
TEST_F(ResamplerTest, SendsThePositionsOfAGridInItsOrder) {
  const DyadicGrid grid(narrow<std::uint32_t>(base_vertices()), base_numbered(), 6);
  std::vector<Vec3> expected(grid.vertices());
  std::vector<TaggedPoint> samples(grid.vertices());
  grid.samples(0, samples);
  pull_back(
      files(),
      [&](const auto& add) {
        for (const TaggedPoint& sample : samples) add(sample);
      },
      options_, budget_,
      [&](std::uint32_t, const Tile& tile, std::span<const TaggedPoint> points) {
        for (const TaggedPoint& p : points) expected[p.tag] = position_on_tile(tile, p.at);
      });
  options_.origin = {1000, -2000, 0.125};
  for (const bool as_floats : {false, true}) {
    for (const unsigned threads : {1u, 3u}) {
      options_.as_floats = as_floats;
      options_.carry.threads = threads;
      options_.carry.map_buffer = 1000;
      options_.buffer_bytes = 64 << 10;
      std::vector<Vec3> sent;
      resample_positions(files(), grid, options_, budget_, [&](std::span<const Vec3> part) {
        sent.insert(sent.end(), part.begin(), part.end());
      });
      ASSERT_EQ(sent.size(), expected.size());
      for (std::size_t i = 0; i < sent.size(); ++i) {
        const Vec3 exact = options_.origin + expected[i];
        ASSERT_EQ(sent[i], as_floats ? widen(to_float(exact)) : exact);
      }
      EXPECT_EQ(entries_in(options_.temp_dir), 0u) << "temporary files are left";
    }
  }
}

TEST_F(ResamplerTest, SendsTheFacesOfAGridInItsOrder) {
  const DyadicGrid grid(narrow<std::uint32_t>(base_vertices()), base_numbered(), 5);
  std::uint64_t faces = 0;
  stream_faces(grid, nullptr, [&](std::span<const Triangle> part) {
    for (const Triangle& t : part) ASSERT_EQ(t, grid.triangle(faces++));
  });
  EXPECT_EQ(faces, grid.faces());
}

TEST_F(ResamplerTest, RefusesABudgetThatTheLargestSegmentDoesNotFit) {
  const DyadicGrid grid(narrow<std::uint32_t>(base_vertices()), base_numbered(), 1);
  MemoryBudget budget(100 << 10);
  const auto sink = [](std::span<const Vec3>) { ADD_FAILURE() << "positions were sent"; };
  EXPECT_THROW(resample_positions(files(), grid, options_, budget, sink), BudgetError);
  EXPECT_EQ(budget.available(), budget.total());
}

/// Tags have 40 bits on disk.
TEST_F(ResamplerTest, RefusesMoreVerticesThanTagsCanTell) {
  const DyadicGrid grid(narrow<std::uint32_t>(base_vertices()), base_numbered(), 18);
  ASSERT_GT(grid.vertices(), store::kMaxId40);
  const auto sink = [](std::span<const Vec3>) { ADD_FAILURE() << "positions were sent"; };
  EXPECT_THROW(resample_positions(files(), grid, options_, budget_, sink), BudgetError);
}

TEST_F(ResamplerTest, StopsWhenCancelled) {
  Progress progress;
  progress.cancel();
  options_.carry.progress = &progress;
  const auto ask = [&](const auto& add) { add({0, {0, 0, 0}}); };
  const auto sink = [](std::uint32_t, const Tile&, std::span<const TaggedPoint>) {
    FAIL() << "answered";
  };
  EXPECT_THROW(pull_back(files(), ask, options_, budget_, sink), Cancelled);
}

TEST(PositionOnTile, WeighsTheCornersInTheirOrder) {
  Tile tile;
  tile.position = {{0, 0, 0}, {4, 0, 0}, {0, 8, 0}, {0, 0, 16}};
  tile.triangle = {{0, 1, 2}, {3, 2, 1}};
  EXPECT_EQ(position_on_tile(tile, {0, 0, 0}), (Vec3{0, 0, 0}));
  EXPECT_EQ(position_on_tile(tile, {0, 1, 0}), (Vec3{4, 0, 0}));
  EXPECT_EQ(position_on_tile(tile, {0, 0, 1}), (Vec3{0, 8, 0}));
  EXPECT_EQ(position_on_tile(tile, {1, 0.25, 0.5}), (Vec3{2, 2, 4}));
}

TEST(PositionOnTile, IsExactAtEveryCorner) {
  Tile tile;
  tile.position = {{1e6f, 0.1f, -3e-9f}, {1e-20f, -7e5f, 0.3f}, {0.7f, 1e-17f, 1e7f}};
  tile.triangle = {{0, 1, 2}};
  EXPECT_EQ(position_on_tile(tile, {0, 0, 0}), widen(tile.position[0]));
  EXPECT_EQ(position_on_tile(tile, {0, 1, 0}), widen(tile.position[1]));
  EXPECT_EQ(position_on_tile(tile, {0, 0, 1}), widen(tile.position[2]));
}

}  // namespace
}  // namespace remaps::resample
