#include "remaps/repair/segment_analysis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace remaps::repair {
namespace {

template <class T>
void add_some(std::vector<T>& to, const std::vector<T>& from) {
  for (const T& place : from) {
    if (to.size() == DefectPlaces::kMost) return;
    to.push_back(place);
  }
}

template <class T>
void add_one(std::vector<T>& to, const T& place) {
  if (to.size() < DefectPlaces::kMost) to.push_back(place);
}

}  // namespace

void DefectPlaces::add(const DefectPlaces& other) {
  add_some(duplicate_faces, other.duplicate_faces);
  add_some(nonmanifold_edges, other.nonmanifold_edges);
  add_some(misoriented_edges, other.misoriented_edges);
  add_some(nonmanifold_vertices, other.nonmanifold_vertices);
}

void SegmentAnalysis::run(const Segment& segment, EdgeRule rule) {
  segment_ = &segment;
  rule_ = rule;
  defects_ = {};
  places_ = {};
  one_sided_.reset();
  drop_duplicates();
  list_half_edges();
  join_faces();
  number_components();
  find_fans();
}

/// Faces with the same corners meet at each of them, so each segment with one of the corners has
/// all of them.
void SegmentAnalysis::drop_duplicates() {
  const Segment& s = *segment_;
  dropped_.assign(s.triangle.size(), 0);
  struct Key {
    LocalTriangle corner;  // ascending
    LocalIndex face;
  };
  std::vector<Key> keys(s.triangle.size());
  for (LocalIndex f = 0; f < keys.size(); ++f) {
    keys[f] = {s.triangle[f], f};
    std::sort(keys[f].corner.begin(), keys[f].corner.end());
  }
  std::sort(keys.begin(), keys.end(), [&](const Key& a, const Key& b) {
    return std::tie(a.corner, s.face_id[a.face]) < std::tie(b.corner, s.face_id[b.face]);
  });
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].corner != keys[i - 1].corner) continue;
    const LocalIndex f = keys[i].face;
    dropped_[f] = 1;
    if (!is_home(f)) continue;
    ++defects_.duplicate_faces;
    add_one(places_.duplicate_faces, std::uint64_t{s.face_id[f]});
  }
}

/// Half-edges with an own end: all faces at those are here.
void SegmentAnalysis::list_half_edges() {
  const Segment& s = *segment_;
  half_edge_.clear();
  for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
    if (dropped_[f]) continue;
    for (LocalIndex i = 0; i < 3; ++i) {
      const LocalIndex a = s.triangle[f][(i + 1) % 3];
      const LocalIndex b = s.triangle[f][(i + 2) % 3];
      if (std::min(a, b) >= s.own_vertices) continue;
      half_edge_.push_back({std::min(a, b), std::max(a, b), corner_of(f, i), a < b});
    }
  }
  std::sort(half_edge_.begin(), half_edge_.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
  });
}

std::pair<VertexId, VertexId> SegmentAnalysis::ends(const HalfEdge& edge) const {
  const VertexId a = segment_->vertex_id[edge.low];
  const VertexId b = segment_->vertex_id[edge.high];
  return {std::min(a, b), std::max(a, b)};
}

void SegmentAnalysis::join_faces() {
  const Segment& s = *segment_;
  faces_.clear();
  faces_.grow(s.triangle.size());
  corners_.clear();
  corners_.grow(4 * s.triangle.size());
  for (std::size_t i = 0; i < half_edge_.size();) {
    std::size_t end = i + 1;
    while (end < half_edge_.size() && half_edge_[end].low == half_edge_[i].low &&
           half_edge_[end].high == half_edge_[i].high)
      ++end;
    // An edge between segments is counted in that of its end of the lower number.
    const HalfEdge& edge = half_edge_[i];
    const bool lower_own =
        edge.high < s.own_vertices || s.vertex_id[edge.low] < s.vertex_id[edge.high];
    if (end - i == 2) {
      const HalfEdge& other = half_edge_[i + 1];
      join_across(edge, other);
      if (edge.upward == other.upward && lower_own) {
        ++defects_.misoriented_edges;
        add_one(places_.misoriented_edges, ends(edge));
      }
    } else if (end - i > 2) {
      if (rule_ == EdgeRule::kPair) join_pairs({half_edge_.data() + i, end - i});
      if (lower_own) {
        ++defects_.nonmanifold_edges;
        add_one(places_.nonmanifold_edges, ends(edge));
      }
    }
    i = end;
  }
}

void SegmentAnalysis::join_across(const HalfEdge& a, const HalfEdge& b) {
  if (!faces_.unite(face_of(a.corner), face_of(b.corner), a.upward == b.upward) && !one_sided_)
    one_sided_ = ends(a);
  // The corners of both faces at each end are in one fan.
  const auto corner_at = [&](const HalfEdge& edge, LocalIndex vertex) {
    const LocalIndex next = next_corner(edge.corner);
    return segment_->triangle[face_of(next)][slot_of(next)] == vertex
               ? next
               : previous_corner(edge.corner);
  };
  for (const LocalIndex vertex : {a.low, a.high}) {
    if (vertex < segment_->own_vertices)
      corners_.unite(corner_at(a, vertex), corner_at(b, vertex), false);
  }
}

/// Joins the faces of an edge in pairs that bound a wedge of the inside: seen along the edge from
/// its end of lower number, the inside lies behind a face that runs down and before one that runs
/// up, counter-clockwise. Positions and numbers decide, which are the same in all segments.
void SegmentAnalysis::join_pairs(std::span<const HalfEdge> edges) {
  const Segment& s = *segment_;
  const HalfEdge& edge = edges.front();
  const bool low_first = s.vertex_id[edge.low] < s.vertex_id[edge.high];
  const Vec3 from = widen(s.position[low_first ? edge.low : edge.high]);
  const Vec3 axis = widen(s.position[low_first ? edge.high : edge.low]) - from;
  struct Sheet {
    double angle;
    FaceId face;
    const HalfEdge* edge;
  };
  std::vector<Sheet> sheets;
  for (const HalfEdge& e : edges) sheets.push_back({0, s.face_id[face_of(e.corner)], &e});
  std::sort(sheets.begin(), sheets.end(),
            [](const Sheet& a, const Sheet& b) { return a.face < b.face; });
  const auto out_of_edge = [&](const HalfEdge& e) {
    const Vec3 p = widen(s.position[s.triangle[face_of(e.corner)][slot_of(e.corner)]]);
    return cross(axis, p - from);
  };
  const Vec3 first = out_of_edge(*sheets.front().edge);
  for (Sheet& sheet : sheets) {
    const Vec3 other = out_of_edge(*sheet.edge);
    sheet.angle = std::atan2(dot(axis, cross(first, other)), norm(axis) * dot(first, other));
  }
  std::sort(sheets.begin(), sheets.end(), [](const Sheet& a, const Sheet& b) {
    return std::tie(a.angle, a.face) < std::tie(b.angle, b.face);
  });
  // As brackets around the edge: one that opens is matched by the next that closes.
  std::vector<const HalfEdge*> open;
  for (std::size_t i = 0; i < 2 * sheets.size(); ++i) {
    const Sheet& sheet = sheets[i % sheets.size()];
    if (sheet.edge == nullptr) continue;
    const bool up = sheet.edge->upward == low_first;
    if (!up) {
      if (i < sheets.size()) open.push_back(sheet.edge);
      continue;
    }
    if (open.empty()) continue;
    join_across(*open.back(), *sheet.edge);
    open.pop_back();
    sheets[i % sheets.size()].edge = nullptr;
  }
}

void SegmentAnalysis::number_components() {
  const std::size_t faces = segment_->triangle.size();
  component_.assign(faces, kNoIndex);
  turned_.assign(faces, 0);
  components_ = 0;
  for (LocalIndex f = 0; f < faces; ++f) {
    if (dropped_[f]) continue;
    const ParityForest::Place place = faces_.find(f);  // its root is no higher than f
    component_[f] = place.root == f ? components_++ : component_[place.root];
    turned_[f] = place.turned;
  }
}

void SegmentAnalysis::find_fans() {
  const Segment& s = *segment_;
  copies_.clear();
  copied_corners_.clear();
  around_.clear();
  for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
    if (dropped_[f]) continue;
    for (LocalIndex i = 0; i < 3; ++i) {
      const LocalIndex v = s.triangle[f][i];
      if (v < s.own_vertices) around_.emplace_back(v, corner_of(f, i));
    }
  }
  std::sort(around_.begin(), around_.end());
  for (std::size_t i = 0; i < around_.size();) {
    const LocalIndex v = around_[i].first;
    fan_.clear();
    for (; i < around_.size() && around_[i].first == v; ++i)
      fan_.emplace_back(corners_.find(around_[i].second).root, around_[i].second);
    split(v);
  }
}

/// Gives copies of a vertex to all its fans but the largest; of equals the one with the face of the
/// lowest number keeps it.
void SegmentAnalysis::split(LocalIndex vertex) {
  const auto same_fan = [](const auto& a, const auto& b) { return a.first == b.first; };
  if (std::all_of(fan_.begin(), fan_.end(), [&](const auto& c) { return same_fan(c, fan_[0]); }))
    return;
  std::sort(fan_.begin(), fan_.end());
  struct Run {
    std::size_t begin, end;
    std::uint64_t first_face;
  };
  std::vector<Run> runs;
  for (std::size_t i = 0; i < fan_.size(); ++i) {
    if (i == 0 || !same_fan(fan_[i], fan_[i - 1])) runs.push_back({i, i, ~std::uint64_t{0}});
    runs.back().end = i + 1;
    runs.back().first_face =
        std::min<std::uint64_t>(runs.back().first_face, segment_->face_id[face_of(fan_[i].second)]);
  }
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
    const std::size_t size_a = a.end - a.begin;
    const std::size_t size_b = b.end - b.begin;
    return size_a != size_b ? size_a > size_b : a.first_face < b.first_face;
  });
  ++defects_.nonmanifold_vertices;
  add_one(places_.nonmanifold_vertices, VertexId{segment_->vertex_id[vertex]});
  for (std::size_t r = 1; r < runs.size(); ++r) {
    const auto copy = static_cast<LocalIndex>(copies_.size());
    copies_.push_back(vertex);
    for (std::size_t i = runs[r].begin; i < runs[r].end; ++i)
      copied_corners_.push_back({face_of(fan_[i].second), slot_of(fan_[i].second), copy});
  }
}

}  // namespace remaps::repair
