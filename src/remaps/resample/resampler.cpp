#include "remaps/resample/resampler.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "remaps/base/workers.h"
#include "remaps/store/bucket_file.h"

namespace remaps::resample {
namespace {

using map::PointBuckets;
using map::SegmentMap;
using map::TaggedPoint;

/// Memory of a segment's log in work over the bytes of its sections: unpacked and linked. While one
/// is read there are its bytes beside it, packed and unpacked.
constexpr std::uint64_t kLoadedFactor = 2;
constexpr std::uint64_t kReadFactor = 2;

/// The part of the time after which all positions are known, on disk in the order of place.
constexpr double kPulledPart = 0.96;

/// What the largest segment and tile take, as often as there may be some in work or waiting.
std::uint64_t bytes_in_work(const MapFiles& files, unsigned threads) {
  const std::uint64_t at_a_time = threads > 1 ? 2 * std::uint64_t{threads} + 1 : 1;
  std::uint64_t most = 0;
  for (const store::SectionFile* log : files.logs) {
    std::uint64_t largest = 0;
    for (std::size_t s = 0; s + 1 < log->sections(); s += 2) {
      largest = std::max(largest, log->raw_bytes(s) + log->raw_bytes(s + 1));
    }
    const std::uint64_t alive = std::min<std::uint64_t>(at_a_time, log->sections() / 2);
    most = std::max(most, largest * (kLoadedFactor * alive + kReadFactor));
  }
  std::uint64_t largest = 0;
  for (std::size_t t = 0; t < files.tiles->sections(); ++t) {
    largest = std::max(largest, files.tiles->raw_bytes(t));
  }
  const std::uint64_t alive = std::min<std::uint64_t>(at_a_time, files.tiles->sections());
  return std::max(most, largest * (kLoadedFactor * alive + kReadFactor));
}

/// How the time of pulling back is shared out among its steps: reading the logs and tiles, passing
/// the points on, and their way through a level's records, which grows with the logarithm of what
/// it removed. Measured with some millions of points.
class PullShares {
 public:
  PullShares(const MapFiles& files, std::uint64_t points) {
    // What lists the faces of the base takes a quarter of the records that made as many.
    double after = 4 * double(files.logs.back()->raw_bytes(1)) + 1;
    for (std::size_t level = files.logs.size(); level-- > 0;) {
      const store::SectionFile& log = *files.logs[level];
      const double read = raw_bytes(log);
      add(read, double(points) * (kStepping * std::log(1 + read / after) + kPassingOn));
      after += read;
    }
    add(raw_bytes(*files.tiles), double(points) * kPassingOn);
  }

  /// The bounds of a step of pull_back: first the last level, after the first the tiles.
  std::pair<double, double> part(std::size_t step) const {
    return {begin_[step] / begin_.back(), begin_[step + 1] / begin_.back()};
  }

 private:
  // Nanoseconds a byte, a point and factor e, a point.
  static constexpr double kReading = 2.5, kStepping = 85, kPassingOn = 100;

  static double raw_bytes(const store::SectionFile& file) {
    double sum = 0;
    for (std::size_t s = 0; s < file.sections(); ++s) sum += double(file.raw_bytes(s));
    return sum;
  }
  void add(double read, double carried) {
    begin_.push_back(begin_.back() + kReading * read + carried);
  }

  std::vector<double> begin_{0};
};

/// Local ids in the last level's log of the base faces. On the base mesh a face is known by its
/// number there.
std::vector<LocalIndex> base_faces(const store::SectionFile& log) {
  const std::string what = log.path().string() + ": segment 0";
  store::Bytes bytes;
  SegmentLog last;
  log.read(0, bytes);
  decode_records(bytes, what, last);
  log.read(1, bytes);
  decode_survivors(bytes, what, last);
  return std::move(last.survivor);
}

/// All vertices of a grid as points of the last level, made when asked for.
class GridPoints final : public map::PointSupply {
 public:
  GridPoints(const DyadicGrid& grid, std::vector<LocalIndex> base_face)
      : grid_(grid), base_face_(std::move(base_face)) {}

  std::size_t segments() const override { return 1; }
  std::uint64_t count(std::size_t) const override { return grid_.vertices(); }
  void read(std::size_t, std::uint64_t first, std::uint64_t n,
            std::vector<TaggedPoint>& out) const override {
    out.resize(static_cast<std::size_t>(n));
    grid_.samples(first, out);
    for (TaggedPoint& point : out) {
      if (point.at.face >= base_face_.size()) throw GeometryError("there is no such base face");
      point.at.face = base_face_[point.at.face];
    }
  }
  void release(std::size_t) override {}

 private:
  const DyadicGrid& grid_;
  std::vector<LocalIndex> base_face_;
};

/// Sends the points of each tile to the sink, in pieces.
void visit_tiles(const store::SectionFile& tiles, PointBuckets& points,
                 const ResampleOptions& options, const TileSink& sink) {
  const std::size_t piece = options.carry.map_buffer;
  run_ordered(tiles.sections(), options.carry.threads, [&](std::size_t i, unsigned) -> Commit {
    if (options.carry.progress != nullptr) options.carry.progress->check();
    if (points.count(i) == 0) return [] {};
    auto tile = std::make_shared<Tile>();
    store::Bytes bytes;
    tiles.read(i, bytes);
    decode_tile(bytes, tiles.path().string() + ": tile " + std::to_string(i), *tile);
    return [&, i, tile] {
      std::vector<TaggedPoint> batch;
      for (std::uint64_t first = 0; first < points.count(i); first += piece) {
        points.read(i, first, std::min<std::uint64_t>(piece, points.count(i) - first), batch);
        for (const TaggedPoint& point : batch) {
          if (point.at.face >= tile->triangle.size())
            throw CorruptionError("a point lies on a face that no tile has");
        }
        sink(static_cast<std::uint32_t>(i), *tile, batch);
      }
      points.release(i);
      if (options.carry.progress != nullptr) {
        options.carry.progress->advance(double(i + 1) / double(tiles.sections()));
      }
    };
  });
}

/// Results on their way to the output order: blocks of consecutive numbers. Positions are Vec3 or
/// Vec3f.
template <class Position>
class PositionBlocks {
 public:
  PositionBlocks(std::uint64_t count, const std::filesystem::path& temp_dir,
                 std::uint64_t buffer_bytes, MemoryBudget& budget)
      : count_(count),
        block_(std::clamp<std::uint64_t>(buffer_bytes / 2 / sizeof(Position), 1 << 12, 1 << 22)),
        file_(temp_dir / "positions", static_cast<std::size_t>((count + block_ - 1) / block_),
              buffer_bytes / 4, budget),
        budget_(budget) {}

  void add(std::uint64_t number, const Vec3& position) {
    file_.append_record(static_cast<std::size_t>(number / block_), [&](store::Packer& packer) {
      packer.put(static_cast<std::uint32_t>(number % block_));
      packer.put(stored(position));
    });
  }

  /// @throws CorruptionError  a number is missing
  void send(Progress* progress, PositionSink sink) {
    const Reservation reservation =
        budget_.reserve(std::min(block_, count_) * sizeof(Position), "an output block");
    std::vector<Position> positions;
    std::vector<Vec3> chunk;
    for (std::size_t b = 0; b < file_.buckets(); ++b) {
      if (progress != nullptr) progress->advance(double(b) / double(file_.buckets()));
      positions.resize(static_cast<std::size_t>(std::min(block_, count_ - b * block_)));
      if (file_.bytes(b) != positions.size() * kRecordBytes) {
        throw CorruptionError("samples were lost on the way");
      }
      take_block(b, positions);
      for (std::size_t first = 0; first < positions.size(); first += kChunk) {
        const auto part = std::span(positions).subspan(first);
        chunk.clear();
        for (const Position& p : part.first(std::min(kChunk, part.size()))) {
          chunk.push_back(loaded(p));
        }
        sink(chunk);
      }
    }
  }

 private:
  static constexpr std::size_t kRecordBytes = 4 + sizeof(Position);
  static constexpr std::size_t kChunk = 1 << 13;

  static Position stored(const Vec3& p) {
    if constexpr (std::is_same_v<Position, Vec3f>) {
      return to_float(p);
    } else {
      return p;
    }
  }
  static Vec3 loaded(const Position& p) {
    if constexpr (std::is_same_v<Position, Vec3f>) {
      return widen(p);
    } else {
      return p;
    }
  }

  void take_block(std::size_t b, std::vector<Position>& positions) {
    for (std::uint64_t at = 0; at < file_.bytes(b); at += bytes_.size()) {
      file_.read(b, at, std::min<std::uint64_t>(file_.bytes(b) - at, kChunk * kRecordBytes),
                 bytes_);
      store::Unpacker unpacker(bytes_, "resampled positions");
      while (!unpacker.done()) {
        const auto number = unpacker.get<std::uint32_t>();
        positions.at(number) = unpacker.get<Position>();
      }
    }
    file_.release(b);
  }

  std::uint64_t count_;
  std::uint64_t block_;
  store::BucketFile file_;
  MemoryBudget& budget_;
  store::Bytes bytes_;
};

/// Pulls points back through one level after the other.
class Descent {
 public:
  Descent(const MapFiles& files, const ResampleOptions& options, MemoryBudget& budget)
      : files_(files),
        options_(options),
        budget_(budget),
        in_work_(budget.reserve(bytes_in_work(files, options.carry.threads),
                                "the largest segment of the map")),
        buffer_bytes_(std::min(options.buffer_bytes, budget.available() / 2)) {}

  std::uint64_t buffer_bytes() const { return buffer_bytes_; }

  std::unique_ptr<PointBuckets> make_buckets(const std::string& name, std::size_t segments) const {
    return std::make_unique<PointBuckets>(options_.temp_dir / ("points-" + name), segments,
                                          buffer_bytes_ / 2, budget_);
  }

  /// @param points  of the last level, given away
  void run(std::unique_ptr<map::PointSupply> points, const TileSink& sink) const {
    const PullShares shares(files_, points->count(0));
    std::size_t step = 0;
    std::unique_ptr<PointBuckets> before;
    for (std::size_t level = files_.logs.size(); level-- > 0;) {
      const map::LevelMap map(*files_.logs[level]);
      const std::size_t targets =
          level == 0 ? files_.tiles->sections() : files_.logs[level - 1]->sections() / 2;
      const auto [from, to] = shares.part(step++);
      const ProgressPart part(options_.carry.progress, from, to);
      auto next = make_buckets(level == 0 ? "tiles" : std::to_string(level - 1), targets);
      map::carry_points(map, SegmentMap::Direction::kInverse, *points, options_.carry,
                        [&](const FaceLink& link, const TaggedPoint& point) {
                          if (link.segment >= targets)
                            throw CorruptionError("a log leads to a segment that does not exist");
                          next->add(link.segment, point);
                        });
      if (level == 0) {
        points.reset();
        before = std::move(next);
      } else {
        points = std::move(next);
      }
    }
    const auto [from, to] = shares.part(step);
    const ProgressPart part(options_.carry.progress, from, to);
    visit_tiles(*files_.tiles, *before, options_, sink);
  }

 private:
  const MapFiles& files_;
  const ResampleOptions& options_;
  MemoryBudget& budget_;
  const Reservation in_work_;
  const std::uint64_t buffer_bytes_;
};

template <class Position>
void send_positions(const MapFiles& files, const DyadicGrid& grid, const ResampleOptions& options,
                    MemoryBudget& budget, PositionSink sink, SampleObserver* observer) {
  std::optional<Descent> descent(std::in_place, files, options, budget);
  PositionBlocks<Position> positions(grid.vertices(), options.temp_dir, descent->buffer_bytes(),
                                     budget);
  if (observer != nullptr) observer->begin(descent->buffer_bytes() / 4);
  std::optional<ProgressPart> part(std::in_place, options.carry.progress, 0, kPulledPart);
  descent->run(std::make_unique<GridPoints>(grid, base_faces(*files.logs.back())),
               [&](std::uint32_t, const Tile& tile, std::span<const TaggedPoint> points) {
                 for (const TaggedPoint& point : points) {
                   positions.add(point.tag, options.origin + position_on_tile(tile, point.at));
                 }
                 if (observer != nullptr) observer->see(tile, points);
               });
  descent.reset();
  if (observer != nullptr) observer->end();
  part.reset();
  part.emplace(options.carry.progress, kPulledPart, 1);
  positions.send(options.carry.progress, sink);
}

}  // namespace

Vec3 position_on_tile(const Tile& tile, const map::FacePoint& at) {
  const auto& t = tile.triangle[at.face];
  // A weighted sum, not offsets from one corner: exact at every corner.
  return (1 - at.u - at.v) * widen(tile.position[t[0]]) + at.u * widen(tile.position[t[1]]) +
         at.v * widen(tile.position[t[2]]);
}

void pull_back(const MapFiles& files, const PointProducer& produce, const ResampleOptions& options,
               MemoryBudget& budget, const TileSink& sink) {
  const Descent descent(files, options, budget);
  auto points = descent.make_buckets("base", 1);
  const std::vector<LocalIndex> base_face = base_faces(*files.logs.back());
  produce([&](const TaggedPoint& point) {
    if (point.at.face >= base_face.size()) throw GeometryError("there is no such base face");
    points->add(0, {point.tag, {base_face[point.at.face], point.at.u, point.at.v}});
  });
  descent.run(std::move(points), sink);
}

void resample_positions(const MapFiles& files, const DyadicGrid& grid,
                        const ResampleOptions& options, MemoryBudget& budget, PositionSink sink,
                        SampleObserver* observer) {
  if (grid.vertices() > store::kMaxId40) {
    throw BudgetError(std::to_string(grid.vertices()) + " vertices at level " +
                      std::to_string(grid.level()) + ", but at most " +
                      std::to_string(store::kMaxId40) + " can be resampled; use a lower level");
  }
  if (options.as_floats) {
    send_positions<Vec3f>(files, grid, options, budget, sink, observer);
  } else {
    send_positions<Vec3>(files, grid, options, budget, sink, observer);
  }
}

void stream_faces(const DyadicGrid& grid, Progress* progress, IndexSink sink) {
  constexpr std::uint64_t kChunk = 1 << 13;
  std::vector<Triangle> chunk;
  for (std::uint64_t first = 0; first < grid.faces(); first += kChunk) {
    if (progress != nullptr) progress->advance(double(first) / double(grid.faces()));
    chunk.resize(static_cast<std::size_t>(std::min(kChunk, grid.faces() - first)));
    grid.triangles(first, chunk);
    sink(chunk);
  }
}

}  // namespace remaps::resample
