#pragma once

#include <memory>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/mesh/domain_level.h"
#include "support/shapes.h"

namespace remaps::test {

std::vector<Vec3f> float_positions(const Shape& shape);

/// A shape as the first level of a sweep, in memory: one segment with everything.
Segment whole_segment(const Shape& shape);

/// A shape cut into segments on disk.
std::unique_ptr<DomainLevel> cut_shape(const Shape& shape, std::size_t segments, unsigned level,
                                       const std::filesystem::path& directory,
                                       MemoryBudget& budget);

}  // namespace remaps::test
