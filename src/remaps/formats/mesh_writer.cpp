#include "remaps/formats/mesh_writer.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/formats/file_extension.h"
#include "remaps/formats/format_factories.h"

namespace remaps {

bool is_writable_mesh(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  for (const std::string_view known : {".ply", ".obj", ".off", ".stl", ".glb", ".vtp"}) {
    if (extension == known) return true;
  }
  return false;
}

void check_mesh_size(const std::filesystem::path& path, std::uint64_t vertices,
                     std::uint64_t faces) {
  const std::string extension = lower_extension(path);
  if (extension == ".stl") check_stl_size(path, faces);
  if (extension == ".glb") check_glb_size(path, vertices, faces);
}

std::unique_ptr<IndexedMeshWriter> open_mesh_writer(const std::filesystem::path& path,
                                                    std::uint64_t vertices, std::uint64_t faces,
                                                    const MeshWriterOptions& options) {
  check_mesh_size(path, vertices, faces);
  const std::string extension = lower_extension(path);
  if (extension == ".ply") return make_ply_writer(path, vertices, faces, options.attributes);
  if (extension == ".obj") return make_obj_writer(path, vertices, faces, options.attributes);
  if (extension == ".off") return make_off_writer(path, vertices, faces, options.attributes);
  if (extension == ".stl") return make_stl_writer(path, vertices, faces);
  if (extension == ".glb") return make_glb_writer(path, vertices, faces, options.attributes);
  if (extension == ".vtp") return make_vtp_writer(path, vertices, faces, options);
  throw InputError(fmt::format("{}: cannot write a mesh with extension '{}', supported are {}",
                               path.string(), extension, kWritableMeshes));
}

}  // namespace remaps
