#include "codec/codec_shapes.h"

#include "remaps/generate/base_shapes.h"

namespace remaps::test {

CodecBase base_of(const Shape& shape) {
  CodecBase base{
      shape.name, shape.position, {}, shape.euler_characteristic, shape.boundary_loops > 0};
  for (const LocalTriangle& t : shape.triangle) base.face.push_back({t[0], t[1], t[2]});
  return base;
}

std::vector<CodecBase> codec_bases() {
  std::vector<CodecBase> bases;
  for (const Shape& shape :
       {tetrahedron(), octahedron(), icosphere(0), torus(3, 5), disk(3), annulus(7, 3), cone(3),
        cone(4), cone(9), bipyramid(3), bipyramid(5), bipyramid(12), bipyramid(14), cube(3),
        together(bipyramid(7), annulus(5, 1)), together(octahedron(), torus(3, 3))}) {
    bases.push_back(base_of(shape));
  }
  CodecBase genus_2{"double torus", {}, {}, -2, false};
  const ShapeMesh mesh = make_base_mesh(BaseShape::kDoubleTorus);
  genus_2.position = mesh.positions;
  for (const auto& t : mesh.triangles) {
    genus_2.face.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
                            static_cast<std::uint32_t>(t[2])});
  }
  bases.push_back(genus_2);
  return bases;
}

std::vector<codec::Face> finest_faces(const codec::SubdivisionHierarchy& hierarchy) {
  std::vector<codec::Face> faces;
  for (std::uint64_t f = 0; f < hierarchy.faces(); ++f) faces.push_back(hierarchy.finest_face(f));
  return faces;
}

std::vector<Vec3> random_values(std::size_t count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> value(-1, 1);
  std::vector<Vec3> result(count);
  for (Vec3& v : result) v = {value(random), value(random), value(random)};
  return result;
}

}  // namespace remaps::test
