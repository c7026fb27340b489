#pragma once

#include <cstdint>
#include <filesystem>

#include "remaps/base/progress.h"
#include "remaps/pipeline/remesh.h"
#include "remaps/pipeline/sphere_files.h"

namespace remaps::pipeline {

struct MapSphereOptions {
  std::filesystem::path input;   ///< bundle or mesh
  std::filesystem::path output;  ///< bundle; appears, or replaces an earlier one, when all is well
  /// Of the base that a mesh gets: what is between the input and the sphere. A bundle's is as it
  /// is.
  std::uint64_t intermediate_faces = 50'000;
  bool all_components = false;  ///< a sphere each; otherwise the largest component only
  /// How a mesh is read and parameterized; of these, input, output, bundle and base_vertices are
  /// set by the above. Memory, threads and the directory for temporary files count for a bundle
  /// too.
  RemeshOptions parameterize;
};

struct MapSphereSummary {
  SphereManifest sphere;
  std::uint64_t input_vertices = 0;
  std::uint64_t base_components = 0;
};

/// Adds a spherical map to a bundle, or makes a bundle of a mesh with one. Out of core to the base,
/// in core from there to the sphere; together they carry every input vertex. Of a bundle, the
/// output has the same files (hard links, where the file system has them) and those of the sphere.
/// @throws GeometryError  the component is not closed, or its genus is not 0; and what remesh
/// throws
MapSphereSummary map_to_sphere(const MapSphereOptions& options, Progress& progress);

}  // namespace remaps::pipeline
