#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/mesh/attributes.h"
#include "remaps/mesh/indexed_stream.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/resample/attribute_sampler.h"
#include "remaps/resample/resampler.h"
#include "remaps/store/row_spool.h"

namespace remaps::pipeline {

/// Carries the attributes of a bundle to the vertices and faces of its output. Without attributes
/// it does nothing and costs nothing.
class AttributeOutput final : public resample::SampleObserver {
 public:
  /// @param specs    those of the bundle that the output will have
  /// @param options  outlives the object
  AttributeOutput(const Bundle& bundle, std::vector<AttributeSpec> specs,
                  const resample::DyadicGrid& grid, const resample::ResampleOptions& options,
                  MemoryBudget& budget);

  const std::vector<AttributeSpec>& specs() const { return specs_; }
  bool any(AttributePer per) const { return row_bytes(specs_, per) > 0; }

  // While the vertices are looked up.
  void begin(std::uint64_t buffer_bytes) override;
  void see(const Tile& tile, std::span<const map::TaggedPoint> points) override;
  void end() override;

  /// Takes the rows of vertices from those of a finer grid, which has them all.
  void take_vertices(const AttributeOutput& finer);
  /// Looks up the faces, if they or their corners have attributes.
  void sample_faces();

  /// Writes positions and triangles with the rows that belong to them.
  void write_positions(IndexedMeshWriter& writer, std::span<const Vec3> positions);
  void write_triangles(IndexedMeshWriter& writer, std::span<const Triangle> triangles);

 private:
  void write_rows(IndexedMeshWriter& writer, AttributePer per, std::uint64_t first,
                  std::uint64_t count);

  const std::vector<AttributeSpec> specs_;
  const Bundle& bundle_;
  const resample::DyadicGrid& grid_;
  const resample::ResampleOptions& options_;
  MemoryBudget& budget_;
  std::optional<resample::VertexAttributeSampler> vertices_;
  std::optional<store::RowSpool> rows_[3];  // by AttributePer; those of corners three at a time
  std::uint64_t vertices_done_ = 0, faces_done_ = 0;
  store::Bytes chunk_;
};

}  // namespace remaps::pipeline
