// write_plain_mesh INPUT OUTPUT.ply: any mesh that remaps reads as the binary PLY that the peers
// read, positions as floats, polygons cut into triangles, nothing else changed.
#include <fmt/format.h>

#include <exception>

#include "peers/ply_arrays.h"
#include "remaps/formats/mesh_reader.h"

namespace {

using namespace remaps;

peers::MeshArrays read(const char* path) {
  const auto reader = open_mesh_reader(path);
  peers::MeshArrays mesh;
  reader->read_positions([&](std::span<const Vec3> chunk) {
    for (const Vec3& p : chunk) {
      const Vec3f f = to_float(p);
      mesh.coordinates.insert(mesh.coordinates.end(), {f.x, f.y, f.z});
    }
  });
  const std::size_t vertices = mesh.coordinates.size() / 3;
  reader->read_triangles([&](std::span<const Triangle> chunk) {
    for (const Triangle& t : chunk) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (t[k] >= vertices) throw std::runtime_error(fmt::format("{}: no vertex {}", path, t[k]));
        mesh.corners.push_back(static_cast<std::uint32_t>(t[k]));
      }
    }
  });
  return mesh;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: write_plain_mesh INPUT OUTPUT.ply\n");
    return 2;
  }
  try {
    peers::write_ply(argv[2], read(argv[1]));
  } catch (const std::exception& error) {
    fmt::print(stderr, "write_plain_mesh: {}\n", error.what());
    return 1;
  }
}
