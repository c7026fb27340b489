#include "remaps/mesh/patch.h"

#include <algorithm>

#include "remaps/base/simd.h"

namespace remaps {

ManifoldDefect Patch::build(std::size_t vertices, std::size_t own,
                            std::span<const LocalTriangle> triangles) {
  has_features_ = false;
  face_.resize(triangles.size());
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const LocalTriangle& t = triangles[f];
    face_[f] = {{t[0], t[1], t[2], kNoIndex}, {kNoIndex, kNoIndex, kNoIndex, kNoIndex}};
  }
  first_corner_.assign(vertices, kNoIndex);
  valence_.assign(vertices, 0);
  boundary_.assign(vertices, 0);
  for (const LocalTriangle& t : triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      return {ManifoldDefect::Kind::kDegenerateFace, t[0], t[1] == t[0] ? t[2] : t[1]};
    }
  }
  list_half_edges(triangles);
  if (!pair_half_edges()) return find_defect();
  const ManifoldDefect defect = check_vertices(own);
  if (defect.kind == ManifoldDefect::Kind::kNone) return defect;
  // Faces oriented against each other have no twins, so they look like fans that touch: an edge
  // says more.
  const ManifoldDefect at_edge = find_defect();
  return at_edge.kind != ManifoldDefect::Kind::kNone ? at_edge : defect;
}

/// Lists the half-edges that leave each vertex, by counting sort.
void Patch::list_half_edges(std::span<const LocalTriangle> triangles) {
  leaving_start_.assign(first_corner_.size() + 1, 0);
  for (const LocalTriangle& t : triangles) {
    for (const LocalIndex v : t) ++leaving_start_[v];
  }
  std::uint32_t end = 0;
  for (std::uint32_t& start : leaving_start_) {
    end += start;
    start = end;
  }
  leaving_.resize(3 * triangles.size());
  for (LocalIndex f = static_cast<LocalIndex>(triangles.size()); f-- > 0;) {
    const LocalTriangle& t = triangles[f];
    leaving_[--leaving_start_[t[2]]] = {t[0], corner_of(f, 1)};
    leaving_[--leaving_start_[t[1]]] = {t[2], corner_of(f, 0)};
    leaving_[--leaving_start_[t[0]]] = {t[1], corner_of(f, 2)};
  }
}

/// Joins each half-edge with the one that runs back.
/// @return  false when a half-edge finds its twin taken: more than two faces at an edge
bool Patch::pair_half_edges() {
  for (LocalIndex tail = 0; tail < first_corner_.size(); ++tail) {
    for (auto i = leaving_start_[tail]; i < leaving_start_[tail + 1]; ++i) {
      const auto [head, corner] = leaving_[i];
      if (head < tail) continue;
      LocalIndex twin = kNoIndex;
      for (auto k = leaving_start_[head]; k < leaving_start_[head + 1]; ++k) {
        if (leaving_[k].head != tail) continue;
        if (twin != kNoIndex) return false;
        twin = leaving_[k].corner;
      }
      if (twin == kNoIndex) continue;
      if (opposite(twin) != kNoIndex) return false;
      link(corner, twin);
    }
  }
  return true;
}

/// The first edge, by face, that has more than two faces or two that are oriented alike.
ManifoldDefect Patch::find_defect() const {
  const auto count = [&](LocalIndex tail, LocalIndex head) {
    unsigned n = 0;
    for (auto i = leaving_start_[tail]; i < leaving_start_[tail + 1]; ++i)
      n += leaving_[i].head == head;
    return n;
  };
  const auto end = corner_of(static_cast<LocalIndex>(face_.size()), 0);
  for (LocalIndex c = 0; c < end; c = after_corner(c)) {
    const LocalIndex tail = corner_vertex(next_corner(c));
    const LocalIndex head = corner_vertex(previous_corner(c));
    const unsigned same = count(tail, head);
    const unsigned twins = count(head, tail);
    if (same + twins > 2) return {ManifoldDefect::Kind::kEdgeFaces, tail, head};
    if (same > 1) return {ManifoldDefect::Kind::kOrientation, tail, head};
  }
  return {};
}

/// Finds each vertex's first corner and counts its faces in one fan; a vertex with more faces than
/// its first fan holds is no manifold vertex.
ManifoldDefect Patch::check_vertices(std::size_t own) {
  for (LocalIndex v = 0; v < first_corner_.size(); ++v) {
    const std::uint32_t faces = leaving_start_[v + 1] - leaving_start_[v];
    if (faces == 0) continue;
    // The corner at the tail of a half-edge follows the one opposite to it.
    first_corner_[v] = clockwise_most(next_corner(leaving_[leaving_start_[v]].corner));
    std::uint32_t count = 0;
    LocalIndex c = first_corner_[v];
    while (true) {
      ++count;
      const LocalIndex across = opposite(next_corner(c));
      if (across == kNoIndex) {
        boundary_[v] = 1;
        break;
      }
      c = next_corner(across);
      if (c == first_corner_[v]) break;
    }
    if (v < own) {
      if (count != faces) return {ManifoldDefect::Kind::kVertexFans, v, v};
      // Two faces all around a vertex have the same corners.
      if (count == 2 && !boundary_[v]) return {ManifoldDefect::Kind::kSameCorners, v, v};
    }
    valence_[v] = count + boundary_[v];
  }
  return {};
}

LocalIndex Patch::clockwise_most(LocalIndex corner) const {
  LocalIndex c = corner;
  while (true) {
    const LocalIndex across = opposite(previous_corner(c));
    if (across == kNoIndex) return c;
    c = previous_corner(across);
    if (c == corner) return c;
  }
}

bool Patch::star(LocalIndex v, Star& out) const {
  if (valence_[v] > kMaxStarFaces) return false;
  const LocalIndex first = first_corner_[v];
  LocalIndex c = first;
  unsigned i = 0;
  out.boundary = boundary_[v] != 0;
  while (true) {
    out.corner[i] = c;
    out.ring[i] = corner_vertex(next_corner(c));
    ++i;
    const LocalIndex across = opposite(next_corner(c));
    if (across == kNoIndex) {
      out.ring[i] = corner_vertex(previous_corner(c));
      break;
    }
    c = next_corner(across);
    if (c == first) break;
  }
  out.wedges = i;
  for (unsigned end = out.ring_size(); end % kLanes != 0; ++end) out.ring[end] = kNoIndex;
  return true;
}

bool Patch::has_edge(LocalIndex a, LocalIndex b) const {
  bool found = false;
  for_each_neighbour(a, [&](LocalIndex x) { found |= x == b; });
  return found;
}

bool Patch::fan_keeps_topology(const Star& star, unsigned apex) const {
  const unsigned n = star.ring_size();
  if (n < 3) return false;
  if (star.boundary) {
    if (star.wedges < 2 || has_edge(star.ring[0], star.ring[n - 1])) return false;
  } else if (n == 3) {
    // The three outer faces must not be one and the same triangle.
    const LocalIndex across = opposite(star.corner[0]);
    if (across != kNoIndex && corner_vertex(across) == star.ring[2]) return false;
  }
  // Of the ring, the apex may have edges only to the points before and after it.
  Int4 count = all4(0);
  for_each_neighbour(star.ring[apex], [&](LocalIndex x) {
    const Int4 wanted = all4(static_cast<std::int32_t>(x));
    for (unsigned i = 0; i < n; i += kLanes) count -= load4(&star.ring[i]) == wanted;
  });
  const bool at_end = star.boundary && (apex == 0 || apex + 1 == n);
  return count[0] + count[1] + count[2] + count[3] == (at_end ? 1 : 2);
}

void Patch::link(LocalIndex a, LocalIndex b) {
  if (a != kNoIndex) face_[face_of(a)].opposite[slot_of(a)] = b;
  if (b != kNoIndex) face_[face_of(b)].opposite[slot_of(b)] = a;
}

void Patch::mark_features(std::span<const std::uint8_t> marks) {
  has_features_ = true;
  for (std::size_t f = 0; f < face_.size(); ++f) face_[f].vertex[3] = marks[f];
}

void Patch::clear_feature(LocalIndex c) {
  const LocalIndex across = opposite(c);
  face_[face_of(c)].vertex[3] &= ~(1u << slot_of(c));
  if (across != kNoIndex) face_[face_of(across)].vertex[3] &= ~(1u << slot_of(across));
}

/// Marks of the triangles of a fan, from those of the star that it replaces.
std::array<std::uint8_t, kMaxStarFaces> Patch::fan_marks(const Star& star, unsigned apex) const {
  const unsigned n = star.ring_size();
  std::array<unsigned, kMaxRing> outer{};
  std::array<unsigned, kMaxRing> spoke{};
  for (unsigned i = 0; i < star.wedges; ++i) {
    outer[i] = is_feature(star.corner[i]);
    spoke[i] = is_feature(previous_corner(star.corner[i]));
  }
  const auto wrap = [n](unsigned slot) { return slot >= n ? slot - n : slot; };
  // Of the fan's edge to the ring point `steps` after the apex.
  const auto from_apex = [&](unsigned steps) {
    if (steps == 1) return outer[apex];
    if (steps == n - 1) return outer[wrap(apex + steps)];
    return spoke[apex] & spoke[wrap(apex + steps)];
  };
  std::array<std::uint8_t, kMaxStarFaces> marks{};
  for (unsigned j = 0; j + 2 < n; ++j) {
    marks[j] = static_cast<std::uint8_t>(outer[wrap(apex + 1 + j)] | from_apex(j + 2) << 1 |
                                         from_apex(j + 1) << 2);
  }
  return marks;
}

void Patch::retriangulate(LocalIndex v, const Star& star, unsigned apex) {
  if (!has_features_) {
    replace_star(v, star, apex);
    return;
  }
  const auto marks = fan_marks(star, apex);
  replace_star(v, star, apex);
  for (unsigned j = 0; j + 2 < star.ring_size(); ++j) {
    face_[face_of(star.corner[j])].vertex[3] = marks[j];
  }
}

void Patch::replace_star(LocalIndex v, const Star& star, unsigned apex) {
  const unsigned n = star.ring_size();
  const unsigned triangles = n - 2;
  std::array<LocalIndex, kMaxRing> outer{};
  for (unsigned i = 0; i < star.wedges; ++i) outer[i] = opposite(star.corner[i]);
  if (star.boundary) outer[n - 1] = kNoIndex;
  const auto wrap = [n](unsigned slot) { return slot >= n ? slot - n : slot; };

  for (unsigned j = 0; j < triangles; ++j) {
    const LocalIndex f = face_of(star.corner[j]);
    face_[f] = {
        {star.ring[apex], star.ring[wrap(apex + 1 + j)], star.ring[wrap(apex + 2 + j)], kNoIndex},
        {kNoIndex, kNoIndex, kNoIndex, kNoIndex}};
  }
  for (unsigned j = 0; j < triangles; ++j) {
    const LocalIndex f = face_of(star.corner[j]);
    link(corner_of(f, 0), outer[wrap(apex + 1 + j)]);
    if (j > 0) link(corner_of(f, 2), corner_of(face_of(star.corner[j - 1]), 1));
  }
  link(corner_of(face_of(star.corner[0]), 2), outer[apex]);
  link(corner_of(face_of(star.corner[triangles - 1]), 1), outer[wrap(apex + n - 1)]);
  for (unsigned i = triangles; i < star.wedges; ++i) {
    face_[face_of(star.corner[i])].vertex.fill(kNoIndex);
    face_[face_of(star.corner[i])].opposite.fill(kNoIndex);
  }

  for (unsigned j = 0; j < triangles; ++j) {
    const LocalIndex f = face_of(star.corner[j]);
    for (LocalIndex i = 0; i < 3; ++i) first_corner_[face_[f].vertex[i]] = corner_of(f, i);
  }
  for (unsigned i = 0; i < n; ++i) {
    const LocalIndex x = star.ring[i];
    if (boundary_[x]) first_corner_[x] = clockwise_most(first_corner_[x]);
    --valence_[x];
  }
  if (star.boundary) {
    ++valence_[star.ring[0]];
    ++valence_[star.ring[n - 1]];
  }
  for (unsigned i = 2; i + 1 < n; ++i) {
    // Diagonals of the hole; the boundary edge was counted above.
    const unsigned slot = wrap(apex + i);
    ++valence_[star.ring[slot]];
    ++valence_[star.ring[apex]];
  }
  first_corner_[v] = kNoIndex;
  valence_[v] = 0;
}

}  // namespace remaps
