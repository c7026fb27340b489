#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/codec/archive.h"
#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/measure/surface_error.h"
#include "remaps/mesh/attributes.h"
#include "remaps/mesh/triangle_stream.h"

namespace remaps::pipeline {

struct CodedSurfaceOptions {
  std::filesystem::path input;
  std::optional<unsigned> level;
  std::optional<AttributeChoice> attributes;
  std::uint64_t memory_bytes = 0;
  unsigned threads = 1;
  std::filesystem::path temp_dir;
  std::uint64_t samples = 0;
};

/// A surface that is to be coded: its semi-regular mesh, and what coded versions of it are compared
/// with.
class CodedSurface {
 public:
  virtual ~CodedSurface() = default;
  /// The mesh; once.
  virtual codec::SemiRegularMesh release_mesh() = 0;
  /// L2 error of another mesh, the larger of both directions, as a fraction of the diagonal.
  virtual double l2_error(const codec::SemiRegularMesh& mesh, MemoryBudget& budget) const = 0;
};

/// Opens a bundle, whose input surface is the reference and whose mesh is resampled, or a mesh with
/// subdivision connectivity, which is its own reference.
std::unique_ptr<CodedSurface> open_coded_surface(const CodedSurfaceOptions& options,
                                                 MemoryBudget& budget, Progress& progress);

std::unique_ptr<CodedSurface> make_bundle_surface(const CodedSurfaceOptions& options,
                                                  MemoryBudget& budget, Progress& progress);
/// @throws GeometryError  the mesh has no subdivision connectivity
std::unique_ptr<CodedSurface> make_mesh_surface(const CodedSurfaceOptions& options,
                                                MemoryBudget& budget, Progress& progress);

/// The triangles of a mesh, moved by an offset.
/// @param hierarchy, position  must outlive the source
TriangleSource triangles_of_coded(const codec::SubdivisionHierarchy& hierarchy,
                                  const std::vector<Vec3>& position, const Vec3& offset);
/// How coded surfaces are measured, in half of the memory that is left.
SurfaceErrorOptions coded_error_options(const CodedSurfaceOptions& options,
                                        const MemoryBudget& budget);

/// Writes a mesh in the numbering of docs/formats/semi-regular.md, with the signals that the format
/// holds as attributes.
void write_mesh(const codec::SemiRegularMesh& mesh, const std::filesystem::path& path,
                MemoryBudget& budget, Progress& progress);

}  // namespace remaps::pipeline
