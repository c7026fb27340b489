// peer_openmesh INPUT.ply FACES OUTPUT.ply: decimates with OpenMesh's quadric module to at most
// FACES triangles, and says as JSON what it reached. In core; keeps no map.
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <cstdlib>
#include <exception>

#include "ply_arrays.h"

namespace {

using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
using Decimater = OpenMesh::Decimater::DecimaterT<Mesh>;
using Quadric = OpenMesh::Decimater::ModQuadricT<Mesh>;

void build(const peers::MeshArrays& arrays, Mesh& mesh) {
  const std::size_t vertices = arrays.coordinates.size() / 3;
  const std::size_t faces = arrays.corners.size() / 3;
  mesh.reserve(vertices, vertices + faces, faces);
  for (std::size_t i = 0; i < vertices; ++i) {
    const float* p = &arrays.coordinates[3 * i];
    mesh.add_vertex(Mesh::Point(p[0], p[1], p[2]));
  }
  for (std::size_t i = 0; i < arrays.corners.size(); i += 3) {
    const auto corner = [&](std::size_t k) {
      return Mesh::VertexHandle(static_cast<int>(arrays.corners[i + k]));
    };
    if (!mesh.add_face(corner(0), corner(1), corner(2)).is_valid()) {
      throw std::runtime_error("OpenMesh refuses face " + std::to_string(i / 3));
    }
  }
}

peers::MeshArrays to_arrays(const Mesh& mesh) {
  peers::MeshArrays arrays;
  for (const auto v : mesh.vertices()) {
    const Mesh::Point& p = mesh.point(v);
    arrays.coordinates.insert(arrays.coordinates.end(), {p[0], p[1], p[2]});
  }
  for (const auto f : mesh.faces()) {
    for (const auto v : f.vertices()) {
      arrays.corners.push_back(static_cast<std::uint32_t>(v.idx()));
    }
  }
  return arrays;
}

peers::MeshArrays decimate(const peers::MeshArrays& input, std::size_t faces) {
  Mesh mesh;
  build(input, mesh);
  Decimater decimater(mesh);
  Quadric::Handle quadric;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
  if (!decimater.initialize()) throw std::runtime_error("OpenMesh's decimater does not start");
  decimater.decimate_to_faces(0, faces);
  mesh.garbage_collection();
  return to_arrays(mesh);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: peer_openmesh INPUT.ply FACES OUTPUT.ply\n");
    return 2;
  }
  try {
    const peers::MeshArrays result =
        decimate(peers::read_ply(argv[1]), std::strtoull(argv[2], nullptr, 10));
    peers::write_ply(argv[3], result);
    std::printf("{\"vertices\": %zu, \"faces\": %zu}\n", result.coordinates.size() / 3,
                result.corners.size() / 3);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "peer_openmesh: %s\n", error.what());
    return 1;
  }
}
