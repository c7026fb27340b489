#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/mesh/indexed_stream.h"
#include "remaps/mesh/space_cut.h"
#include "remaps/mesh/triangle_stream.h"
#include "remaps/pipeline/vertex_runs.h"
#include "remaps/store/disk_usage.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {

/// All vertex positions of an input on disk, as floats relative to an origin: what faces are joined
/// with. An input that has them as an array already is read in place; of others a temporary file is
/// made.
///
/// The origin is zero unless the first vertices lie farther than 1000 times their own extent from
/// zero (maps, surveys); then it is their centre, so that floats suffice. Input that is float in
/// its file is kept as it is.
class VertexSpool {
 public:
  /// @param path    of the temporary file, should it be needed
  /// @param budget  of the list of vertices that are not finite
  VertexSpool(std::filesystem::path path, MemoryBudget& budget)
      : path_(std::move(path)), budget_(budget) {}
  ~VertexSpool();
  VertexSpool(const VertexSpool&) = delete;
  VertexSpool& operator=(const VertexSpool&) = delete;

  /// Reads all positions of `reader`. May be called once. Also samples them, and finds their box.
  /// @throws BudgetError  a great many of them, far apart, are not finite
  void fill(IndexedMeshReader& reader, PositionSample* sample,
            const std::function<void(double)>& progress);

  std::uint64_t vertices() const { return vertices_; }
  const Vec3& origin() const { return origin_; }
  /// Of the finite positions.
  const Box3& box() const { return box_; }
  /// Vertices with a coordinate that is not finite: they count as not there.
  const VertexRuns& nonfinite() const { return nonfinite_; }
  /// True if one of the corners is among them.
  bool is_touched(const Triangle& t) const {
    return nonfinite_.contains(t[0]) || nonfinite_.contains(t[1]) || nonfinite_.contains(t[2]);
  }
  /// Reads positions first ... first + out.size() - 1.
  void read(std::uint64_t first, std::span<Vec3f> out) const;

 private:
  void choose_origin(std::span<const Vec3> positions, bool is_float);
  void flush();

  std::filesystem::path path_;
  MemoryBudget& budget_;
  store::File file_;
  std::uint64_t begin_ = 0;  // in the file, of the first position
  bool in_place_ = false;
  store::DiskShare disk_;
  Vec3 origin_;
  Box3 box_;
  VertexRuns nonfinite_;
  std::uint64_t vertices_ = 0;
  std::vector<Vec3f> waiting_;
};

inline bool is_finite(const Vec3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Positions and segments of vertices by number, through a cache of blocks of the spool: a coherent
/// input finds nearly everything there. With memory for all blocks it is a plain table.
class VertexLookup {
 public:
  struct Entry {
    Vec3f position;
    std::uint32_t segment;
  };

  /// @param cut          optional: without it all segments are 0
  /// @param cache_bytes  memory for blocks, reserved from the budget
  VertexLookup(const VertexSpool& spool, const SpaceCut* cut, std::uint64_t cache_bytes,
               MemoryBudget& budget);

  /// Blocks read so far.
  std::uint64_t misses() const { return misses_; }
  const VertexSpool& spool() const { return spool_; }

  const Entry& operator[](VertexId v) {
    const std::uint32_t slot = slot_of_block_[v / kBlock];
    if (slot != kNoIndex) {
      used_[slot] = 1;
      Entry& entry = entries_[slot * kBlock + v % kBlock];
      if (entry.segment == kNoIndex) entry.segment = cut_->segment_of(entry.position);
      return entry;
    }
    return load(v);
  }

 private:
  static constexpr std::uint64_t kBlock = 256;

  const Entry& load(VertexId v);

  const VertexSpool& spool_;
  const SpaceCut* cut_;
  std::size_t slots_;
  Reservation reservation_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> slot_of_block_;
  std::vector<std::uint64_t> block_in_slot_;
  std::vector<std::uint8_t> used_;  // second chance
  std::size_t hand_ = 0;
  std::uint64_t misses_ = 0;
  std::vector<Vec3f> buffer_;
};

/// While it lives, polygons of a reader are cut by where their corners are.
class PolygonCutting final : public PolygonCutter {
 public:
  /// @param cache_bytes  reserved from the budget when the first polygon comes
  PolygonCutting(IndexedMeshReader& reader, const VertexSpool& spool, std::uint64_t cache_bytes,
                 MemoryBudget& budget)
      : reader_(reader), spool_(spool), cache_bytes_(cache_bytes), budget_(budget) {
    reader_.set_polygon_cutter(this);
  }
  ~PolygonCutting() override { reader_.set_polygon_cutter(nullptr); }
  PolygonCutting(const PolygonCutting&) = delete;
  PolygonCutting& operator=(const PolygonCutting&) = delete;

 private:
  Vec3 position(VertexId v) override {
    if (!lookup_) lookup_.emplace(spool_, nullptr, cache_bytes_, budget_);
    return widen((*lookup_)[v].position);
  }

  IndexedMeshReader& reader_;
  const VertexSpool& spool_;
  std::uint64_t cache_bytes_;
  MemoryBudget& budget_;
  std::optional<VertexLookup> lookup_;
};

/// The triangles of a file with their corner positions, as a stream that can be repeated. `reader`
/// and `lookup` must outlive it. Positions are those of the spool plus `shift`. Triangles with a
/// corner that is not finite are left out.
TriangleSource triangles_of(IndexedMeshReader& reader, VertexLookup& lookup, const Vec3& shift);

}  // namespace remaps::pipeline
