#pragma once

#include "remaps/base/progress.h"
#include "remaps/mesh/indexed_stream.h"
#include "remaps/pipeline/weld_files.h"
#include "remaps/pipeline/weld_match.h"

namespace remaps::pipeline {

/// Writes the corners of all faces of a mesh, in their order, with new numbers. With memory for all
/// numbers that is one pass over the mesh; else corners wait in the bucket of their range of
/// vertices, and go from there to that of their range of corners.
/// @param numbers  the new number of each vertex
void renumber_corners(IndexedMeshReader& mesh, NumberFile& numbers, const WeldScratch& scratch,
                      Progress& progress, NumberFile& corners);

}  // namespace remaps::pipeline
