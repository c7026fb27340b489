#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "pipeline/test_bundles.h"
#include "remaps/pipeline/map_file.h"
#include "support/temp_files.h"

namespace remaps::test {
namespace {

using pipeline::Verification;

Verification verify(const std::filesystem::path& bundle, unsigned threads = 1) {
  Progress progress;
  return pipeline::verify_bundle(query_options(bundle, threads), progress);
}

class VerifyBundle : public TempFiles {
 protected:
  /// A sound bundle, 4 levels or so; each test damages copies of it.
  void SetUp() override { made_ = make_test_bundle(directory(), BaseShape::kDisk, 6'000, 1'500); }

  std::filesystem::path copy() const {
    const std::filesystem::path damaged = directory() / "damaged.remaps";
    std::filesystem::remove_all(damaged);
    std::filesystem::copy(made_.bundle, damaged);
    return damaged;
  }
  std::size_t levels() const { return pipeline::Bundle(made_.bundle).manifest().levels; }

  /// Damages records of every level and expects each to be found, by one thread and by two.
  void expect_found(const std::function<bool(SegmentLog&, std::size_t record)>& damage) const {
    std::mt19937_64 random(7);
    for (std::size_t level = 0; level < levels(); ++level) {
      for (unsigned n = 0; n < 6; ++n) {
        const std::filesystem::path damaged = copy();
        const std::size_t segments = pipeline::Bundle(damaged).manifest().segments[level];
        const std::size_t segment = random() % segments;
        SegmentLog log = read_segment(damaged, level, segment);
        if (log.records.empty()) continue;
        const std::size_t record = random() % log.records.size();
        if (!damage(log, record)) continue;
        write_segment(damaged, level, segment, log);
        SCOPED_TRACE(testing::Message()
                     << "level " << level << " segment " << segment << " record " << record);
        EXPECT_THROW(verify(damaged, 1 + n % 2), CorruptionError);
      }
    }
  }
  void expect_found_in_record(const std::function<bool(Retriangulation&)>& damage) const {
    expect_found([&](SegmentLog& log, std::size_t record) {
      Retriangulation r = log.records[record];
      if (!damage(r)) return false;
      log.records = with_record(log.records, record, r);
      return true;
    });
  }

  TestBundle made_;
};

class VerifyShapes : public TempFiles {
 protected:
  Verification verify_shape(BaseShape shape) const {
    const TestBundle made = make_test_bundle(directory(), shape, 20'000, 4'000);
    const Verification one = verify(made.bundle, 1);
    const Verification two = verify(made.bundle, 2);
    EXPECT_EQ(one.round_trip_max, two.round_trip_max);
    EXPECT_EQ(one.round_trip_mean, two.round_trip_mean);
    EXPECT_EQ(one.map_file_max, two.map_file_max);
    EXPECT_EQ(one.records, two.records);
    EXPECT_EQ(one.vertices, made.positions.size());
    EXPECT_EQ(one.records + one.base_vertices, made.positions.size());
    EXPECT_GT(one.segments, 10u);
    EXPECT_EQ(one.components, 1u);
    EXPECT_LT(one.round_trip_max, 1e-8);
    EXPECT_LT(one.map_file_max, 1e-7);
    return one;
  }
};

TEST_F(VerifyShapes, PassesASphere) {
  const Verification found = verify_shape(BaseShape::kIcosahedron);
  EXPECT_EQ(found.euler_characteristic, 2);
  EXPECT_EQ(found.boundary_loops, 0u);
}

TEST_F(VerifyShapes, PassesATorus) {
  const Verification found = verify_shape(BaseShape::kTorus);
  EXPECT_EQ(found.euler_characteristic, 0);
  EXPECT_EQ(found.boundary_loops, 0u);
}

TEST_F(VerifyShapes, PassesADisk) {
  const Verification found = verify_shape(BaseShape::kDisk);
  EXPECT_EQ(found.euler_characteristic, 1);
  EXPECT_EQ(found.boundary_loops, 1u);
}

TEST_F(VerifyShapes, PassesVerticesWithoutFaces) {
  const TestBundle made =
      make_test_bundle(directory(), BaseShape::kIcosahedron, 3'000, 1'500, /*unused=*/5);
  EXPECT_EQ(verify(made.bundle).vertices, made.positions.size() - 5);
}

TEST_F(VerifyShapes, LeavesNoFilesBehind) {
  const TestBundle made = make_test_bundle(directory(), BaseShape::kIcosahedron, 3'000, 1'500);
  const std::size_t before = entries_in(directory());
  verify(made.bundle);
  EXPECT_EQ(entries_in(directory()), before);
}

TEST_F(VerifyBundle, RefusesWhatIsNoBundle) {
  EXPECT_THROW(verify(directory()), InputError);
  EXPECT_THROW(verify(directory() / "missing"), InputError);
}

TEST_F(VerifyBundle, FindsEveryMissingOrShortenedFile) {
  ASSERT_GE(levels(), 3u);
  for (const auto& entry : std::filesystem::directory_iterator(made_.bundle)) {
    const std::string name = entry.path().filename().string();
    SCOPED_TRACE(name);
    const std::uint64_t size = entry.file_size();
    for (const std::uint64_t cut : {std::uint64_t{0}, size / 2, size - 1}) {
      const std::filesystem::path damaged = copy();
      std::filesystem::resize_file(damaged / name, cut);
      EXPECT_THROW(verify(damaged), CorruptionError) << "cut to " << cut;
    }
    if (name == pipeline::kManifestName) continue;
    const std::filesystem::path damaged = copy();
    std::filesystem::remove(damaged / name);
    EXPECT_THROW(verify(damaged), CorruptionError);
  }
}

TEST_F(VerifyBundle, FindsEveryFlippedByte) {
  std::mt19937_64 random(1);
  for (const auto& entry : std::filesystem::directory_iterator(made_.bundle)) {
    const std::string name = entry.path().filename().string();
    const std::string bytes = bytes_of(entry.path());
    const std::filesystem::path damaged = copy();
    for (unsigned n = 0; n < 60; ++n) {
      // The ends of files have headers and indices; look there more often.
      std::uint64_t at = random() % bytes.size();
      if (n % 4 == 1) at = random() % 64;
      if (n % 4 == 2) at = bytes.size() - 1 - random() % 128;
      const auto flip = static_cast<char>(1 + random() % 255);
      overwrite(damaged / name, at, static_cast<char>(bytes[at] ^ flip));
      EXPECT_THROW(verify(damaged, 1 + n % 2), CorruptionError)
          << name << " byte " << at << " ^ " << int{flip};
      overwrite(damaged / name, at, bytes[at]);
    }
    EXPECT_NO_THROW(verify(damaged)) << name;
  }
}

TEST_F(VerifyBundle, RewritingUnchangedPasses) {
  const std::filesystem::path same = copy();
  for (std::size_t level = 0; level < levels(); ++level) {
    write_segment(same, level, 0, read_segment(same, level, 0));
  }
  reseal(same);
  EXPECT_NO_THROW(verify(same));
}

TEST_F(VerifyBundle, FindsARingThatMoved) {
  // All of it, so that the removed vertex surely lands elsewhere.
  expect_found_in_record([](Retriangulation& r) {
    for (unsigned i = 0; i < r.ring_size(); ++i) {
      r.ring[i].x = static_cast<std::int16_t>(r.ring[i].x - 150);
    }
    return true;
  });
}

TEST_F(VerifyBundle, FindsARingPointOutsideTheGrid) {
  expect_found_in_record([](Retriangulation& r) {
    r.ring[0].x = 32767;
    return true;
  });
}

TEST_F(VerifyBundle, FindsSwappedFaces) {
  expect_found_in_record([](Retriangulation& r) {
    std::swap(r.face[0], r.face[1]);
    return true;
  });
}

TEST_F(VerifyBundle, FindsAFaceTwiceInAStar) {
  expect_found_in_record([](Retriangulation& r) {
    r.face[1] = r.face[0];
    return true;
  });
}

TEST_F(VerifyBundle, FindsAChangedApex) {
  expect_found_in_record([](Retriangulation& r) {
    r.apex = static_cast<std::uint8_t>((r.apex + 1u) % r.ring_size());
    return true;
  });
}

TEST_F(VerifyBundle, FindsAChangedTurn) {
  expect_found_in_record([](Retriangulation& r) {
    r.turn[1] = static_cast<std::uint8_t>((r.turn[1] + 1u) % 3);
    return true;
  });
}

TEST_F(VerifyBundle, FindsAChangedRemovedVertex) {
  expect_found([](SegmentLog& log, std::size_t record) {
    log.removed[record] ^= 1;
    return true;
  });
}

TEST_F(VerifyBundle, FindsAMissingRecord) {
  expect_found([](SegmentLog& log, std::size_t record) {
    RetriangulationLog fewer;
    for (std::size_t r = 0; r < log.records.size(); ++r) {
      if (r != record) fewer.append(log.records[r]);
    }
    log.records = fewer;
    log.removed.erase(log.removed.begin() + std::ptrdiff_t(record));
    return true;
  });
}

TEST_F(VerifyBundle, FindsChangedLinks) {
  std::mt19937_64 random(3);
  const auto damage_next = [&](auto edit) {
    expect_found([&](SegmentLog& log, std::size_t) {
      edit(log.next[random() % log.next.size()]);
      return true;
    });
  };
  damage_next([](FaceLink& link) { ++link.face; });
  damage_next([](FaceLink& link) { link.face = kNoIndex; });
  damage_next([](FaceLink& link) { link.segment ^= 1; });
  damage_next([](FaceLink& link) { link.segment = kNoIndex; });
  expect_found([&](SegmentLog& log, std::size_t) {
    if (log.origin.empty()) return false;
    FaceLink& link = log.origin[random() % log.origin.size()];
    random() % 2 == 0 ? ++link.face : ++link.segment;
    return true;
  });
  expect_found([&](SegmentLog& log, std::size_t) {
    if (log.next.size() < 2) return false;
    std::swap(log.next[0], log.next[1]);
    return true;
  });
}

TEST_F(VerifyBundle, FindsAWrongSetOfSurvivors) {
  expect_found([](SegmentLog& log, std::size_t) {
    log.survivor.pop_back();
    log.next.pop_back();
    return true;
  });
  expect_found([](SegmentLog& log, std::size_t record) {
    // A dropped face instead of a surviving one.
    const LocalIndex dropped = log.records.face(record, log.records.wedges(record) - 1);
    const auto at = std::lower_bound(log.survivor.begin(), log.survivor.end(), dropped);
    if (at == log.survivor.end() || *at == dropped) return false;
    *at = dropped;
    return true;
  });
}

TEST_F(VerifyBundle, FindsAFaceCountTooLarge) {
  expect_found([](SegmentLog& log, std::size_t) {
    if (log.level > 0) return false;
    log.faces = kNoIndex;
    return true;
  });
}

TEST_F(VerifyBundle, FindsAMovedMapEntry) {
  std::mt19937_64 random(4);
  for (int n = 0; n < 10; ++n) {
    const std::filesystem::path damaged = copy();
    const std::filesystem::path map = damaged / pipeline::kMapName;
    const std::uint64_t vertex = random() % made_.positions.size();
    pipeline::MapRecord record;
    std::memcpy(&record, bytes_of(map).data() + vertex * sizeof record, sizeof record);
    float& weight = n % 2 == 0 ? record.u : record.v;
    weight += weight > 0.5f ? -1e-3f : 1e-3f;
    overwrite(map, vertex * sizeof record, record);
    reseal(damaged);
    EXPECT_THROW(verify(damaged), CorruptionError) << "vertex " << vertex;
  }
}

TEST_F(VerifyBundle, FindsAMapEntryOnAnotherOrNoFace) {
  for (const std::uint32_t face : {0u, 1'000'000u, 0xFFFFFFFFu}) {
    const std::filesystem::path damaged = copy();
    const std::filesystem::path map = damaged / pipeline::kMapName;
    overwrite(map, 0, pipeline::MapRecord{face, 0.3f, 0.3f});
    reseal(damaged);
    EXPECT_THROW(verify(damaged), CorruptionError) << "face " << face;
  }
}

TEST_F(VerifyBundle, FindsAChangedBase) {
  const auto damage = [&](const std::function<void(BaseMesh&)>& edit) {
    const std::filesystem::path damaged = copy();
    BaseMesh base = pipeline::Bundle(damaged).base();
    edit(base);
    pipeline::write_base(base, {}, damaged / pipeline::kBaseName);
    reseal(damaged);
    EXPECT_THROW(verify(damaged), CorruptionError);
  };
  damage([](BaseMesh& base) { base.position[3].x += 1e-6f; });
  damage([](BaseMesh& base) { std::swap(base.position[0], base.position[1]); });
  damage([](BaseMesh& base) {
    auto& t = base.triangle[5];
    t = {t[1], t[2], t[0]};
  });
  damage([](BaseMesh& base) { std::swap(base.triangle[0], base.triangle[1]); });
  damage([](BaseMesh& base) { base.triangle.pop_back(); });
  damage([](BaseMesh& base) { base.position.push_back({1, 2, 3}); });
}

TEST_F(VerifyBundle, FindsAChangedTile) {
  const auto damage = [&](const std::function<void(Tile&)>& edit) {
    const std::filesystem::path damaged = copy();
    edit_section(damaged / pipeline::kTilesName, kTileKind, 1, [&](store::Bytes& bytes) {
      Tile tile;
      decode_tile(bytes, "tile", tile);
      edit(tile);
      bytes = encode_tile(tile);
    });
    EXPECT_THROW(verify(damaged), CorruptionError);
  };
  damage([](Tile& tile) { std::swap(tile.triangle[0], tile.triangle[1]); });
  damage([](Tile& tile) { std::swap(tile.vertex_id[0], tile.vertex_id[1]); });
  damage([](Tile& tile) { tile.vertex_id.front() = VertexId{1} << 50; });
  damage([](Tile& tile) { tile.vertex_id.front() += 1; });
  damage([](Tile& tile) { tile.face_id.front() += 1; });
  damage([](Tile& tile) { tile.face_id.front() = ~FaceId{0}; });
  damage([](Tile& tile) { tile.position.back().x += 1e-3f; });  // a foreign vertex
  damage([](Tile& tile) { --tile.own_vertices; });
  damage([](Tile& tile) {
    tile.triangle.pop_back();
    tile.face_id.pop_back();
  });
}

TEST_F(VerifyBundle, FindsAManifestThatSaysOtherwise) {
  const auto damage = [&](const std::function<void(pipeline::Manifest&)>& edit) {
    const std::filesystem::path damaged = copy();
    reseal(damaged, edit);
    EXPECT_THROW(verify(damaged), CorruptionError);
  };
  using pipeline::Manifest;
  damage([](Manifest& m) { ++m.topology.components; });
  damage([](Manifest& m) { ++m.topology.boundary_loops; });
  damage([](Manifest& m) { m.topology.boundary_edges += 2; });
  damage([](Manifest& m) { ++m.topology.vertices; });
  damage([](Manifest& m) { m.topology.faces += 2; });
  damage([](Manifest& m) { m.topology.faces = ~std::uint64_t{0}; });
  damage([](Manifest& m) { m.input_vertices = ~std::uint64_t{0}; });
  damage([](Manifest& m) { m.segments[1] += std::uint64_t{1} << 63; });
  damage([](Manifest& m) { m.segments.pop_back(); });
  damage([](Manifest& m) { m.diagonal *= 1.001; });
  damage([](Manifest& m) { m.origin.x += 1; });
}

}  // namespace
}  // namespace remaps::test
