#pragma once

#include <random>

#include "remaps/mesh/retriangulation.h"
#include "remaps/mesh/segment_log.h"

namespace remaps::test {

/// A random valid record: every wedge and every fan triangle is positively oriented, with at least
/// the planar shape `floor`. Face ids are distinct and below `faces`, which is at least
/// kMaxStarFaces.
Retriangulation random_record(std::mt19937_64& random, bool boundary, LocalIndex faces = 1000,
                              double floor = 0.002);

/// A log of random records that only the encoding has to make sense of.
SegmentLog random_segment_log(std::mt19937_64& random, unsigned level, std::size_t records);

}  // namespace remaps::test
