#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/mesh/patch.h"
#include "remaps/mesh/segment.h"
#include "remaps/store/bucket_file.h"

namespace remaps {

/// What a surface is, up to deformation.
struct Topology {
  std::uint64_t vertices = 0;  ///< with at least one face
  std::uint64_t faces = 0;
  std::uint64_t boundary_edges = 0;
  std::uint64_t components = 0;
  std::uint64_t boundary_loops = 0;

  std::int64_t euler_characteristic() const {
    const std::uint64_t edges = (3 * faces + boundary_edges) / 2;
    return static_cast<std::int64_t>(vertices + faces) - static_cast<std::int64_t>(edges);
  }
  friend bool operator==(const Topology&, const Topology&) = default;
};

/// One segment's share of the count, found on any thread.
struct SegmentTopology {
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  std::uint64_t boundary_edges = 0;
  std::uint32_t components = 0;       ///< of the segment's faces
  std::uint32_t boundary_chains = 0;  ///< of the segment's boundary edges
  std::vector<std::pair<VertexId, std::uint32_t>>
      shared_component;  ///< vertices also seen by other segments
  std::vector<std::pair<VertexId, std::uint32_t>> shared_chain;
};
/// @param patch  built from the segment's triangles and not yet changed
SegmentTopology count_segment(const Segment& segment, const Patch& patch);

/// Joins labels that meet at a vertex: connected components of a graph that is seen piece by piece.
/// Memory: a word a label; what the pieces share goes through a bucket file.
class LabelJoin {
 public:
  LabelJoin(const std::filesystem::path& path, std::uint64_t expected_vertices,
            std::uint64_t buffer_bytes, MemoryBudget& budget);
  void add(std::uint32_t labels, std::span<const std::pair<VertexId, std::uint32_t>> shared);
  /// @return  number of joined components
  std::uint64_t finish();

 private:
  store::BucketFile file_;
  std::vector<std::uint32_t> parent_;
};

/// Counts a surface that arrives in segments: exact, in bounded memory.
class TopologyCounter {
 public:
  TopologyCounter(const std::filesystem::path& directory, std::uint64_t expected_vertices,
                  std::uint64_t buffer_bytes, MemoryBudget& budget);
  void add(const SegmentTopology& part);
  Topology finish();

 private:
  Topology total_;
  LabelJoin components_;
  LabelJoin chains_;
};

}  // namespace remaps
