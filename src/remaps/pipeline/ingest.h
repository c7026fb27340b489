#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/domain_level.h"
#include "remaps/mesh/indexed_stream.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/vertex_spool.h"
#include "remaps/store/row_spool.h"

namespace remaps::pipeline {

/// The input as the first level: cut by place, on disk.
struct Ingested {
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;  ///< of the file
  // Left out:
  std::uint64_t nonfinite_vertices = 0;
  static constexpr std::size_t kMostNamed = 5;
  std::vector<VertexId> first_nonfinite;  ///< the lowest ones, kMostNamed at most
  std::uint64_t nonfinite_faces = 0;      ///< with such a vertex
  FaceId first_nonfinite_face = 0;
  std::uint64_t degenerate_faces = 0;  ///< with a vertex twice
  FaceId first_degenerate = 0;
  VertexId twice = 0;                 ///< the vertex of that face
  std::uint64_t copied_vertices = 0;  ///< that repair added, numbered from `vertices` on
  std::uint64_t filled_faces = 0;     ///< that fill holes, numbered from `faces` on
  /// (copied_vertices) rows of a VertexId: what each is a copy of, or kNoVertex; null if there are
  /// none
  std::unique_ptr<store::RowSpool> originals;
  Vec3 origin;
  double diagonal = 0;
  std::unique_ptr<DomainLevel> level;
  PositionSample sample{1};  ///< of the vertices, for the cut of the next level
};

/// Segments that a level of so many faces needs: 1 when it fits the domain buffer.
std::size_t segments_for(std::uint64_t faces, const MemoryPlan& plan);

/// Reads an input in any order and routes its vertices and faces to the segments of the first
/// level. Faces keep their numbers in the file.
/// @param threads  with more than one, parsing overlaps with routing; the result is the same
/// @throws InputError  malformed; GeometryError: no faces
/// @param name  of the file, for messages
Ingested ingest(IndexedMeshReader& reader, const std::string& name, const MemoryPlan& plan,
                const std::filesystem::path& temp_dir, unsigned threads, MemoryBudget& budget,
                Progress& progress);

}  // namespace remaps::pipeline
