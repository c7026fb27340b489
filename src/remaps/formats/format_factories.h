#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "remaps/formats/byte_source.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/mesh/indexed_stream.h"

/// One reader or writer of each format; open_mesh_reader and open_mesh_writer choose among them.
namespace remaps {

std::unique_ptr<IndexedMeshReader> make_ply_reader(ByteSource source);
std::unique_ptr<IndexedMeshReader> make_obj_reader(ByteSource source);
std::unique_ptr<IndexedMeshReader> make_off_reader(ByteSource source);
std::unique_ptr<IndexedMeshReader> make_binary_stl_reader(ByteSource source);
std::unique_ptr<IndexedMeshReader> make_ascii_stl_reader(ByteSource source);
/// .glb and .gltf.
std::unique_ptr<IndexedMeshReader> make_gltf_reader(ByteSource source);

std::unique_ptr<IndexedMeshWriter> make_ply_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   std::vector<AttributeSpec> attributes);
std::unique_ptr<IndexedMeshWriter> make_obj_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   std::vector<AttributeSpec> attributes);

std::unique_ptr<IndexedMeshWriter> make_off_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   std::vector<AttributeSpec> attributes);
std::unique_ptr<IndexedMeshWriter> make_stl_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces);
std::unique_ptr<IndexedMeshWriter> make_glb_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   const std::vector<AttributeSpec>& attributes);
std::unique_ptr<IndexedMeshWriter> make_vtp_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   const MeshWriterOptions& options);

/// @throws BudgetError  the format cannot hold a mesh of this size; says which can
void check_stl_size(const std::filesystem::path& path, std::uint64_t faces);
void check_glb_size(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces);

}  // namespace remaps
