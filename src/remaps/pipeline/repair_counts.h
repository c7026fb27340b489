#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "remaps/pipeline/report.h"

namespace remaps::pipeline {

/// All that Repairs counts, with the names that JSON gives it (docs/formats/report.md).
inline auto repair_counts(const Repairs& r) {
  using Count = std::pair<const char*, std::uint64_t>;
  return std::array{
      Count{"welded_vertices", r.welded_vertices},
      Count{"unreferenced_vertices", r.unreferenced_vertices},
      Count{"nonfinite_vertices", r.nonfinite_vertices},
      Count{"nonfinite_faces", r.nonfinite_faces},
      Count{"degenerate_faces", r.degenerate_faces},
      Count{"duplicate_faces", r.duplicate_faces},
      Count{"flipped_faces", r.flipped_faces},
      Count{"nonmanifold_edges", r.nonmanifold_edges},
      Count{"nonmanifold_vertices", r.nonmanifold_vertices},
      Count{"split_vertices", r.split_vertices},
      Count{"dropped_components", r.dropped_components},
      Count{"dropped_component_faces", r.dropped_component_faces},
      Count{"filled_holes", r.filled_holes},
      Count{"filled_faces", r.filled_faces},
  };
}

}  // namespace remaps::pipeline
