#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "remaps/formats/byte_source.h"

namespace remaps {

enum class MeshFormat { ply, obj, off, binary_stl, ascii_stl, glb, gltf };

/// The format of what begins with the bytes in the source's buffer. The content decides; the
/// extension (that before .gz or .zst) only where the content has no mark of its own.
/// @param source  at its start, with its buffer full; left there
std::optional<MeshFormat> detect_format(const ByteSource& source);

/// What a file holds that is none of these formats, for an error: the name of another format that
/// is known by its first bytes, or these.
std::string describe_content(std::string_view head);

/// Goes past a byte order mark at the start of a text.
void skip_byte_order_mark(ByteSource& source);

}  // namespace remaps
