#pragma once

#include <cstdint>
#include <vector>

#include "remaps/formats/ply_header.h"
#include "remaps/mesh/attributes.h"

namespace remaps {

/// What a PLY has beside positions and corners: scalar properties of 'vertex' and 'face', and the
/// list 'texcoord' of 'face', two values a corner. Colours, normals and texture coordinates are
/// known by the names of their properties; other scalars are attributes of their own.
///
/// Faces have none when triangles come from other elements too.
std::vector<AttributeSpec> find_ply_attributes(const PlyHeader& header);

/// Sends the rows of 'vertex', of 'face', or of the corners of 'face', whose first record the
/// cursor stands before. For Cursor see ply_cursor.h.
/// @param specs  those of the element, as find_ply_attributes gives them
template <class Cursor>
void read_ply_rows(Cursor& cursor, const PlyElement& element, AttributePer per,
                   const std::vector<AttributeSpec>& specs, AttributeSink sink);

}  // namespace remaps
