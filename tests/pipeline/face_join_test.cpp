#include "remaps/pipeline/face_join.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "remaps/formats/mesh_reader.h"
#include "remaps/pipeline/ingest.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

/// What a level holds, whatever the order within its segments.
struct Content {
  std::vector<std::map<VertexId, std::pair<bool, Vec3f>>> vertex;  // own, position
  std::vector<std::map<FaceId, std::pair<bool, Triangle>>> face;   // home, corners
  bool operator==(const Content&) const = default;
};

Content content(DomainLevel& level) {
  Content result;
  VertexIndex scratch;
  Segment s;
  std::vector<FaceLink> origin;
  for (std::size_t i = 0; i < level.segments(); ++i) {
    level.load(i, scratch, s, origin);
    auto& vertex = result.vertex.emplace_back();
    for (LocalIndex v = 0; v < s.vertex_id.size(); ++v)
      vertex[s.vertex_id[v]] = {v < s.own_vertices, s.position[v]};
    auto& face = result.face.emplace_back();
    for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
      const LocalTriangle& t = s.triangle[f];
      face[s.face_id[f]] = {f < s.home_faces,
                            {s.vertex_id[t[0]], s.vertex_id[t[1]], s.vertex_id[t[2]]}};
    }
  }
  return result;
}

class FaceJoinTest : public test::TempFiles {
 protected:
  static constexpr std::size_t kSegments = 9;

  void SetUp() override {
    test::TempFiles::SetUp();
    mesh_ = test::scan(BaseShape::kTorus, 20'000, true);
    test::write_lists(mesh_, directory() / "in.ply");
    for (const Vec3& p : mesh_.position) position_.push_back(to_float(p));
    std::vector<Vec3f> sample = position_;
    cut_ = SpaceCut(sample, kSegments, 0);
  }
  RoutedVertex routed(VertexId v) const { return {v, position_[v], cut_.segment_of(position_[v])}; }
  std::filesystem::path sub(const std::string& name) const {
    std::filesystem::create_directory(directory() / name);
    return directory() / name;
  }
  Content expected() {
    DomainLevel level(0, cut_, sub("expected"), 1 << 16, budget_);
    for (VertexId v = 0; v < position_.size(); ++v) level.add_vertex(routed(v), {});
    for (std::size_t f = 0; f < mesh_.triangle.size(); ++f) {
      const Triangle& t = mesh_.triangle[f];
      level.add_face({routed(t[0]), routed(t[1]), routed(t[2])}, {f, 0, {}});
    }
    return content(level);
  }

  test::MeshLists mesh_;
  std::vector<Vec3f> position_;
  SpaceCut cut_;
  MemoryBudget budget_{std::uint64_t{64} << 20};
};

TEST_F(FaceJoinTest, BringsFacesAndCornersWhereTheyBelongWithAnyNumberOfRanges) {
  const Content good = expected();
  VertexSpool spool(directory() / "spool", budget_);
  const auto reader = open_mesh_reader(directory() / "in.ply");
  spool.fill(*reader, nullptr, [](double) {});
  for (const std::uint64_t bytes : {1u << 20, 40'000u, 9'000u, 2'000u}) {
    MemoryPlan plan;
    plan.budget_bytes = bytes;
    plan.bucket_bytes = 1 << 16;
    SCOPED_TRACE(FaceJoin::ranges(position_.size(), kSegments, plan));
    for (const bool add_vertices : {true, false}) {
      DomainLevel level(0, cut_, sub("level"), 1 << 16, budget_);
      FaceJoin join(spool, level, add_vertices, plan, sub("join"), budget_);
      for (std::size_t f = 0; f < mesh_.triangle.size(); ++f) join.add(mesh_.triangle[f], f);
      double last = 0;
      join.finish([&](double fraction) {
        EXPECT_LE(last, fraction);
        last = fraction;
      });
      EXPECT_EQ(last, 1);
      for (VertexId v = 0; !add_vertices && v < position_.size(); ++v)
        level.add_vertex(routed(v), {});
      EXPECT_EQ(level.vertices(), position_.size());
      EXPECT_EQ(level.faces(), mesh_.triangle.size());
      EXPECT_TRUE(content(level) == good);
    }
  }
  EXPECT_EQ(budget_.available(), budget_.total());
}

TEST_F(FaceJoinTest, IngestGoesOverToItInMidStreamAndThreadsChangeNothing) {
  // A cache of four blocks, and memory for several ranges.
  MemoryPlan plan;
  plan.budget_bytes = 20'000;
  plan.bucket_bytes = 1 << 16;
  plan.domain_buffer = 10'000;
  plan.segment_faces = 5'000;
  const test::MeshLists mesh = test::scan(BaseShape::kTorus, 60'000, true);
  test::write_lists(mesh, directory() / "large.ply");
  ASSERT_GT(FaceJoin::ranges(mesh.position.size(), 20, plan), 1u);
  std::vector<Content> contents;
  for (const unsigned threads : {1u, 2u}) {
    Progress progress;
    const auto reader = open_mesh_reader(directory() / "large.ply");
    Ingested ingested = ingest(*reader, "in.ply", plan, sub("ingest" + std::to_string(threads)),
                               threads, budget_, progress);
    EXPECT_EQ(ingested.faces, mesh.triangle.size());
    contents.push_back(content(*ingested.level));
    std::set<FaceId> seen;
    for (const auto& segment : contents.back().face) {
      for (const auto& [id, face] : segment) {
        EXPECT_EQ(face.second, mesh.triangle[id]);
        if (face.first) {
          EXPECT_TRUE(seen.insert(id).second);
        }
      }
    }
    EXPECT_EQ(seen.size(), mesh.triangle.size());
  }
  EXPECT_TRUE(contents[0] == contents[1]);
}

TEST(SegmentTable, TakesMoreSegmentsThanTwoBytesCount) {
  SegmentTable table;
  for (const std::size_t segments : {std::size_t{1} << 16, (std::size_t{1} << 16) + 1}) {
    table.reset(segments, 3);
    table.set(2, static_cast<std::uint32_t>(segments - 1));
    EXPECT_EQ(table[2], segments - 1);
  }
}

}  // namespace
}  // namespace remaps::pipeline
