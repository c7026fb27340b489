#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/mesh/segment.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/mesh/space_cut.h"
#include "remaps/store/bucket_file.h"

namespace remaps {

/// A vertex on its way to a level, with the segment that it falls in there.
struct RoutedVertex {
  VertexId id = 0;
  Vec3f position;
  std::uint32_t segment = 0;
};

/// What a face takes along. At the first level its input index, afterwards its load and where it
/// was.
struct FacePayload {
  FaceId input_face = 0;
  float load = 0;
  FaceLink origin;
};

/// Finds the local index of a global vertex id; kept as scratch between segments.
class VertexIndex {
 public:
  void reset(std::size_t expected);
  /// @return  the slot for id: kNoIndex until it is set
  LocalIndex& operator[](VertexId id);

 private:
  std::vector<VertexId> key_;
  std::vector<LocalIndex> value_;
  std::uint64_t mask_ = 0;
};

/// The domain mesh of one level on disk, cut into segments (see Segment). Filled through add_*,
/// then loaded segment by segment; loading frees the disk space.
class DomainLevel {
 public:
  /// @param buffer_bytes  memory for the write buffers of all segments
  DomainLevel(unsigned level, SpaceCut cut, const std::filesystem::path& directory,
              std::uint64_t buffer_bytes, MemoryBudget& budget);

  unsigned level() const { return level_; }
  std::size_t segments() const { return cut_.segments(); }
  const SpaceCut& cut() const { return cut_; }
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t faces() const { return faces_; }
  /// Faces with corners in several segments; about as many vertices are locked by them.
  std::uint64_t mixed_faces() const { return mixed_faces_; }
  /// Faces of the fullest segment, ghosts included.
  std::uint64_t largest_segment() const;

  /// Adds a vertex to its own segment. The quadric is not used at level 0.
  void add_vertex(const RoutedVertex& vertex, const Quadric& quadric);
  /// Adds a face to the segments of its corners. Foreign corners are added there by themselves.
  /// @return  where the face is at home
  FaceLink add_face(const std::array<RoutedVertex, 3>& corner, const FacePayload& payload);

  /// Loads a segment and frees its space. Safe on several threads for different segments.
  /// @param origin  (home faces) where they were at the level before; empty at level 0
  void load(std::size_t segment, VertexIndex& scratch, Segment& out, std::vector<FaceLink>& origin);

 private:
  void put_vertex(std::size_t segment, const RoutedVertex& vertex, const Quadric* quadric);
  void load_vertices(std::size_t segment, VertexIndex& scratch, Segment& out);
  void load_faces(std::size_t segment, VertexIndex& scratch, Segment& out,
                  std::vector<FaceLink>& origin);

  unsigned level_;
  SpaceCut cut_;
  store::BucketFile vertex_file_;
  store::BucketFile face_file_;
  std::vector<LocalIndex> home_faces_;  // (segments) so far
  std::uint64_t vertices_ = 0;
  std::uint64_t faces_ = 0;
  std::uint64_t mixed_faces_ = 0;
};

}  // namespace remaps
