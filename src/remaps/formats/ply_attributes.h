#pragma once

#include <cstdint>
#include <vector>

#include "remaps/formats/ply_header.h"
#include "remaps/mesh/attributes.h"
#include "remaps/mesh/polygon_cutter.h"

namespace remaps {

/// What a PLY has beside positions and corners: scalar properties of 'vertex' and 'face', and the
/// list 'texcoord' of 'face', two values a corner. Colours, normals and texture coordinates are
/// known by the names of their properties; other scalars are attributes of their own.
///
/// Faces have none when triangles come from other elements too.
std::vector<AttributeSpec> find_ply_attributes(const PlyHeader& header);

/// What cuts the polygons of a file, if anything does, and the number of its vertices.
struct PlyPolygonCuts {
  PolygonCutter* cutter = nullptr;
  std::uint64_t vertices = 0;
};

/// Sends the rows of 'vertex', of 'face', or of the corners of 'face', whose first record the
/// cursor stands before. For Cursor see ply_cursor.h.
/// @param specs  those of the element, as find_ply_attributes gives them
/// @param cuts   how polygons were cut when triangles were read
template <class Cursor>
void read_ply_rows(Cursor& cursor, const PlyElement& element, AttributePer per,
                   const std::vector<AttributeSpec>& specs, const PlyPolygonCuts& cuts,
                   AttributeSink sink);

}  // namespace remaps
