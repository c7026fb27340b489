#include "remaps/pipeline/attribute_output.h"

#include <algorithm>
#include <string>
#include <utility>

namespace remaps::pipeline {
namespace {

/// Elements written at a time with their rows, and the bytes that these may take.
constexpr std::size_t kMostChunk = 1 << 10;
constexpr std::size_t kChunkBytes = 256 << 10;

std::size_t chunk_of(std::size_t row_bytes) {
  return std::clamp<std::size_t>(kChunkBytes / std::max<std::size_t>(row_bytes, 1), 1, kMostChunk);
}

}  // namespace

AttributeOutput::AttributeOutput(const Bundle& bundle, std::vector<AttributeSpec> specs,
                                 const resample::DyadicGrid& grid,
                                 const resample::ResampleOptions& options, MemoryBudget& budget)
    : specs_(std::move(specs)), bundle_(bundle), grid_(grid), options_(options), budget_(budget) {
  for (const AttributePer per : {AttributePer::vertex, AttributePer::face, AttributePer::corner}) {
    if (!any(per)) continue;
    const std::size_t bytes = row_bytes(specs_, per) * (per == AttributePer::corner ? 3 : 1);
    rows_[static_cast<std::size_t>(per)].emplace(
        options.temp_dir /
            ("output-" + std::string(name_of(per)) + "-attributes-" + std::to_string(grid.level())),
        bytes);
  }
}

void AttributeOutput::begin(std::uint64_t buffer_bytes) {
  if (!any(AttributePer::vertex)) return;
  vertices_.emplace(*bundle_.attributes(), specs_, grid_.vertices(), options_.temp_dir,
                    buffer_bytes, budget_);
}

void AttributeOutput::see(const Tile& tile, std::span<const map::TaggedPoint> points) {
  if (vertices_) vertices_->add(tile, points);
}

void AttributeOutput::end() {
  if (!vertices_) return;
  vertices_->finish(*rows_[0], options_.buffer_bytes, options_.carry.progress);
  vertices_.reset();
}

void AttributeOutput::take_vertices(const AttributeOutput& finer) {
  if (!rows_[0]) return;
  const std::size_t width = rows_[0]->row_bytes();
  finer.grid_.coarse_vertices(grid_.level(), [&](std::uint64_t first, std::uint64_t count) {
    while (count > 0) {
      const std::uint64_t part = std::min<std::uint64_t>(count, chunk_of(width));
      chunk_.resize(static_cast<std::size_t>(part) * width);
      finer.rows_[0]->read(first, chunk_);
      rows_[0]->append(chunk_);
      first += part;
      count -= part;
    }
  });
}

void AttributeOutput::sample_faces() {
  const auto spool = [this](AttributePer per) {
    auto& rows = rows_[static_cast<std::size_t>(per)];
    return rows ? &*rows : nullptr;
  };
  if (!any(AttributePer::face) && !any(AttributePer::corner)) return;
  resample::sample_face_attributes(bundle_.files(), *bundle_.attributes(), specs_, grid_, options_,
                                   budget_, spool(AttributePer::face), spool(AttributePer::corner));
}

void AttributeOutput::write_rows(IndexedMeshWriter& writer, AttributePer per, std::uint64_t first,
                                 std::uint64_t count) {
  const auto& rows = rows_[static_cast<std::size_t>(per)];
  if (!rows) return;
  chunk_.resize(static_cast<std::size_t>(count) * rows->row_bytes());
  rows->read(first, chunk_);
  writer.write_attributes(per, chunk_);
}

void AttributeOutput::write_positions(IndexedMeshWriter& writer, std::span<const Vec3> positions) {
  if (!any(AttributePer::vertex)) {
    writer.write_positions(positions);
    return;
  }
  const std::size_t chunk = chunk_of(row_bytes(specs_, AttributePer::vertex));
  while (!positions.empty()) {
    const auto part = positions.first(std::min(chunk, positions.size()));
    writer.write_positions(part);
    write_rows(writer, AttributePer::vertex, vertices_done_, part.size());
    vertices_done_ += part.size();
    positions = positions.subspan(part.size());
  }
}

void AttributeOutput::write_triangles(IndexedMeshWriter& writer,
                                      std::span<const Triangle> triangles) {
  if (!any(AttributePer::face) && !any(AttributePer::corner)) {
    writer.write_triangles(triangles);
    return;
  }
  const std::size_t chunk =
      chunk_of(row_bytes(specs_, AttributePer::face) + 3 * row_bytes(specs_, AttributePer::corner));
  while (!triangles.empty()) {
    const auto part = triangles.first(std::min(chunk, triangles.size()));
    write_rows(writer, AttributePer::face, faces_done_, part.size());
    write_rows(writer, AttributePer::corner, faces_done_, part.size());
    writer.write_triangles(part);
    faces_done_ += part.size();
    triangles = triangles.subspan(part.size());
  }
}

}  // namespace remaps::pipeline
