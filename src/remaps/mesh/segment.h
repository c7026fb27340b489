#pragma once

#include <cstdint>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/face_labels.h"
#include "remaps/mesh/patch.h"
#include "remaps/mesh/quadric.h"

namespace remaps {

/// One segment of a level's domain mesh, in memory: what a sweep simplifies at a time.
///
/// Each vertex of a level belongs to one segment (a pure function of its position). The segment
/// holds its own vertices, every face with at least one of them, and the foreign vertices of those
/// faces. A face with corners of several segments is at home in the lowest of them and a ghost in
/// the others. Own vertices whose whole star is at home, with all corners own, may be removed; the
/// rest is locked. So two segments never change the same face.
///
/// Order: own vertices before foreign ones, home faces before ghosts. The local id of a home face
/// is its number in the level's domain and log; ghosts appear in no record.
struct Segment {
  std::vector<VertexId> vertex_id;      ///< (v) global ids: input vertex indices
  std::vector<Vec3f> position;          ///< (v)
  std::vector<Quadric> quadric;         ///< (v) meaningful for own vertices
  std::vector<LocalTriangle> triangle;  ///< (f)
  std::vector<FaceId> face_id;          ///< (f) first level: input face indices; empty afterwards
  std::vector<float> load;  ///< (f) predicted squared sampling error, see simplify/sampling_load.h
  std::vector<std::uint8_t> locked;  ///< (v)
  /// (f) which edges are features, see simplify/feature_edges.h; empty when none are kept, and at
  /// the first level before they are found.
  std::vector<std::uint8_t> feature;
  /// (f) what faces belong to; empty unless features lie between labels. After the first level only
  /// faces with an edge that is not yet known as a feature or none have theirs, others kNoLabel.
  std::vector<FaceLabel> label;
  LocalIndex own_vertices = 0;
  LocalIndex home_faces = 0;

  void clear() {
    vertex_id.clear();
    position.clear();
    quadric.clear();
    triangle.clear();
    face_id.clear();
    load.clear();
    locked.clear();
    feature.clear();
    label.clear();
    own_vertices = home_faces = 0;
  }
};

}  // namespace remaps
