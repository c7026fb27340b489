#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/indexed_stream.h"
#include "remaps/store/row_spool.h"

namespace remaps::pipeline {

struct InputMeshOptions {
  std::filesystem::path directory;      ///< for temporary files
  std::uint64_t memory_bytes = 0;       ///< of the budget, for welding; given back afterwards
  std::optional<double> weld_distance;  ///< in file units; none: only what shares no vertices
  FaceLabelChoice labels = {};          ///< of faces, that are wanted
};

struct InputMesh {
  std::unique_ptr<IndexedMeshReader> reader;
  std::uint64_t welded_vertices = 0;
  std::vector<std::string> label_names = {};          ///< those wanted that are there
  std::unique_ptr<store::RowSpool> face_labels = {};  ///< a FaceLabel a face; null without names
};

/// Opens a mesh file as the other stages want it: faces that touch share vertices. A format that
/// has none to share (STL) is welded by exactly equal positions, any format by a distance if one is
/// given.
/// @throws  as open_mesh_reader and weld_vertices
InputMesh open_input_mesh(const std::filesystem::path& path, const InputMeshOptions& options,
                          MemoryBudget& budget, Progress& progress);

}  // namespace remaps::pipeline
