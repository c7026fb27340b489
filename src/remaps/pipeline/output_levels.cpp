#include "remaps/pipeline/output_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "remaps/resample/resampler.h"

namespace remaps::pipeline {
namespace {

constexpr std::size_t kChunk = 1 << 13;

/// Reads runs of positions that come in rising order, a chunk of the file at a time.
class PositionWindow {
 public:
  PositionWindow(const PositionArray& array, std::uint64_t count)
      : file_(store::File::open_read(array.path)), begin_(array.offset), count_(count) {}

  void send(std::uint64_t first, std::uint64_t count, PositionSink sink) {
    while (count > 0) {
      if (first < first_ || first >= first_ + held_.size()) load(first);
      const auto at = static_cast<std::size_t>(first - first_);
      const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(count, held_.size() - at));
      wide_.clear();
      for (const Vec3f& p : std::span(held_).subspan(at, n)) wide_.push_back(widen(p));
      sink(wide_);
      first += n;
      count -= n;
    }
  }

  std::uint64_t bytes_read() const { return bytes_read_; }

 private:
  void load(std::uint64_t first) {
    held_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kChunk, count_ - first)));
    file_.read_at(begin_ + first * sizeof(Vec3f), std::as_writable_bytes(std::span(held_)));
    first_ = first;
    bytes_read_ += held_.size() * sizeof(Vec3f);
  }

  store::File file_;
  std::uint64_t begin_, count_;
  std::uint64_t first_ = 0, bytes_read_ = 0;
  std::vector<Vec3f> held_;
  std::vector<Vec3> wide_;
};

class GridReader final : public IndexedMeshReader {
 public:
  GridReader(const resample::DyadicGrid& grid, PositionArray positions)
      : grid_(grid), array_(std::move(positions)) {}

  void read_positions(PositionSink sink) override {
    PositionWindow window(array_, grid_.vertices());
    sent_ = 0;
    window.send(0, grid_.vertices(), [&](std::span<const Vec3> positions) {
      sent_ += positions.size();
      sink(positions);
    });
    bytes_ += window.bytes_read();
  }
  void read_triangles(IndexSink sink) override {
    sent_ = grid_.vertices();
    resample::stream_faces(grid_, nullptr, sink);
  }

  bool positions_are_float() const override { return true; }
  std::optional<PositionArray> position_array() const override { return array_; }
  double pass_fraction() const override {
    return double(sent_) / double(std::max<std::uint64_t>(grid_.vertices(), 1));
  }
  std::uint64_t bytes_total() const override { return grid_.vertices() * sizeof(Vec3f); }
  std::uint64_t bytes_read() const override { return sent_ * sizeof(Vec3f); }
  std::uint64_t bytes_read_total() const override { return bytes_; }

 private:
  const resample::DyadicGrid& grid_;
  PositionArray array_;
  std::uint64_t sent_ = 0, bytes_ = 0;
};

}  // namespace

std::filesystem::path level_path(const std::filesystem::path& output, unsigned level) {
  return output.parent_path() /
         fmt::format("{}-l{}{}", output.stem().string(), level, output.extension().string());
}

OutputPositions::OutputPositions(std::filesystem::path path)
    : path_(std::move(path)), file_(store::File::create(path_)) {}

OutputPositions::~OutputPositions() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void OutputPositions::append(std::span<const Vec3> positions) {
  for (std::size_t first = 0; first < positions.size(); first += kChunk) {
    const auto part = positions.subspan(first, std::min(kChunk, positions.size() - first));
    chunk_.clear();
    for (const Vec3& p : part) chunk_.push_back(to_float(p));
    file_.write_at(count_ * sizeof(Vec3f), std::as_bytes(std::span(chunk_)));
    disk_.grow(chunk_.size() * sizeof(Vec3f));
    count_ += chunk_.size();
  }
}

void send_coarse_positions(const resample::DyadicGrid& finest, unsigned level,
                           const PositionArray& positions, PositionSink sink) {
  PositionWindow window(positions, finest.vertices());
  finest.coarse_vertices(
      level, [&](std::uint64_t first, std::uint64_t count) { window.send(first, count, sink); });
}

std::unique_ptr<IndexedMeshReader> make_grid_reader(const resample::DyadicGrid& grid,
                                                    PositionArray positions) {
  return std::make_unique<GridReader>(grid, std::move(positions));
}

}  // namespace remaps::pipeline
