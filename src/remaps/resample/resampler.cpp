#include "remaps/resample/resampler.h"

#include <algorithm>
#include <memory>

#include "remaps/base/workers.h"
#include "remaps/store/bucket_file.h"

namespace remaps::resample {
namespace {

using map::PointBuckets;
using map::SegmentMap;
using map::TaggedPoint;

std::unique_ptr<PointBuckets> make_buckets(const ResampleOptions& options, std::size_t level,
                                           std::size_t segments, MemoryBudget& budget) {
  return std::make_unique<PointBuckets>(options.temp_dir / ("points-" + std::to_string(level)),
                                        segments, options.buffer_bytes / 2, budget);
}

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

/// Results on their way to the output order: blocks of consecutive numbers.
class PositionBlocks {
 public:
  PositionBlocks(std::uint64_t count, const ResampleOptions& options, MemoryBudget& budget)
      : count_(count),
        block_(
            std::clamp<std::uint64_t>(options.buffer_bytes / (4 * sizeof(Vec3)), 1 << 12, 1 << 22)),
        file_(options.temp_dir / "positions",
              static_cast<std::size_t>((count + block_ - 1) / block_), options.buffer_bytes / 4,
              budget),
        reservation_(budget.reserve(std::min(block_, count) * (sizeof(Vec3) + kRecordBytes),
                                    "an output block")) {}

  void add(std::uint64_t number, const Vec3& position) {
    file_.append_record(static_cast<std::size_t>(number / block_), [&](store::Packer& packer) {
      packer.put(static_cast<std::uint32_t>(number % block_));
      packer.put(position);
    });
  }

  /// @throws CorruptionError  a number is missing
  void send(PositionSink sink) {
    std::vector<Vec3> positions;
    store::Bytes bytes;
    for (std::size_t b = 0; b < file_.buckets(); ++b) {
      file_.take(b, bytes);
      positions.resize(static_cast<std::size_t>(std::min(block_, count_ - b * block_)));
      if (bytes.size() != positions.size() * kRecordBytes)
        throw CorruptionError("samples were lost on the way");
      store::Unpacker unpacker(bytes, "resampled positions");
      while (!unpacker.done()) {
        const auto number = unpacker.get<std::uint32_t>();
        positions.at(number) = unpacker.get<Vec3>();
      }
      sink(positions);
    }
  }

 private:
  static constexpr std::size_t kRecordBytes = 4 + sizeof(Vec3);

  std::uint64_t count_;
  std::uint64_t block_;
  store::BucketFile file_;
  Reservation reservation_;
};

}  // namespace

Vec3 position_on_tile(const Tile& tile, const map::FacePoint& at) {
  const auto& t = tile.triangle[at.face];
  // A weighted sum, not offsets from one corner: exact at every corner.
  return (1 - at.u - at.v) * widen(tile.position[t[0]]) + at.u * widen(tile.position[t[1]]) +
         at.v * widen(tile.position[t[2]]);
}

void pull_back(const MapFiles& files, const PointProducer& produce, const ResampleOptions& options,
               MemoryBudget& budget, const TileSink& sink) {
  std::size_t level = files.logs.size() - 1;
  auto points = make_buckets(options, level, 1, budget);
  // On the base mesh a face is known by its number there; the last level's log by its local id.
  const auto last = map::LevelMap(*files.logs[level]).load(0, SegmentMap::Direction::kInverse);
  const std::vector<LocalIndex>& base_face = last->log.survivor;
  produce([&](const TaggedPoint& point) {
    if (point.at.face >= base_face.size()) throw GeometryError("there is no such base face");
    points->add(0, {point.tag, {base_face[point.at.face], point.at.u, point.at.v}});
  });
  for (;; --level) {
    const map::LevelMap map(*files.logs[level]);
    const std::size_t targets =
        level == 0 ? files.tiles->sections() : files.logs[level - 1]->sections() / 2;
    auto next = make_buckets(options, level == 0 ? files.logs.size() : level - 1, targets, budget);
    map::carry_points(map, SegmentMap::Direction::kInverse, *points, options.carry,
                      [&](const FaceLink& link, const TaggedPoint& point) {
                        if (link.segment >= targets)
                          throw CorruptionError("a log leads to a segment that does not exist");
                        next->add(link.segment, point);
                      });
    points = std::move(next);
    if (level == 0) break;
  }
  visit_tiles(*files.tiles, *points, options, sink);
}

void resample_positions(const MapFiles& files, const DyadicGrid& grid,
                        const ResampleOptions& options, MemoryBudget& budget, PositionSink sink) {
  PositionBlocks positions(grid.vertices(), options, budget);
  const auto samples = [&](const std::function<void(const TaggedPoint&)>& add) {
    grid.for_each_sample([&](std::uint64_t number, std::uint32_t face, double u, double v) {
      add({number, {face, u, v}});
    });
  };
  pull_back(files, samples, options, budget,
            [&](std::uint32_t, const Tile& tile, std::span<const TaggedPoint> points) {
              for (const TaggedPoint& point : points) {
                positions.add(point.tag, options.origin + position_on_tile(tile, point.at));
              }
            });
  positions.send(sink);
}

void stream_faces(const DyadicGrid& grid, Progress* progress, IndexSink sink) {
  constexpr std::uint64_t kChunk = 1 << 14;
  std::vector<Triangle> chunk;
  for (std::uint64_t first = 0; first < grid.faces(); first += kChunk) {
    if (progress != nullptr) progress->check();
    chunk.clear();
    for (std::uint64_t f = first; f < std::min(first + kChunk, grid.faces()); ++f) {
      chunk.push_back(grid.triangle(f));
    }
    sink(chunk);
  }
}

}  // namespace remaps::resample
