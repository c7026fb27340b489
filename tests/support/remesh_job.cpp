#include "support/remesh_job.h"

#include "remaps/formats/mesh_reader.h"
#include "remaps/formats/mesh_writer.h"

namespace remaps::test {

MeshLists lists_of(const Shape& shape) {
  MeshLists mesh{shape.position, {}};
  for (Vec3& p : mesh.position) p = widen(to_float(p));
  for (const LocalTriangle& t : shape.triangle) mesh.triangle.push_back({t[0], t[1], t[2]});
  return mesh;
}

MeshLists scan(BaseShape shape, std::uint64_t vertices, bool shuffled) {
  GeneratorOptions options;
  options.base = shape;
  options.vertices = vertices;
  options.shuffled = shuffled;
  const ScanGenerator generator(options);
  MeshLists mesh;
  for (VertexId v = 0; v < generator.vertices(); ++v)
    mesh.position.push_back(widen(to_float(generator.vertex(v))));
  for (FaceId f = 0; f < generator.faces(); ++f) mesh.triangle.push_back(generator.triangle(f));
  return mesh;
}

MeshLists read_lists(const std::filesystem::path& path) {
  MeshLists mesh;
  const auto reader = open_mesh_reader(path);
  reader->read_positions([&](std::span<const Vec3> chunk) {
    mesh.position.insert(mesh.position.end(), chunk.begin(), chunk.end());
  });
  reader->read_triangles([&](std::span<const Triangle> chunk) {
    mesh.triangle.insert(mesh.triangle.end(), chunk.begin(), chunk.end());
  });
  return mesh;
}

void write_lists(const MeshLists& mesh, const std::filesystem::path& path) {
  const auto writer = open_mesh_writer(path, mesh.position.size(), mesh.triangle.size());
  writer->write_positions(mesh.position);
  writer->write_triangles(mesh.triangle);
  writer->close();
}

pipeline::RemeshOptions remesh_options(const std::filesystem::path& directory,
                                       const std::filesystem::path& input) {
  pipeline::RemeshOptions options;
  options.input = input;
  options.output = directory / "out.ply";
  options.bundle = directory / "out.remaps";
  options.base_vertices = 60;
  options.level = 2;
  options.threads = 1;
  options.measure = false;
  options.memory_bytes = 64 << 20;
#ifdef REMAPS_FORCE_SPILL
  options.memory_bytes = 24 << 20;
  options.domain_buffer = kSmallDomainBuffer;
#endif
  return options;
}

}  // namespace remaps::test
