#include "remaps/pipeline/input_mesh.h"

#include <utility>

#include "remaps/formats/mesh_reader.h"
#include "remaps/pipeline/weld.h"

namespace remaps::pipeline {

namespace {

/// Faces keep their order when vertices are welded, so that labels are read before that.
void spool_labels(IndexedMeshReader& reader, const InputMeshOptions& options,
                  const std::string& file, InputMesh& mesh) {
  mesh.label_names = options.labels.choose(reader.face_labels(), file);
  if (mesh.label_names.empty()) return;
  mesh.face_labels =
      std::make_unique<store::RowSpool>(options.directory / "face-labels", sizeof(FaceLabel));
  reader.read_face_labels(mesh.label_names, [&](std::span<const FaceLabel> labels) {
    mesh.face_labels->append(std::as_bytes(labels));
  });
}

}  // namespace

InputMesh open_input_mesh(const std::filesystem::path& path, const InputMeshOptions& options,
                          MemoryBudget& budget, Progress& progress) {
  InputMesh mesh;
  std::unique_ptr<IndexedMeshReader> reader = open_mesh_reader(path, &budget);
  if (!options.labels.none()) {
    progress.begin("labels");
    spool_labels(*reader, options, path.string(), mesh);
  }
  if (!options.weld_distance && reader->vertex_sharing() == VertexSharing::shared) {
    mesh.reader = std::move(reader);
    return mesh;
  }
  progress.begin("weld");
  std::unique_ptr<WeldedMesh> welded = weld_vertices(
      *reader, {options.weld_distance.value_or(0), options.directory, options.memory_bytes}, budget,
      progress);
  mesh.welded_vertices = welded->welded_vertices();
  welded->carry_attributes(std::move(reader));
  mesh.reader = std::move(welded);
  return mesh;
}

}  // namespace remaps::pipeline
