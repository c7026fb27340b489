#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "remaps/base/memory_budget.h"
#include "remaps/mesh/indexed_stream.h"

namespace remaps {

/// Opens a triangle or polygon mesh: PLY (ASCII, both byte orders), OBJ, ASCII OFF or STL (ASCII
/// and binary), each of them perhaps compressed with gzip or Zstandard, or glTF 2.0 (.glb, .gltf).
/// The content decides the format, the extension only where the content has no mark of its own.
///
/// Polygons arrive as a fan from their first corner, triangle strips as triangles of alternating
/// orientation. docs/formats/meshes.md lists what is read, skipped and refused.
///
/// The header is read and checked against the file's size here; the data on each read_*. Memory:
/// one buffer of 1 MiB and one chunk of 8192 elements, whatever the file's size; of compressed
/// files also the window (32 KiB of gzip, by custom up to 8 MiB of Zstandard).
/// positions_are_float() is known at once for a binary STL and for a PLY that declares it, else
/// after read_positions.
///
/// @param path    a regular file (each read_* is a pass of its own, so a pipe does not do)
/// @param budget  optional; windows of more than 1 MiB are reserved from it while the reader lives
/// @throws InputError   missing, unreadable, empty, of an unsupported format or with a malformed
/// header
/// @throws IoError      reading failed
/// @throws BudgetError  the window does not fit the budget
std::unique_ptr<IndexedMeshReader> open_mesh_reader(const std::filesystem::path& path,
                                                    MemoryBudget* budget = nullptr);

/// Bytes of a file, of a compressed one about those of its content, told by its first MiB. 0 if the
/// file cannot be read.
std::uint64_t guess_content_bytes(const std::filesystem::path& path);

}  // namespace remaps
