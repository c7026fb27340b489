#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/mesh/attribute_file.h"
#include "remaps/mesh/indexed_stream.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/store/row_spool.h"

namespace remaps::pipeline {

/// Writes the attributes of an input to a file of a bundle: one pass over the vertices, one over
/// the faces and one over their corners, as far as they have any. Values that lie in pools are
/// joined with the corners through the disk.
/// @param wanted  of reader.attributes(), in its order
/// @throws InputError  malformed; CorruptionError: the passes do not agree in how much there is
void store_attributes(IndexedMeshReader& reader, const AttributeLayout& wanted,
                      const std::filesystem::path& path, const std::filesystem::path& temp_dir,
                      const MemoryPlan& plan, MemoryBudget& budget, Progress& progress);

/// Writes which vertex each vertex that repair made is a copy of.
/// @param originals  rows of a VertexId, in the order of the copies
void store_copies(const store::RowSpool& originals, std::uint64_t copies,
                  const std::filesystem::path& path);

}  // namespace remaps::pipeline
