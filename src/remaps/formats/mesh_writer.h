#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "remaps/mesh/indexed_stream.h"

namespace remaps {

/// What open_mesh_writer writes, for messages and help.
inline constexpr std::string_view kWritableMeshes = ".ply, .obj, .off, .stl, .glb, .vtp";

/// What is known of a mesh besides its size, for the formats that can say it.
struct MeshWriterOptions {
  /// Faces 4^level f ... 4^level (f + 1) - 1 are the parts of face f of a base mesh: .vtp has this
  /// as data of its cells.
  std::optional<unsigned> level = std::nullopt;
  /// Whose rows will be written too; those that the format does not hold are left out of the file.
  std::vector<AttributeSpec> attributes = {};
};

/// True when open_mesh_writer knows the extension (any case). Ask before a long job.
bool is_writable_mesh(const std::filesystem::path& path);

/// Refuses a mesh that is larger than its format can be. Ask before a long job, as soon as its size
/// is known; open_mesh_writer asks too.
/// @throws BudgetError    names the limit, and formats without it
/// @throws GeometryError  an empty mesh, of which a GLB can have none
void check_mesh_size(const std::filesystem::path& path, std::uint64_t vertices,
                     std::uint64_t faces);

/// Creates a mesh file, by extension: binary little-endian PLY, OBJ, OFF, binary STL, GLB
/// (glTF 2.0) or VTP (VTK PolyData, raw appended data). Coordinates are stored as floats. The data
/// goes to
/// `.NAME.partial-<pid>` beside the file; `close` renames it. docs/formats/meshes.md tells what
/// each format holds and what it does not.
///
/// PLY face indices are `int` up to 2^31 - 1 vertices, `uint` up to 2^32 - 1, `uint64` above: the
/// last is beyond the format's usual types, other readers than ours will refuse it.
///
/// The writer throws Error on a use that would make a bad file: a count other than announced, an
/// index out of range, a coordinate that is not finite as a float.
///
/// Memory: 1 MiB of buffer; for STL, and for GLB with texture coordinates of corners, 1 MiB more.
/// What a format wants in another order than it comes waits on disk, in files without a name:
/// positions of an STL, attributes of a VTP, vertices of such a GLB.
///
/// @param vertices, faces  exactly as many as will be written
/// @throws InputError  any other extension; the message lists the supported ones
/// @throws BudgetError, GeometryError  as check_mesh_size
/// @throws IoError     the file cannot be created
std::unique_ptr<IndexedMeshWriter> open_mesh_writer(const std::filesystem::path& path,
                                                    std::uint64_t vertices, std::uint64_t faces,
                                                    const MeshWriterOptions& options = {});

/// Which of these attributes the format of that extension has a place for: PLY and VTP for what
/// vertices and faces have, and PLY for texture coordinates of corners, VTP for all that corners
/// have; OBJ, OFF and GLB for a colour, a normal and texture coordinates (GLB for eight sets); STL
/// for none. Where there are more of a kind than places, the first ones get them.
std::vector<bool> held_attributes(const std::filesystem::path& path,
                                  std::span<const AttributeSpec> specs);

}  // namespace remaps
