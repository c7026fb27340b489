#include "support/cut_shape.h"

#include <numeric>

namespace remaps::test {

std::vector<Vec3f> float_positions(const Shape& shape) {
  std::vector<Vec3f> positions;
  for (const Vec3& p : shape.position) positions.push_back(to_float(p));
  return positions;
}

Segment whole_segment(const Shape& shape) {
  Segment s;
  s.position = float_positions(shape);
  s.vertex_id.resize(s.position.size());
  std::iota(s.vertex_id.begin(), s.vertex_id.end(), VertexId{0});
  s.triangle = shape.triangle;
  s.face_id.resize(s.triangle.size());
  std::iota(s.face_id.begin(), s.face_id.end(), FaceId{0});
  s.locked.assign(s.position.size(), 0);
  s.own_vertices = static_cast<LocalIndex>(s.position.size());
  s.home_faces = static_cast<LocalIndex>(s.triangle.size());
  return s;
}

std::unique_ptr<DomainLevel> cut_shape(const Shape& shape, std::size_t segments, unsigned level,
                                       const std::filesystem::path& directory,
                                       MemoryBudget& budget) {
  const std::vector<Vec3f> positions = float_positions(shape);
  std::vector<Vec3f> sample = positions;
  auto result = std::make_unique<DomainLevel>(level, SpaceCut(sample, segments, level), directory,
                                              1 << 16, budget);
  const auto routed = [&](LocalIndex v) {
    return RoutedVertex{v, positions[v], result->cut().segment_of(positions[v])};
  };
  for (LocalIndex v = 0; v < positions.size(); ++v) {
    Quadric quadric;
    quadric.q[9] = static_cast<float>(v);
    result->add_vertex(routed(v), quadric);
  }
  for (LocalIndex f = 0; f < shape.triangle.size(); ++f) {
    const LocalTriangle& t = shape.triangle[f];
    result->add_face({routed(t[0]), routed(t[1]), routed(t[2])},
                     {f, static_cast<float>(f), {f % 7, f}});
  }
  return result;
}

}  // namespace remaps::test
