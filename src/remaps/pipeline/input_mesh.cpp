#include "remaps/pipeline/input_mesh.h"

#include <utility>

#include "remaps/formats/mesh_reader.h"
#include "remaps/pipeline/weld.h"

namespace remaps::pipeline {

InputMesh open_input_mesh(const std::filesystem::path& path, const InputMeshOptions& options,
                          MemoryBudget& budget, Progress& progress) {
  std::unique_ptr<IndexedMeshReader> reader = open_mesh_reader(path, &budget);
  if (!options.weld_distance && reader->vertex_sharing() == VertexSharing::shared) {
    return {std::move(reader), 0};
  }
  progress.begin("weld");
  std::unique_ptr<WeldedMesh> welded = weld_vertices(
      *reader, {options.weld_distance.value_or(0), options.directory, options.memory_bytes}, budget,
      progress);
  const std::uint64_t count = welded->welded_vertices();
  welded->carry_attributes(std::move(reader));
  return {std::move(welded), count};
}

}  // namespace remaps::pipeline
