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
  std::uint8_t feature = 0;    ///< see Segment; kept only with carry_features
  FaceLabel label = kNoLabel;  ///< kept only with carry_labels
};

/// Finds the local index of a global vertex id; kept as scratch between segments. A table over the
/// range of ids where they lie close together, else a hash table.
class VertexIndex {
 public:
  void reset(std::size_t expected) { reset(expected, 0, ~VertexId{0}); }
  /// @param low, high  bounds of the ids that will be asked for
  void reset(std::size_t expected, VertexId low, VertexId high);
  /// @return  the slot for id: kNoIndex until it is set
  LocalIndex& operator[](VertexId id) { return dense_ ? table_[id - low_] : hashed(id); }

 private:
  struct Entry {
    VertexId key;
    LocalIndex value;
  };

  LocalIndex& hashed(VertexId id) {
    std::uint64_t at = (id * 0x9E3779B97F4A7C15u) >> 20 & mask_;
    while (entries_[at].key != id) {
      if (entries_[at].key == ~VertexId{0}) {
        entries_[at].key = id;
        break;
      }
      at = (at + 1) & mask_;
    }
    return entries_[at].value;
  }

  bool dense_ = false;
  VertexId low_ = 0;
  std::vector<LocalIndex> table_;
  std::vector<Entry> entries_;
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

  /// Faces take FacePayload::feature along, a byte each. To be called before the first face, not at
  /// level 0.
  void carry_features() { features_ = true; }
  /// Faces take FacePayload::label along, a byte each and eight more where it is another than that
  /// of the face before; after the first level only those with an edge of which nothing is known.
  /// To be called before the first face.
  void carry_labels() { labels_ = true; }
  bool has_labels() const { return labels_; }

  /// Adds a vertex to its own segment. The quadric is not used at level 0.
  void add_vertex(const RoutedVertex& vertex, const Quadric& quadric);
  /// Adds a face to the segments of its corners. Foreign corners are added there by themselves.
  /// @return  where the face is at home
  FaceLink add_face(const std::array<RoutedVertex, 3>& corner, const FacePayload& payload);

  /// The same for a face whose foreign corners are added by themselves: see foreign_corners. Only
  /// ids and segments of the corners are used.
  FaceLink add_face_alone(const std::array<RoutedVertex, 3>& corner, const FacePayload& payload);
  /// Adds a vertex to a segment that it is foreign to, where a face brings it.
  void add_foreign(std::size_t segment, const RoutedVertex& vertex) {
    put_vertex(segment, vertex, nullptr);
  }
  /// Calls add(segment, vertex) for each corner of a face that is foreign in the segment of
  /// another.
  template <class Add>
  static void foreign_corners(const std::array<RoutedVertex, 3>& corner, Add&& add) {
    for (unsigned i = 0; i < 3; ++i) {
      const std::uint32_t segment = corner[i].segment;
      if ((i > 0 && segment == corner[0].segment) || (i > 1 && segment == corner[1].segment))
        continue;
      for (const RoutedVertex& other : corner) {
        if (other.segment != segment) add(segment, other);
      }
    }
  }

  /// What becomes of a segment on disk when it has been loaded.
  enum class After { kFree, kKeep };

  /// Loads a segment. Safe on several threads for different segments.
  /// @param origin  (home faces) where they were at the level before; empty at level 0
  void load(std::size_t segment, VertexIndex& scratch, Segment& out, std::vector<FaceLink>& origin,
            After after = After::kFree);

 private:
  /// What is known of a segment while it is written. Records say how they differ from the one
  /// before in their bucket.
  struct Bucket {
    VertexId vertex = 0;         // of the vertex before
    VertexId corner = 0;         // first of the face before
    FaceId face = 0;             // of the face before, or where it was
    std::uint32_t origin = 0;    // segment where that was
    FaceLabel label = kNoLabel;  // of the face before that has one
    LocalIndex home_faces = 0;
    LocalIndex faces = 0;
    LocalIndex own_vertices = 0;
    LocalIndex vertex_records = 0;
    VertexId low = ~VertexId{0};
    VertexId high = 0;
  };

  void put_vertex(std::size_t segment, const RoutedVertex& vertex, const Quadric* quadric);
  void put_face(std::size_t segment, const std::array<RoutedVertex, 3>& corner,
                const FacePayload& payload, bool home);
  void load_vertices(std::size_t segment, VertexIndex& scratch, Segment& out);
  void load_faces(std::size_t segment, VertexIndex& scratch, Segment& out,
                  std::vector<FaceLink>& origin);

  unsigned level_;
  bool features_ = false;
  bool labels_ = false;
  SpaceCut cut_;
  Reservation reservation_;
  store::BucketFile vertex_file_;
  store::BucketFile face_file_;
  std::vector<Bucket> buckets_;  // (segments)
  std::uint64_t vertices_ = 0;
  std::uint64_t faces_ = 0;
  std::uint64_t mixed_faces_ = 0;
};

}  // namespace remaps
