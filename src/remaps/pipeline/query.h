#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/progress.h"

namespace remaps::pipeline {

/// What verify found. Throws instead when something is wrong.
struct Verification {
  std::uint64_t vertices = 0;  ///< carried input -> base -> input
  std::uint64_t records = 0;   ///< re-checked, exactly
  std::uint64_t segments = 0;
  std::uint64_t base_vertices = 0, base_faces = 0;
  std::uint64_t components = 0, boundary_loops = 0;
  std::int64_t euler_characteristic = 0;
  double round_trip_max = 0, round_trip_mean = 0;  ///< fractions of the diagonal
  double map_file_max = 0;  ///< largest distance on the base between map.bin and the log, same unit
};

struct QueryOptions {
  std::filesystem::path bundle;
  std::filesystem::path temp_dir;  ///< empty: the system's
  std::uint64_t memory_bytes = 256u << 20;
  unsigned threads = 0;
};

/// Checks a bundle independently of how it was made: checksums of all files, every record (star,
/// orientation, areas, ids), the topology of the base against the input's, and that each input
/// vertex returns from the base to where it was.
/// @throws CorruptionError  says what is wrong and where
Verification verify_bundle(const QueryOptions& options, Progress& progress);

/// A point on the base mesh: weights (1 - u - v, u, v).
struct BasePoint {
  std::uint32_t face = 0;
  double u = 0, v = 0;
};
/// A point on the input: on a face, or at a vertex.
struct InputPoint {
  FaceId face = 0;
  double u = 0, v = 0;
  std::array<VertexId, 3> vertex{};  ///< corners of the face
};

struct Location {
  BasePoint base;
  InputPoint input;
  Vec3 position;       ///< on the input surface
  Vec3 base_position;  ///< on the flat base face
};

/// Where input vertices lie on the base.
/// @throws InputError  there is no such vertex; GeometryError: the vertex has no face
std::vector<Location> locate_vertices(const QueryOptions& options,
                                      const std::vector<VertexId>& vertices, Progress& progress);
/// Where points of the base lie on the input. Cost for few points: one segment a level.
std::vector<Location> locate_base_points(const QueryOptions& options,
                                         const std::vector<BasePoint>& points, Progress& progress);
/// Where points of input faces lie on the base. Only face, u, v are read.
std::vector<Location> locate_input_points(const QueryOptions& options,
                                          const std::vector<InputPoint>& points,
                                          Progress& progress);

/// What a bundle holds: its manifest, as JSON text.
std::string read_manifest(const std::filesystem::path& bundle);

}  // namespace remaps::pipeline
