#include "remaps/pipeline/vertex_spool.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "remaps/base/errors.h"

namespace remaps::pipeline {
namespace {

constexpr std::size_t kFlushVertices = 1 << 15;

}  // namespace

VertexSpool::~VertexSpool() {
  if (in_place_) return;
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void VertexSpool::choose_origin(std::span<const Vec3> positions, bool is_float) {
  if (is_float) return;
  Box3 box;
  for (const Vec3& p : positions) {
    if (is_finite(to_float(p))) box.add(p);
  }
  if (box.empty()) return;
  const Vec3 centre = 0.5 * (box.low + box.high);
  if (norm(centre) > 1000 * box.diagonal()) origin_ = widen(to_float(centre));
}

void VertexSpool::fill(IndexedMeshReader& reader, PositionSample* sample,
                       const std::function<void(double)>& progress) {
  const std::optional<PositionArray> array = reader.position_array();
  in_place_ = array.has_value();
  file_ = in_place_ ? store::File::open_read(array->path) : store::File::create(path_);
  begin_ = in_place_ ? array->offset : 0;
  reader.read_positions([&](std::span<const Vec3> positions) {
    if (vertices_ == 0) choose_origin(positions, reader.positions_are_float());
    for (const Vec3& p : positions) {
      const Vec3f stored = to_float(p - origin_);
      if (!in_place_) waiting_.push_back(stored);
      const VertexId vertex = vertices_++;
      if (!is_finite(stored)) {
        nonfinite_.add(vertex, budget_);
        continue;
      }
      box_.add(widen(stored));
      if (sample != nullptr) sample->add(stored);
    }
    if (waiting_.size() >= kFlushVertices) flush();
    progress(reader.pass_fraction());
  });
  flush();
  waiting_ = {};
}

void VertexSpool::flush() {
  if (waiting_.empty()) return;
  file_.write_at((vertices_ - waiting_.size()) * sizeof(Vec3f), std::as_bytes(std::span(waiting_)));
  disk_.grow(waiting_.size() * sizeof(Vec3f));
  waiting_.clear();
}

void VertexSpool::read(std::uint64_t first, std::span<Vec3f> out) const {
  if (first > vertices_ || out.size() > vertices_ - first)
    throw CorruptionError("vertices beyond the last were asked for");
  file_.read_at(begin_ + first * sizeof(Vec3f), std::as_writable_bytes(out));
}

VertexLookup::VertexLookup(const VertexSpool& spool, const SpaceCut* cut, std::uint64_t cache_bytes,
                           MemoryBudget& budget)
    : spool_(spool), cut_(cut) {
  const std::uint64_t blocks = spool.vertices() / kBlock + 1;
  slots_ = static_cast<std::size_t>(std::clamp<std::uint64_t>(
      cache_bytes / (kBlock * sizeof(Entry)), 4, std::max<std::uint64_t>(blocks, 4)));
  reservation_ = budget.reserve(slots_ * kBlock * sizeof(Entry) + blocks * sizeof(std::uint32_t),
                                "the vertex cache");
  entries_.resize(slots_ * kBlock);
  slot_of_block_.assign(static_cast<std::size_t>(blocks), kNoIndex);
  block_in_slot_.assign(slots_, ~std::uint64_t{0});
  used_.assign(slots_, 0);
}

const VertexLookup::Entry& VertexLookup::load(VertexId v) {
  ++misses_;
  while (used_[hand_]) {
    used_[hand_] = 0;
    hand_ = (hand_ + 1) % slots_;
  }
  const std::size_t slot = hand_;
  hand_ = (hand_ + 1) % slots_;
  if (block_in_slot_[slot] != ~std::uint64_t{0}) slot_of_block_[block_in_slot_[slot]] = kNoIndex;
  const std::uint64_t block = v / kBlock;
  block_in_slot_[slot] = block;
  slot_of_block_[block] = static_cast<std::uint32_t>(slot);
  used_[slot] = 1;

  const std::uint64_t first = block * kBlock;
  buffer_.resize(static_cast<std::size_t>(std::min(kBlock, spool_.vertices() - first)));
  spool_.read(first, buffer_);
  for (std::size_t i = 0; i < buffer_.size(); ++i) {
    entries_[slot * kBlock + i] = {buffer_[i], cut_ == nullptr ? 0 : kNoIndex};
  }
  return (*this)[v];
}

TriangleSource triangles_of(IndexedMeshReader& reader, VertexLookup& lookup, const Vec3& shift) {
  return [&reader, &lookup, shift](TriangleSink sink) {
    std::vector<TrianglePositions> chunk;
    const auto position = [&](VertexId v) { return shift + widen(lookup[v].position); };
    const bool all = lookup.spool().nonfinite().empty();
    reader.read_triangles([&](std::span<const Triangle> triangles) {
      chunk.clear();
      for (const Triangle& t : triangles) {
        if (!all && lookup.spool().is_touched(t)) continue;
        chunk.push_back({position(t[0]), position(t[1]), position(t[2])});
      }
      if (!chunk.empty()) sink(chunk);
    });
  };
}

}  // namespace remaps::pipeline
