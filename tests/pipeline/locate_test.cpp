#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "pipeline/test_bundles.h"
#include "remaps/store/file.h"
#include "support/temp_files.h"

namespace remaps::test {
namespace {

using pipeline::BasePoint;
using pipeline::InputPoint;
using pipeline::Location;

class Locate : public TempFiles {
 protected:
  void make(BaseShape shape, std::size_t unused = 0) {
    made_ = make_test_bundle(directory(), shape, 20'000, 4'000, unused);
    diagonal_ = pipeline::Bundle(made_.bundle).manifest().diagonal;
    base_faces_ = pipeline::Bundle(made_.bundle).base().triangle.size();
  }
  std::vector<Location> vertices(const std::vector<VertexId>& asked, unsigned threads = 1) {
    return pipeline::locate_vertices(query_options(made_.bundle, threads), asked, progress_);
  }
  std::vector<Location> base_points(const std::vector<BasePoint>& asked, unsigned threads = 1) {
    return pipeline::locate_base_points(query_options(made_.bundle, threads), asked, progress_);
  }
  std::vector<Location> input_points(const std::vector<InputPoint>& asked, unsigned threads = 1) {
    return pipeline::locate_input_points(query_options(made_.bundle, threads), asked, progress_);
  }

  std::vector<BasePoint> random_base_points(std::size_t n) {
    std::vector<BasePoint> points;
    for (std::size_t i = 0; i < n; ++i) {
      const auto [u, v] = random_weights();
      points.push_back({static_cast<std::uint32_t>(random_() % base_faces_), u, v});
    }
    return points;
  }
  std::pair<double, double> random_weights() {
    std::uniform_real_distribution<double> unit(0, 1);
    const double u = unit(random_);
    const double v = unit(random_);
    return u + v > 1 ? std::pair{1 - u, 1 - v} : std::pair{u, v};
  }
  /// A point of an input face, from the mesh itself.
  Vec3 on_input(const InputPoint& p) const {
    const Triangle& t = made_.triangles[p.face];
    const Vec3& a = made_.positions[t[0]];
    return a + p.u * (made_.positions[t[1]] - a) + p.v * (made_.positions[t[2]] - a);
  }
  void expect_same(const std::vector<Location>& a, const std::vector<Location>& b) const {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].position, b[i].position);
      EXPECT_EQ(a[i].base_position, b[i].base_position);
      EXPECT_EQ(a[i].input.face, b[i].input.face);
      EXPECT_EQ(a[i].base.face, b[i].base.face);
    }
  }

  TestBundle made_;
  double diagonal_ = 0;
  std::size_t base_faces_ = 0;
  std::mt19937_64 random_{11};
  Progress progress_;
};

TEST_F(Locate, BasePointsComeBackFromTheInput) {
  for (const BaseShape shape : {BaseShape::kIcosahedron, BaseShape::kTorus, BaseShape::kDisk}) {
    make(shape);
    const std::vector<BasePoint> asked = random_base_points(3'000);
    const std::vector<Location> there = base_points(asked);
    std::vector<InputPoint> input;
    for (const Location& l : there) input.push_back(l.input);
    const std::vector<Location> back = input_points(input);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      EXPECT_EQ(there[i].base.face, asked[i].face);
      EXPECT_LT(norm(on_input(there[i].input) - there[i].position), 1e-12 * diagonal_);
      EXPECT_EQ(there[i].input.vertex, made_.triangles[there[i].input.face]);
      EXPECT_LT(norm(back[i].base_position - there[i].base_position), 1e-9 * diagonal_);
      EXPECT_LT(norm(back[i].position - there[i].position), 1e-12 * diagonal_);
    }
    std::filesystem::remove_all(made_.bundle);
  }
}

TEST_F(Locate, InputPointsComeBackFromTheBase) {
  make(BaseShape::kDisk);
  std::vector<InputPoint> asked;
  for (int i = 0; i < 3'000; ++i) {
    const auto [u, v] = random_weights();
    asked.push_back({random_() % made_.triangles.size(), u, v, {}});
  }
  const std::vector<Location> there = input_points(asked);
  std::vector<BasePoint> base;
  for (const Location& l : there) base.push_back(l.base);
  const std::vector<Location> back = base_points(base);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_EQ(there[i].input.face, asked[i].face);
    EXPECT_LT(norm(there[i].position - on_input(asked[i])), 1e-12 * diagonal_);
    EXPECT_LT(norm(back[i].position - there[i].position), 1e-9 * diagonal_);
  }
}

TEST_F(Locate, VerticesAreWhereTheInputHasThem) {
  make(BaseShape::kTorus, /*unused=*/2);
  std::vector<VertexId> asked;
  for (int i = 0; i < 2'000; ++i) asked.push_back(2 + random_() % (made_.positions.size() - 2));
  const std::vector<Location> found = vertices(asked);
  std::size_t exact = 0;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_LT(norm(found[i].position - made_.positions[asked[i]]), 1e-6 * diagonal_);
    exact += norm(found[i].position - made_.positions[asked[i]]) < 1e-15 * diagonal_;
  }
  EXPECT_GT(exact, asked.size() * 998 / 1000);
  EXPECT_THROW(vertices({1}), GeometryError);
  EXPECT_THROW(vertices({made_.positions.size()}), InputError);
}

TEST_F(Locate, AnswersInTheOrderAskedWithAnyThreads) {
  make(BaseShape::kIcosahedron);
  std::vector<BasePoint> asked = random_base_points(500);
  asked.push_back(asked.front());
  const std::vector<Location> found = base_points(asked, 1);
  expect_same(found, base_points(asked, 2));
  expect_same({found.front()}, {found.back()});

  std::vector<InputPoint> input;
  std::vector<VertexId> corners;
  for (const Location& l : found) {
    input.push_back(l.input);
    corners.push_back(l.input.vertex[0]);
  }
  expect_same(input_points(input, 1), input_points(input, 2));
  expect_same(vertices(corners, 1), vertices(corners, 2));
  EXPECT_TRUE(base_points({}).empty());
  EXPECT_TRUE(input_points({}).empty());
  EXPECT_TRUE(vertices({}).empty());
}

TEST_F(Locate, RefusesPointsThatAreNotOnTheSurface) {
  make(BaseShape::kIcosahedron);
  const auto faces = static_cast<std::uint32_t>(base_faces_);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(base_points({{faces, 0.1, 0.1}}), InputError);
  EXPECT_THROW(base_points({{0, 0.6, 0.6}}), InputError);
  EXPECT_THROW(base_points({{0, -0.1, 0.6}}), InputError);
  EXPECT_THROW(base_points({{0, nan, 0}}), InputError);
  EXPECT_THROW(input_points({{made_.triangles.size(), 0, 0, {}}}), InputError);
  EXPECT_THROW(input_points({{0, 1.5, 0, {}}}), InputError);
  EXPECT_NO_THROW(base_points({{0, 1 + 1e-9, -1e-9}}));
}

TEST_F(Locate, OneBasePointReadsOneSegmentALevel) {
  make(BaseShape::kIcosahedron);
  const pipeline::Bundle bundle(made_.bundle);
  std::uint64_t all = std::filesystem::file_size(made_.bundle / pipeline::kTilesName);
  for (std::size_t l = 0; l < bundle.manifest().levels; ++l) {
    all += std::filesystem::file_size(made_.bundle / pipeline::log_name(l));
  }
  const std::uint64_t before = store::io_counts().read;
  base_points({{3, 0.2, 0.3}});
  EXPECT_LT(store::io_counts().read - before, all / 3);
}

TEST_F(Locate, DamagedLinksAreRefused) {
  make(BaseShape::kIcosahedron);
  const std::vector<BasePoint> base = random_base_points(200);
  std::vector<InputPoint> input;
  for (FaceId f = 0; f < 20'000; f += 50) input.push_back({f, 0.3, 0.3, {}});
  const std::filesystem::path sound = directory() / "sound.remaps";
  std::filesystem::rename(made_.bundle, sound);
  const std::size_t levels = pipeline::Bundle(sound).manifest().levels;

  const auto damage = [&](std::size_t level, const std::function<void(SegmentLog&)>& edit) {
    std::filesystem::remove_all(made_.bundle);
    std::filesystem::copy(sound, made_.bundle);
    for (std::size_t s = 0; s < pipeline::Bundle(sound).manifest().segments[level]; ++s) {
      SegmentLog log = read_segment(made_.bundle, level, s);
      edit(log);
      write_segment(made_.bundle, level, s, log);
    }
  };
  for (const std::uint32_t wrong : {1'000'000u, kNoIndex}) {
    for (std::size_t level = 0; level < levels; ++level) {
      damage(level, [&](SegmentLog& log) {
        for (FaceLink& link : log.next) link.face = wrong;
      });
      EXPECT_THROW(input_points(input), CorruptionError) << "level " << level;
      if (level + 1 < levels) {
        damage(level, [&](SegmentLog& log) {
          for (FaceLink& link : log.next) link.segment = wrong;
        });
        EXPECT_THROW(input_points(input), CorruptionError) << "level " << level;
      }
      if (level == 0) continue;
      damage(level, [&](SegmentLog& log) {
        for (FaceLink& link : log.origin) link.segment = wrong;
      });
      EXPECT_THROW(base_points(base), CorruptionError) << "level " << level;
      damage(level, [&](SegmentLog& log) {
        for (FaceLink& link : log.origin) link.face = wrong;
      });
      EXPECT_THROW(base_points(base), CorruptionError) << "level " << level;
    }
  }
  damage(0, [](SegmentLog& log) { log.faces = kNoIndex; });
  EXPECT_THROW(base_points(base), CorruptionError);
  damage(levels - 1, [](SegmentLog& log) {
    Retriangulation record = log.records[0];
    record.face[1] = record.face[0];
    log.records = with_record(log.records, 0, record);
  });
  EXPECT_THROW(base_points(base), CorruptionError);
  EXPECT_THROW(input_points(input), CorruptionError);
}

TEST_F(Locate, TheManifestIsGivenAsItIs) {
  make(BaseShape::kIcosahedron);
  EXPECT_EQ(pipeline::read_manifest(made_.bundle),
            bytes_of(made_.bundle / pipeline::kManifestName));
  EXPECT_THROW(pipeline::read_manifest(directory()), InputError);
}

}  // namespace
}  // namespace remaps::test
