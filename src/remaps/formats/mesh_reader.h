#pragma once

#include <filesystem>
#include <memory>

#include "remaps/mesh/indexed_stream.h"

namespace remaps {

/// Opens a triangle or polygon mesh: PLY (ASCII, both byte orders), OBJ, ASCII OFF or glTF 2.0
/// (.glb, .gltf). The content decides the format, the extension only where the content has no mark
/// of its own.
///
/// Polygons arrive as a fan from their first corner, triangle strips as triangles of alternating
/// orientation. docs/formats/meshes.md lists what is read, skipped and refused.
///
/// The header is read and checked against the file's size here; the data on each read_*. Memory:
/// one buffer of 1 MiB and one chunk of 8192 elements, whatever the file's size.
/// positions_are_float() is known at once for a PLY that declares it, else after read_positions.
///
/// @param path  a regular file (each read_* is a pass of its own, so a pipe does not do)
/// @throws InputError  missing, unreadable, empty, of an unsupported format or with a malformed
/// header
/// @throws IoError     reading failed
std::unique_ptr<IndexedMeshReader> open_mesh_reader(const std::filesystem::path& path);

}  // namespace remaps
