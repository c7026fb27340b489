#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "remaps/base/progress.h"
#include "remaps/mesh/topology.h"
#include "remaps/pipeline/report.h"
#include "remaps/repair/segment_analysis.h"

namespace remaps::pipeline {

struct CheckOptions {
  std::filesystem::path input;
  std::filesystem::path temp_dir;       ///< empty: the system's
  std::optional<double> weld_distance;  ///< as for remesh
  std::uint64_t memory_bytes = 256u << 20;
  unsigned threads = 0;
};

/// What a mesh file holds, and what a remesh would have to repair.
struct MeshCheck {
  std::uint64_t vertices = 0, faces = 0;  ///< of the file; faces as triangles
  double diagonal = 0;                    ///< of the box of the finite vertices
  Repairs repairs;                        ///< that a remesh would make
  repair::Defects defects;
  repair::DefectPlaces places;
  std::vector<VertexId> nonfinite;  ///< the first few vertices that are not finite
  /// Where the surface shows that it has one side only; empty if it can be oriented. Then there is
  /// no topology.
  std::string one_sided;
  Topology topology;  ///< of the repaired surface

  bool sound() const {
    return !defects.any() && one_sided.empty() && repairs.nonfinite_vertices == 0 &&
           repairs.degenerate_faces == 0;
  }
};

/// Reads a mesh of any size and looks for everything that remesh repairs or refuses.
/// Cost: about as much as the first sweep's reading and writing, twice.
/// @throws InputError, GeometryError (no vertices or faces), BudgetError, Cancelled
MeshCheck check_mesh(const CheckOptions& options, Progress& progress);

}  // namespace remaps::pipeline
