#include "remaps/pipeline/ingest.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "remaps/base/overlap.h"
#include "remaps/pipeline/face_join.h"

namespace remaps::pipeline {
namespace {

constexpr std::size_t kSampleSize = 1 << 17;

void route_vertices(const VertexSpool& spool, DomainLevel& level, Progress& progress) {
  constexpr std::uint64_t kChunk = 1 << 15;
  std::vector<Vec3f> chunk;
  for (std::uint64_t first = 0; first < spool.vertices(); first += kChunk) {
    chunk.resize(static_cast<std::size_t>(std::min(kChunk, spool.vertices() - first)));
    spool.read(first, chunk);
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      if (!is_finite(chunk[i])) continue;
      level.add_vertex({first + i, chunk[i], level.cut().segment_of(chunk[i])}, {});
    }
    progress.advance(0.15 + 0.2 * double(first + chunk.size()) / double(spool.vertices()));
  }
}

/// Faces between two looks at how the vertex cache does.
constexpr std::uint64_t kStretch = 1 << 16;

/// A piece of the face stream on its way from the parsing thread.
struct FaceChunk {
  std::vector<Triangle> triangle;
  double fraction = 0;  // of the file
};

/// Routes faces to their segments, through the vertex cache as long as that serves, else by a join.
class FaceRouter {
 public:
  FaceRouter(const VertexSpool& spool, DomainLevel& level, const MemoryPlan& plan,
             const std::filesystem::path& directory, MemoryBudget& budget, Progress& progress)
      : spool_(spool),
        level_(level),
        plan_(plan),
        directory_(directory),
        budget_(budget),
        progress_(progress) {
    if (FaceJoin::ranges(spool.vertices(), level.segments(), plan) == 1) {
      join_.emplace(spool, level, true, plan, directory, budget);
    } else {
      lookup_.emplace(spool, &level.cut(), plan.cache_bytes, budget);
      route_vertices(spool, level, progress);
    }
  }

  void add(const FaceChunk& chunk) {
    for (const Triangle& t : chunk.triangle) {
      if (lookup_ && faces_ % kStretch == 0) look_at_cache();
      if (!leave_out(t)) join_ ? join_->add(t, faces_) : add_from_cache(t);
      ++faces_;
    }
    progress_.advance(0.4 + 0.5 * chunk.fraction);
  }

  void finish(Ingested& result) {
    if (join_) join_->finish([&](double fraction) { progress_.advance(0.9 + 0.1 * fraction); });
    result.faces = faces_;
    result.degenerate_faces = degenerate_;
    result.first_degenerate = first_degenerate_;
    result.twice = twice_;
    result.nonfinite_faces = nonfinite_;
    result.first_nonfinite_face = first_nonfinite_;
  }

 private:
  bool leave_out(const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      if (degenerate_++ == 0) {
        first_degenerate_ = faces_;
        twice_ = t[0] == t[1] || t[0] == t[2] ? t[0] : t[1];
      }
      return true;
    }
    if (spool_.nonfinite().empty() || !spool_.is_touched(t)) return false;
    if (nonfinite_++ == 0) first_nonfinite_ = faces_;
    return true;
  }

  void add_from_cache(const Triangle& t) {
    std::array<RoutedVertex, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexLookup::Entry& entry = (*lookup_)[t[i]];
      corner[i] = {t[i], entry.position, entry.segment};
    }
    level_.add_face(corner, {faces_, 0, {}});
  }

  /// Goes over to the join for good when a block was read for every eighth face lately. Depends on
  /// nothing but the input and the plan.
  void look_at_cache() {
    const std::uint64_t misses = lookup_->misses();
    if (8 * (misses - misses_before_) > kStretch) {
      lookup_.reset();
      join_.emplace(spool_, level_, false, plan_, directory_, budget_);
    }
    misses_before_ = misses;
  }

  const VertexSpool& spool_;
  DomainLevel& level_;
  const MemoryPlan& plan_;
  const std::filesystem::path& directory_;
  MemoryBudget& budget_;
  Progress& progress_;
  std::optional<VertexLookup> lookup_;
  std::optional<FaceJoin> join_;
  std::uint64_t faces_ = 0;
  std::uint64_t degenerate_ = 0;
  FaceId first_degenerate_ = 0;
  VertexId twice_ = 0;
  std::uint64_t nonfinite_ = 0;
  FaceId first_nonfinite_ = 0;
  std::uint64_t misses_before_ = 0;
};

void read_faces(IndexedMeshReader& reader, FaceRouter& router, bool overlap) {
  run_overlapped<FaceChunk>(
      overlap,
      [&](FunctionRef<void(FaceChunk&)> send) {
        FaceChunk chunk;
        reader.read_triangles([&](std::span<const Triangle> triangles) {
          chunk.triangle.assign(triangles.begin(), triangles.end());
          chunk.fraction = reader.pass_fraction();
          send(chunk);
        });
      },
      [&](const FaceChunk& chunk) { router.add(chunk); });
}

}  // namespace

std::size_t segments_for(std::uint64_t faces, const MemoryPlan& plan) {
  if (faces <= plan.domain_buffer) return 1;
  return static_cast<std::size_t>((faces + plan.segment_faces - 1) / plan.segment_faces);
}

Ingested ingest(IndexedMeshReader& reader, const std::string& name, const MemoryPlan& plan,
                const std::filesystem::path& temp_dir, unsigned threads, MemoryBudget& budget,
                Progress& progress) {
  progress.begin("ingest");
  Ingested result;
  result.sample = PositionSample(kSampleSize);
  VertexSpool spool(temp_dir / "vertices", budget);
  spool.fill(reader, &result.sample, [&](double fraction) { progress.advance(0.15 * fraction); });
  if (spool.vertices() == 0) throw GeometryError(name + ": the mesh has no vertices");
  result.vertices = spool.vertices();
  result.nonfinite_vertices = spool.nonfinite().size();
  result.first_nonfinite = spool.nonfinite().first(Ingested::kMostNamed);
  if (result.nonfinite_vertices == result.vertices) {
    throw GeometryError(fmt::format("{}: no vertex is left: none of the {} has finite coordinates",
                                    name, result.vertices));
  }
  result.origin = spool.origin();
  result.diagonal = spool.box().diagonal();

  // A closed surface has two faces a vertex; the cut needs no better guess.
  std::vector<Vec3f> sample(result.sample.kept().begin(), result.sample.kept().end());
  const SpaceCut cut(sample, segments_for(2 * result.vertices, plan), 0);
  result.level = std::make_unique<DomainLevel>(0, cut, temp_dir, plan.bucket_bytes, budget);
  FaceRouter router(spool, *result.level, plan, temp_dir, budget, progress);
  const PolygonCutting cutting(reader, spool, plan.cache_bytes / 4, budget);
  read_faces(reader, router, threads > 1);
  router.finish(result);
  if (result.faces == 0) throw GeometryError(name + ": the mesh has no faces");
  if (result.level->faces() == 0) {
    throw GeometryError(fmt::format(
        "{}: no face is left: of {}, {} have a vertex twice and {} one that is not finite", name,
        result.faces, result.degenerate_faces, result.nonfinite_faces));
  }
  return result;
}

}  // namespace remaps::pipeline
