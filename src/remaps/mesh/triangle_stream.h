#pragma once

#include <functional>
#include <span>

#include "remaps/base/function_ref.h"
#include "remaps/base/geometry.h"

namespace remaps {

/// Receives one chunk of triangles with their corner positions.
using TriangleSink = FunctionRef<void(std::span<const TrianglePositions>)>;

/// A surface as something that can be streamed: each call sends every triangle once, in chunks of
/// some ten thousands, in the same order each time. The surface as a whole need not fit in memory.
using TriangleSource = std::function<void(TriangleSink)>;

}  // namespace remaps
