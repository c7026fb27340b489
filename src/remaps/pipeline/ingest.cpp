#include "remaps/pipeline/ingest.h"

#include <algorithm>

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
      level.add_vertex({first + i, chunk[i], level.cut().segment_of(chunk[i])}, {});
    }
    progress.advance(0.15 + 0.2 * double(first + chunk.size()) / double(spool.vertices()));
  }
}

std::uint64_t route_faces(IndexedMeshReader& reader, VertexLookup& lookup, DomainLevel& level,
                          Progress& progress) {
  std::uint64_t faces = 0;
  reader.read_triangles([&](std::span<const Triangle> triangles) {
    for (const Triangle& t : triangles) {
      std::array<RoutedVertex, 3> corner;
      for (std::size_t i = 0; i < 3; ++i) {
        const VertexLookup::Entry& entry = lookup[t[i]];
        corner[i] = {t[i], entry.position, entry.segment};
      }
      level.add_face(corner, {faces++, 0, {}});
    }
    progress.advance(0.35 + 0.65 * reader.pass_fraction());
  });
  return faces;
}

}  // namespace

std::size_t segments_for(std::uint64_t faces, const MemoryPlan& plan) {
  if (faces <= plan.domain_buffer) return 1;
  return static_cast<std::size_t>((faces + plan.segment_faces - 1) / plan.segment_faces);
}

Ingested ingest(IndexedMeshReader& reader, const MemoryPlan& plan,
                const std::filesystem::path& temp_dir, MemoryBudget& budget, Progress& progress) {
  progress.begin("ingest");
  Ingested result;
  result.sample = PositionSample(kSampleSize);
  VertexSpool spool(temp_dir / "vertices");
  spool.fill(reader, &result.sample, [&](double fraction) { progress.advance(0.15 * fraction); });
  if (spool.vertices() == 0) throw GeometryError("the mesh has no vertices");
  result.vertices = spool.vertices();
  result.origin = spool.origin();
  result.diagonal = spool.box().diagonal();

  // A closed surface has two faces a vertex; the cut needs no better guess.
  std::vector<Vec3f> sample(result.sample.kept().begin(), result.sample.kept().end());
  const SpaceCut cut(sample, segments_for(2 * result.vertices, plan), 0);
  result.level = std::make_unique<DomainLevel>(0, cut, temp_dir, plan.bucket_bytes, budget);
  VertexLookup lookup(spool, &result.level->cut(), plan.cache_bytes, budget);
  route_vertices(spool, *result.level, progress);
  result.faces = route_faces(reader, lookup, *result.level, progress);
  if (result.faces == 0) throw GeometryError("the mesh has no faces");
  return result;
}

}  // namespace remaps::pipeline
