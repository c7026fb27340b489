// peer_meshoptimizer INPUT.ply FACES OUTPUT.ply: simplifies with meshoptimizer to at most FACES
// triangles, and says as JSON what it reached. In core; keeps no map.
#include <meshoptimizer.h>

#include <algorithm>
#include <cstdlib>
#include <exception>

#include "ply_arrays.h"

namespace {

/// No bound but the number of faces. Its square must be finite.
constexpr float kAnyError = 1e9f;

void simplify(peers::MeshArrays& mesh, std::size_t faces) {
  const std::size_t vertices = mesh.coordinates.size() / 3;
  std::vector<std::uint32_t> left(mesh.corners.size());
  left.resize(meshopt_simplify(left.data(), mesh.corners.data(), mesh.corners.size(),
                               mesh.coordinates.data(), vertices, 3 * sizeof(float),
                               std::min(3 * faces, mesh.corners.size()), kAnyError, 0, nullptr));
  mesh.corners = std::move(left);
  mesh.coordinates.resize(3 * meshopt_optimizeVertexFetch(
                                  mesh.coordinates.data(), mesh.corners.data(), mesh.corners.size(),
                                  mesh.coordinates.data(), vertices, 3 * sizeof(float)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: peer_meshoptimizer INPUT.ply FACES OUTPUT.ply\n");
    return 2;
  }
  try {
    peers::MeshArrays mesh = peers::read_ply(argv[1]);
    simplify(mesh, std::strtoull(argv[2], nullptr, 10));
    peers::write_ply(argv[3], mesh);
    std::printf("{\"vertices\": %zu, \"faces\": %zu}\n", mesh.coordinates.size() / 3,
                mesh.corners.size() / 3);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "peer_meshoptimizer: %s\n", error.what());
    return 1;
  }
}
