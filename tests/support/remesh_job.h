#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/generate/scan_generator.h"
#include "remaps/pipeline/remesh.h"
#include "support/shapes.h"

namespace remaps::test {

/// A mesh as lists.
struct MeshLists {
  std::vector<Vec3> position;
  std::vector<Triangle> triangle;
};

MeshLists lists_of(const Shape& shape);
/// Positions are rounded to floats, as PLY files of scans have them.
MeshLists scan(BaseShape shape, std::uint64_t vertices, bool shuffled = false);
MeshLists read_lists(const std::filesystem::path& path);
void write_lists(const MeshLists& mesh, const std::filesystem::path& path);

/// Options of a small job: directory/out.ply and directory/out.remaps, 60 base vertices, level 2,
/// one thread, no measurement. Built with REMAPS_FORCE_SPILL, all jobs get the least memory and a
/// domain buffer of 2000 faces, so that everything goes through segments on disk.
pipeline::RemeshOptions remesh_options(const std::filesystem::path& directory,
                                       const std::filesystem::path& input);

/// Many segments and several sweeps for a mesh of some thousand vertices.
inline constexpr std::uint64_t kSmallDomainBuffer = 2000;

}  // namespace remaps::test
