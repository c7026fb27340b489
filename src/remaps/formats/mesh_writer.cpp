#include "remaps/formats/mesh_writer.h"

#include <fmt/format.h>

#include "remaps/base/errors.h"
#include "remaps/formats/file_extension.h"
#include "remaps/formats/format_factories.h"

namespace remaps {

bool is_writable_mesh(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".ply" || extension == ".obj";
}

std::unique_ptr<IndexedMeshWriter> open_mesh_writer(const std::filesystem::path& path,
                                                    std::uint64_t vertices, std::uint64_t faces) {
  const std::string extension = lower_extension(path);
  if (extension == ".ply") return make_ply_writer(path, vertices, faces);
  if (extension == ".obj") return make_obj_writer(path, vertices, faces);
  throw InputError(
      fmt::format("{}: cannot write a mesh with extension '{}', supported are .ply, .obj",
                  path.string(), extension));
}

}  // namespace remaps
