#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "remaps/base/progress.h"
#include "remaps/mesh/attributes.h"
#include "remaps/mesh/face_labels.h"
#include "remaps/mesh/topology.h"
#include "remaps/pipeline/report.h"

namespace remaps::pipeline {

struct RemeshOptions {
  std::filesystem::path input;
  std::filesystem::path output;       ///< in a format that is written; empty: parameterize only
  std::filesystem::path bundle;       ///< a directory NAME.remaps; empty: none is kept
  std::filesystem::path temp_dir;     ///< empty: beside the output or bundle
  std::uint64_t base_vertices = 200;  ///< at least 4
  unsigned level = 5;                 ///< subdivisions of the base, 0 to 14
  std::optional<unsigned> coarsest;   ///< one mesh a level from this to `level`, at level_path
  /// Edges between faces whose normals differ by more become chains of base edges; above 0, below
  /// 180. 0: none.
  double feature_angle_deg = 0;
  /// Edges between faces that differ in one of these labels do too.
  FaceLabelChoice feature_labels;
  std::uint64_t memory_bytes =
      256u << 20;  ///< peak memory of the run, without the constant 32 MiB of program and libraries
  unsigned threads = 0;  ///< 0: one a processor
  std::uint64_t domain_buffer =
      0;  ///< faces in memory at a time (the paper's Maxf); 0: from memory_bytes
  std::uint64_t map_buffer = 0;         ///< points in memory at a time (Maxv); 0: from memory_bytes
  bool strict = false;                  ///< refuse what would need repair
  std::uint64_t min_component = 0;      ///< faces; smaller components are dropped
  std::uint64_t fill_holes = 0;         ///< edges; holes of at most so many are filled
  std::optional<double> weld_distance;  ///< join vertices within this, in file units; none: only
                                        ///< those of formats without shared vertices (STL)
  bool measure = true;                  ///< measure the two-sided error of the output
  bool fit = false;                     ///< least-squares fit of the output's vertices to the input
  std::uint64_t samples = 1'000'000;    ///< of the error, each way
  AttributeChoice attributes;           ///< of the input, for output and bundle
  /// Called as soon as the repaired surface has been counted; may refuse it by an exception.
  std::function<void(const Topology&)> accept;
  /// Chooses the level, and a larger base if no level does; then `level` is not used.
  ErrorGoal goal;
};

/// The main job: from a mesh file to a semi-regular mesh, and the bundle with the map if wanted.
/// Nothing appears under a final name before it is complete; whatever ends the run early leaves
/// nothing behind.
///
/// @throws InputError, IoError, GeometryError (the surface, or an error that cannot be met),
///         BudgetError, Cancelled
Report remesh(const RemeshOptions& options, Progress& progress);

struct ResampleBundleOptions {
  std::filesystem::path bundle;
  std::filesystem::path output;
  std::filesystem::path temp_dir;
  unsigned level = 5;
  std::optional<unsigned> coarsest;
  std::uint64_t memory_bytes = 256u << 20;
  unsigned threads = 0;
  bool measure = true;
  bool fit = false;
  std::uint64_t samples = 1'000'000;
  AttributeChoice attributes;  ///< of the bundle
};

/// Writes the semi-regular mesh of a bundle at any level.
/// @throws CorruptionError  the bundle is damaged
Report resample_bundle(const ResampleBundleOptions& options, Progress& progress);

/// The error between two mesh files, as `remaps measure` gives it.
struct MeasureOptions {
  std::filesystem::path original;
  std::filesystem::path remesh;
  std::filesystem::path temp_dir;  ///< empty: the system's
  std::uint64_t samples = 1'000'000;
  std::uint64_t memory_bytes = 256u << 20;
  unsigned threads = 0;
};
SurfaceError measure_files(const MeasureOptions& options, Progress& progress);

}  // namespace remaps::pipeline
