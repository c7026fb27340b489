#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/formats/gltf_scene.h"
#include "remaps/mesh/attributes.h"

namespace remaps {

/// What the vertices of a scene have: "normal" (NORMAL), "colour" (COLOR_0) and "uv", "uv1", ...
/// (TEXCOORD_0, TEXCOORD_1, ...), as far as some primitive has it. A colour keeps its type where
/// all primitives agree in it; all else is of floats.
std::vector<AttributeSpec> find_gltf_attributes(const GltfScene& scene);

/// Sends the rows of all vertices, in order: a pass over the accessors. Normals are turned with
/// their node and have length 1, texture coordinates count from below, as in PLY and OBJ. Vertices
/// of a primitive without an attribute get white, and zeros of all else.
/// @param done  hears of so many vertices more
void read_gltf_attributes(const GltfScene& scene, const std::filesystem::path& path,
                          AttributeSink sink, FunctionRef<void(std::uint64_t)> done);

}  // namespace remaps
