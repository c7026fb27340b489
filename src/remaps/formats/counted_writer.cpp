#include "remaps/formats/counted_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

/// Values up to here round to a finite float: the largest float and half a step, exclusive.
constexpr double kFloatOverflow = 0x1.ffffffp127;

bool is_storable(const Vec3& p) {
  return std::fabs(p.x) < kFloatOverflow && std::fabs(p.y) < kFloatOverflow &&
         std::fabs(p.z) < kFloatOverflow;
}

}  // namespace

CountedWriter::CountedWriter(const std::filesystem::path& path, std::uint64_t vertices,
                             std::uint64_t faces, std::vector<AttributeSpec> attributes)
    : sink_(path),
      vertices_(vertices),
      faces_(faces),
      attributes_(std::move(attributes)),
      row_bytes_{row_bytes(attributes_, AttributePer::vertex),
                 row_bytes(attributes_, AttributePer::face),
                 3 * row_bytes(attributes_, AttributePer::corner)} {}

void CountedWriter::write_positions(std::span<const Vec3> positions) {
  if (faces_done_ > 0) fail("positions after the first triangle");
  if (positions.size() > vertices_ - vertices_done_) {
    fail(fmt::format("more than the {} vertices announced", vertices_));
  }
  const auto bad = std::find_if_not(positions.begin(), positions.end(), is_storable);
  if (bad != positions.end()) {
    fail(fmt::format("vertex {} at ({}, {}, {}) is not finite as floats",
                     vertices_done_ + static_cast<std::uint64_t>(bad - positions.begin()), bad->x,
                     bad->y, bad->z));
  }
  if (!waiting_.empty()) fail("vertices without their attributes");
  if (row_bytes_[0] == 0) {
    put_positions(positions);
  } else {
    waiting_.assign(positions.begin(), positions.end());
  }
  vertices_done_ += positions.size();
}

void CountedWriter::expect_rows(AttributePer per, std::size_t elements, std::size_t bytes) const {
  const std::size_t each = row_bytes_[static_cast<std::size_t>(per)];
  if (bytes == elements * each) return;
  fail(fmt::format("{} bytes of {} attributes, where {} elements take {} each", bytes, name_of(per),
                   elements, each));
}

void CountedWriter::write_attributes(AttributePer per, std::span<const std::byte> rows) {
  if (per == AttributePer::vertex) {
    expect_rows(per, waiting_.size(), rows.size());
    if (!waiting_.empty()) put_vertices(waiting_, rows);
    waiting_.clear();
  } else {
    (per == AttributePer::face ? face_rows_ : corner_rows_).assign(rows.begin(), rows.end());
  }
}

void CountedWriter::write_triangles(std::span<const Triangle> triangles) {
  if (vertices_done_ < vertices_) {
    fail(fmt::format("triangles after {} of {} vertices", vertices_done_, vertices_));
  }
  if (triangles.size() > faces_ - faces_done_) {
    fail(fmt::format("more than the {} faces announced", faces_));
  }
  const auto in_range = [this](const Triangle& t) {
    return t[0] < vertices_ && t[1] < vertices_ && t[2] < vertices_;
  };
  const auto bad = std::find_if_not(triangles.begin(), triangles.end(), in_range);
  if (bad != triangles.end()) {
    fail(fmt::format("face {} of vertices {}, {}, {}, but there are only {}",
                     faces_done_ + static_cast<std::uint64_t>(bad - triangles.begin()), (*bad)[0],
                     (*bad)[1], (*bad)[2], vertices_));
  }
  if (!waiting_.empty()) fail("vertices without their attributes");
  expect_rows(AttributePer::face, triangles.size(), face_rows_.size());
  expect_rows(AttributePer::corner, triangles.size(), corner_rows_.size());
  if (face_rows_.empty() && corner_rows_.empty()) {
    put_triangles(triangles);
  } else {
    put_faces(triangles, face_rows_, corner_rows_);
  }
  face_rows_.clear();
  corner_rows_.clear();
  faces_done_ += triangles.size();
}

void CountedWriter::close() {
  if (vertices_done_ < vertices_ || faces_done_ < faces_) {
    fail(fmt::format("{} of {} vertices and {} of {} faces at the end", vertices_done_, vertices_,
                     faces_done_, faces_));
  }
  if (!waiting_.empty()) fail("vertices without their attributes");
  finish();
  sink_.commit();
}

void CountedWriter::fail(std::string_view what) const {
  throw Error(fmt::format("{}: cannot write a mesh with {}", sink_.path().string(), what));
}

}  // namespace remaps
