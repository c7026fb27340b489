#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps {

/// The base domain: what is left when nothing more is removed. Small; always in memory.
struct BaseMesh {
  std::vector<VertexId> vertex_id;                     ///< (v) input indices
  std::vector<Vec3f> position;                         ///< (v)
  std::vector<std::array<std::uint32_t, 3>> triangle;  ///< (f)
};

}  // namespace remaps
