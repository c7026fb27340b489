#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "remaps/mesh/segment.h"
#include "remaps/repair/parity_forest.h"

namespace remaps::repair {

/// What is wrong with a surface, each thing counted once, whatever segments see it.
struct Defects {
  std::uint64_t duplicate_faces = 0;       ///< with the corners of a face of lower number
  std::uint64_t nonmanifold_edges = 0;     ///< of more than two faces
  std::uint64_t misoriented_edges = 0;     ///< of two faces that run along it the same way
  std::uint64_t nonmanifold_vertices = 0;  ///< whose faces form several fans

  bool any() const {
    return duplicate_faces + nonmanifold_edges + misoriented_edges + nonmanifold_vertices > 0;
  }
  Defects& operator+=(const Defects& other) {
    duplicate_faces += other.duplicate_faces;
    nonmanifold_edges += other.nonmanifold_edges;
    misoriented_edges += other.misoriented_edges;
    nonmanifold_vertices += other.nonmanifold_vertices;
    return *this;
  }
};

/// The first few places of each kind, for people. Input numbers, from 0.
struct DefectPlaces {
  static constexpr std::size_t kMost = 5;

  std::vector<std::uint64_t> duplicate_faces;
  std::vector<std::pair<VertexId, VertexId>> nonmanifold_edges;
  std::vector<std::pair<VertexId, VertexId>> misoriented_edges;
  std::vector<VertexId> nonmanifold_vertices;

  /// Adds those of another part as long as there is room.
  void add(const DefectPlaces& other);
};

/// Finds how one segment of the input is to be made a manifold. All decisions about an edge or a
/// vertex follow from the faces there, so that all segments that see them decide alike.
///
/// * Of faces with the same three corners the one of the lowest number stays.
/// * An edge joins its faces when they are two, whatever way they run. Of more, those are joined
/// that
///   bound the same wedge of the inside, or none (EdgeRule).
/// * A vertex goes to each fan of faces so joined: the largest fan keeps it, others get copies.
/// * Faces are turned to agree across the edges that join them.
///
/// With kCut, copies make edges of one or two faces that agree: around a vertex a fan ends where it
/// meets an edge that is cut, so that it has at most two faces there, its first and its last. With
/// kPair two pairs may stay together at both ends of their edge; kCut then parts them.
enum class EdgeRule { kPair, kCut };

class SegmentAnalysis {
 public:
  /// The segment must outlive the use of what was found; its vertices must be distinct in each
  /// face. Cost: sorts the half-edges. Memory: some 100 B a face.
  void run(const Segment& segment, EdgeRule rule);

  const Defects& defects() const { return defects_; }
  const DefectPlaces& places() const { return places_; }

  /// (faces) 1 for a duplicate.
  const std::vector<std::uint8_t>& dropped() const { return dropped_; }

  /// (faces) which of the components that edges join, from 0, and whether the face is turned
  /// against the first of its component.
  const std::vector<std::uint32_t>& component() const { return component_; }
  const std::vector<std::uint8_t>& turned() const { return turned_; }
  std::uint32_t components() const { return components_; }
  /// An edge that closes a band with one side.
  const std::optional<std::pair<VertexId, VertexId>>& one_sided() const { return one_sided_; }

  /// A corner of a face whose own vertex is replaced by a copy of it.
  struct CopiedCorner {
    LocalIndex face;
    LocalIndex slot;
    LocalIndex copy;  ///< into copies()
  };
  /// Own vertices (local) that are copied, once a copy.
  const std::vector<LocalIndex>& copies() const { return copies_; }
  const std::vector<CopiedCorner>& copied_corners() const { return copied_corners_; }

 private:
  struct HalfEdge {
    LocalIndex low, high;  // ends
    LocalIndex corner;     // 4 * face + slot, opposite to it
    bool upward;           // runs from low to high
  };

  void drop_duplicates();
  void list_half_edges();
  void join_faces();
  void join_across(const HalfEdge& a, const HalfEdge& b);
  void join_pairs(std::span<const HalfEdge> edges);
  void number_components();
  void find_fans();
  void split(LocalIndex vertex);
  bool is_home(LocalIndex face) const { return face < segment_->home_faces; }
  std::pair<VertexId, VertexId> ends(const HalfEdge& edge) const;

  const Segment* segment_ = nullptr;
  EdgeRule rule_ = EdgeRule::kCut;
  Defects defects_;
  DefectPlaces places_;
  std::vector<std::uint8_t> dropped_;
  std::vector<HalfEdge> half_edge_;
  ParityForest faces_;
  ParityForest corners_;  // by 4 * face + slot; nothing is turned in it
  std::vector<std::uint32_t> component_;
  std::vector<std::uint8_t> turned_;
  std::uint32_t components_ = 0;
  std::optional<std::pair<VertexId, VertexId>> one_sided_;
  std::vector<LocalIndex> copies_;
  std::vector<CopiedCorner> copied_corners_;
  std::vector<std::pair<LocalIndex, std::uint32_t>> around_;  // vertex, corner
  std::vector<std::pair<std::uint32_t, std::uint32_t>> fan_;  // root, corner
};

}  // namespace remaps::repair
