#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/retriangulation.h"

namespace remaps {

/// Three local vertex indices.
using LocalTriangle = std::array<LocalIndex, 3>;

/// A corner of a face as one number: 4 * face + (0, 1, 2), so that taking it apart is a shift.
inline LocalIndex corner_of(LocalIndex face, LocalIndex slot) {
  return 4 * face + slot;
}
inline LocalIndex face_of(LocalIndex corner) {
  return corner >> 2;
}
inline LocalIndex slot_of(LocalIndex corner) {
  return corner & 3;
}
/// The corner that follows c in the order of faces.
inline LocalIndex after_corner(LocalIndex c) {
  return slot_of(c) == 2 ? c + 2 : c + 1;
}
/// The corners of one face, counter-clockwise and back.
inline LocalIndex next_corner(LocalIndex c) {
  return slot_of(c) == 2 ? c - 2 : c + 1;
}
inline LocalIndex previous_corner(LocalIndex c) {
  return slot_of(c) == 0 ? c + 2 : c - 1;
}

/// The 1-ring of a vertex: wedge i is the face of corner[i], its outer edge runs from ring[i] to
/// ring[i + 1] (modulo n for an interior vertex; n = wedges at an interior vertex, wedges + 1 at a
/// boundary one).
struct Star {
  unsigned wedges = 0;
  bool boundary = false;
  std::array<LocalIndex, kMaxStarFaces> corner{};
  /// Filled up to a multiple of 4 with kNoIndex.
  alignas(16) std::array<LocalIndex, kMaxRing + 1> ring{};

  unsigned ring_size() const { return wedges + (boundary ? 1u : 0u); }
};

/// Why a triangle set is no manifold patch, and where. Vertices are local.
struct ManifoldDefect {
  enum class Kind { kNone, kDegenerateFace, kEdgeFaces, kOrientation, kVertexFans, kSameCorners };
  Kind kind = Kind::kNone;
  LocalIndex vertex_a = kNoIndex;
  LocalIndex vertex_b = kNoIndex;
};

/// A piece of a triangle mesh in memory: corner table with adjacency, for local operators. Face ids
/// are stable: an operator reuses the ids of the star that it changes. Memory: 56 B a face + 13 B a
/// vertex. Buffers are kept from one `build` to the next.
class Patch {
 public:
  /// Takes a set of triangles and finds their adjacency.
  ///
  /// @param vertices   number of vertices; every index is below it
  /// @param own        the first `own` vertices have their whole star among the triangles; of the
  /// others part may be
  ///                   missing, and they are not checked
  /// @param triangles  (f)
  /// @return  the first defect found (by face, then by vertex), or kNone. After a defect the patch
  /// is unusable. Cost: linear.
  ManifoldDefect build(std::size_t vertices, std::size_t own,
                       std::span<const LocalTriangle> triangles);

  std::size_t vertex_slots() const { return first_corner_.size(); }
  std::size_t face_slots() const { return face_.size(); }

  bool face_alive(LocalIndex f) const { return face_[f].vertex[0] != kNoIndex; }
  /// False for a removed vertex and for one without faces.
  bool vertex_alive(LocalIndex v) const { return first_corner_[v] != kNoIndex; }
  LocalTriangle face(LocalIndex f) const {
    const auto& v = face_[f].vertex;
    return {v[0], v[1], v[2]};
  }
  LocalIndex corner_vertex(LocalIndex c) const { return face_[face_of(c)].vertex[slot_of(c)]; }
  /// The corner across the edge opposite to c, or kNoIndex at the patch's boundary.
  LocalIndex opposite(LocalIndex c) const { return face_[face_of(c)].opposite[slot_of(c)]; }
  /// Number of edges at v.
  unsigned valence(LocalIndex v) const { return valence_[v]; }
  bool on_boundary(LocalIndex v) const { return boundary_[v] != 0; }

  /// The star of v, counter-clockwise, starting at a fixed place: the boundary if there is one.
  /// @return  false when v has more than kMaxStarFaces edges
  bool star(LocalIndex v, Star& out) const;

  /// True when a and b are joined by an edge. Cost: valence of a.
  bool has_edge(LocalIndex a, LocalIndex b) const;

  /// Calls visit(neighbour) for each neighbour of v, counter-clockwise.
  template <class Visit>
  void for_each_neighbour(LocalIndex v, Visit&& visit) const {
    const LocalIndex first = first_corner_[v];
    if (first == kNoIndex) return;
    LocalIndex c = first;
    while (true) {
      visit(corner_vertex(next_corner(c)));
      const LocalIndex across = opposite(next_corner(c));
      if (across == kNoIndex) {
        visit(corner_vertex(previous_corner(c)));
        return;
      }
      c = next_corner(across);
      if (c == first) return;
    }
  }

  /// True when filling the star of v by the fan about ring[apex] keeps the surface a manifold of
  /// the same topology: no new edge exists already, and no two faces get the same vertices (link
  /// condition).
  bool fan_keeps_topology(const Star& star, unsigned apex) const;

  /// Removes the vertex whose star is given and fills the hole with the fan about ring[apex], face
  /// ids as in Retriangulation. Requires fan_keeps_topology. Marks are carried: edges of the ring
  /// keep theirs, and a feature that runs through the vertex to ring[apex] and on to another ring
  /// point runs along the edge between the two afterwards.
  void retriangulate(LocalIndex v, const Star& star, unsigned apex);

  /// Marks edges as features, until the next `build`.
  ///
  /// @param marks  (f) bit i is for the edge opposite to corner i; both faces of an edge must
  /// agree.
  ///               Higher bits are kept with the face as long as it lives.
  void mark_features(std::span<const std::uint8_t> marks);
  bool has_features() const { return has_features_; }
  std::uint8_t marks(LocalIndex f) const { return static_cast<std::uint8_t>(face_[f].vertex[3]); }
  /// True when the edge opposite to corner c is a feature. Requires has_features.
  bool is_feature(LocalIndex c) const {
    return ((face_[face_of(c)].vertex[3] >> slot_of(c)) & 1u) != 0;
  }
  /// Takes the mark off an edge, in both its faces.
  void clear_feature(LocalIndex c);

 private:
  /// Corners and what lies across from them, side by side: half a cache line, which walks around a
  /// vertex need together.
  struct alignas(32) Face {
    std::array<LocalIndex, 4> vertex;    // the last holds marks, with has_features_
    std::array<LocalIndex, 4> opposite;  // corners; the last is unused
  };
  /// A half-edge in the list of those that leave its tail.
  struct HalfEdge {
    LocalIndex head;
    LocalIndex corner;  // opposite to it
  };

  void list_half_edges(std::span<const LocalTriangle> triangles);
  bool pair_half_edges();
  ManifoldDefect find_defect() const;
  ManifoldDefect check_vertices(std::size_t own);
  void link(LocalIndex a, LocalIndex b);
  void replace_star(LocalIndex v, const Star& star, unsigned apex);
  std::array<std::uint8_t, kMaxStarFaces> fan_marks(const Star& star, unsigned apex) const;
  LocalIndex clockwise_most(LocalIndex corner) const;

  bool has_features_ = false;
  std::vector<Face> face_;
  std::vector<LocalIndex> first_corner_;      // (vertices)
  std::vector<std::uint32_t> valence_;        // (vertices)
  std::vector<std::uint8_t> boundary_;        // (vertices)
  std::vector<std::uint32_t> leaving_start_;  // (vertices + 1)
  std::vector<HalfEdge> leaving_;             // by tail
};

}  // namespace remaps
