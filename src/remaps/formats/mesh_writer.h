#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "remaps/mesh/indexed_stream.h"

namespace remaps {

/// True when open_mesh_writer knows the extension (any case): .ply or .obj. Ask before a long job.
bool is_writable_mesh(const std::filesystem::path& path);

/// Creates a mesh file: binary little-endian PLY or OBJ, by extension. Coordinates are stored as
/// floats. The data goes to `.NAME.partial-<pid>` beside the file; `close` renames it.
///
/// PLY face indices are `int` up to 2^31 - 1 vertices, `uint` up to 2^32 - 1, `uint64` above: the
/// last is beyond the format's usual types, other readers than ours will refuse it.
///
/// The writer throws Error on a use that would make a bad file: a count other than announced, an
/// index out of range, a coordinate that is not finite as a float.
///
/// @param vertices, faces  exactly as many as will be written
/// @param attributes       whose rows will be written too; those that the format does not hold are
///                         left out of the file
/// @throws InputError  any other extension; the message lists the supported ones
/// @throws IoError     the file cannot be created
std::unique_ptr<IndexedMeshWriter> open_mesh_writer(const std::filesystem::path& path,
                                                    std::uint64_t vertices, std::uint64_t faces,
                                                    std::vector<AttributeSpec> attributes = {});

/// True when the format of that extension has a place for such an attribute: PLY for all but
/// normals of corners, OBJ for colours and normals of vertices, texture coordinates and normals of
/// corners.
bool holds_attribute(const std::filesystem::path& path, const AttributeSpec& attribute);

}  // namespace remaps
