#pragma once

#include <string>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/segment_log.h"

namespace remaps::pipeline {

/// What stands for the corners of a face that a record dropped.
inline constexpr Triangle kDroppedFace{~VertexId{0}, ~VertexId{0}, ~VertexId{0}};

/// Follows the records of one segment on the connectivity of its mesh and checks each, exactly and
/// in integers: its faces are alive and distinct; they are the star of the removed vertex, in
/// order, with distinct ring vertices; the plane is sound, that is, every wedge and every new
/// triangle is counter-clockwise, the ring winds once around the origin (a boundary ring half, from
/// y = 0, x > 0 to y = 0, x < 0), and wedges and new triangles have the same area.
///
/// That no face at the removed vertex is left out of its star is for the caller to see: such a
/// vertex would be met again later.
///
/// @param what   names the segment in messages
/// @param faces  (log.faces) corners of each home face as input indices; afterwards those that the
///               records leave, and kDroppedFace
/// @throws CorruptionError  the first record that is wrong, and why
/// Cost: one pass over the records.
void replay_records(const SegmentLog& log, const std::string& what, std::vector<Triangle>& faces);

/// Checks that the log's survivors are exactly the faces left.
/// @throws CorruptionError  names the first face on which they differ
void check_survivors(const SegmentLog& log, const std::string& what,
                     const std::vector<Triangle>& faces);

}  // namespace remaps::pipeline
