#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
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
  /// Vertices whose way led over the sphere and back, too: those of its components.
  std::uint64_t sphere_vertices = 0;
};

struct QueryOptions {
  std::filesystem::path bundle;
  std::filesystem::path temp_dir;  ///< empty: the system's
  std::uint64_t memory_bytes = 256u << 20;
  unsigned threads = 0;
};

/// Checks a bundle independently of how it was made: checksums of all files, every record (star,
/// orientation, areas, ids), the topology of the base against the input's, that tiles, logs,
/// map.bin and base.ply agree on each vertex, and that each returns from the base to where it was.
/// docs/design/verify.md says what is checked how.
/// Memory: a segment a thread, and buffers. The result does not depend on the threads.
/// @throws CorruptionError  says what is wrong and where; InputError: there is no manifest;
///                          BudgetError: a segment does not fit
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

/// A direction from the centre of the sphere that a component of the base is mapped to.
struct SpherePlace {
  Vec3 direction;               ///< of any length but 0; of length 1 in a Location
  std::uint32_t component = 0;  ///< of the base, the one with most faces first
};

struct Location {
  BasePoint base;
  InputPoint input;
  Vec3 position;                      ///< on the input surface
  Vec3 base_position;                 ///< on the flat base face
  std::optional<SpherePlace> sphere;  ///< none: the bundle has no sphere, or not for this point
};

/// Where input vertices lie on the base, from map.bin, that is, to float precision. The point of
/// the input is that base point pulled back; where it falls on a face of the vertex, as nearly
/// always, it is exactly that corner.
/// @throws InputError  there is no such vertex; GeometryError: the vertex has no face;
///                     CorruptionError: the bundle is damaged
std::vector<Location> locate_vertices(const QueryOptions& options,
                                      const std::vector<VertexId>& vertices, Progress& progress);
/// Where points of the base lie on the input. Weights up to 1e-6 outside are clamped. Inverse and
/// forward undo each other within some 1e-10 of the diagonal.
/// Cost for few points: one segment a level each.
/// @throws InputError  there is no such face, or the weights are not those of a point of it;
///                     CorruptionError: the bundle is damaged
std::vector<Location> locate_base_points(const QueryOptions& options,
                                         const std::vector<BasePoint>& points, Progress& progress);
/// Where points of input faces lie on the base. Only face, u, v are read. Throws like the above.
/// Cost: the tiles are read until all faces are found; then one segment a level a point.
std::vector<Location> locate_input_points(const QueryOptions& options,
                                          const std::vector<InputPoint>& points,
                                          Progress& progress);

/// What of the surface is where on the sphere. Needs a bundle with a spherical map.
/// @throws InputError  there is no such map or component, or a direction is 0; CorruptionError: the
///                     bundle is damaged
std::vector<Location> locate_directions(const QueryOptions& options,
                                        const std::vector<SpherePlace>& places, Progress& progress);

/// What a bundle holds: its manifest, as JSON text, unchecked.
/// @throws InputError  it has none
std::string read_manifest(const std::filesystem::path& bundle);

}  // namespace remaps::pipeline
