#include "remaps/pipeline/level_replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "remaps/base/workers.h"
#include "remaps/pipeline/replay_check.h"
#include "remaps/store/bucket_file.h"

namespace remaps::pipeline {
namespace {

/// Memory of a segment in work over the bytes of its sections: unpacked, linked, and as triangles.
constexpr std::uint64_t kWorkFactor = 4;

/// A face between two levels, as it lies in the file: local id at the next level, three vertices,
/// and where it was.
constexpr std::size_t kHandedBytes = sizeof(LocalIndex) + 15 + sizeof(FaceLink);

/// One segment in work.
struct Work {
  SegmentLog log;
  Tile tile;
  std::vector<Triangle> faces;
};

class LevelReplay {
 public:
  LevelReplay(const Bundle& bundle, std::size_t level, const ReplayOptions& options,
              MemoryBudget& budget, Progress& progress, const ReplaySinks& sinks,
              store::BucketFile* before, store::BucketFile* after, ReplayedBundle& result)
      : bundle_(bundle),
        log_(bundle.log(level)),
        level_(level),
        options_(options),
        budget_(budget),
        progress_(progress),
        sinks_(sinks),
        before_(before),
        after_(after),
        result_(result) {}

  void run() {
    const std::size_t segments = log_.sections() / 2;
    const std::uint64_t bytes = largest_segment(segments);
    const unsigned threads = affordable_threads(options_.threads, bytes, budget_.available());
    const Reservation reservation = budget_.reserve(
        bytes * (threads > 1 ? threads + std::uint64_t{1} : 1), "segments being checked");
    run_ordered(segments, threads, [&](std::size_t i, unsigned) -> Commit {
      progress_.check();
      const auto segment = static_cast<std::uint32_t>(i);
      const std::shared_ptr<Work> work = check(segment);
      return [this, segment, segments, work] {
        commit(segment, *work);
        progress_.advance(double(segment + 1) / double(segments));
      };
    });
    result_.segments += segments;
  }

 private:
  std::uint64_t largest_segment(std::size_t segments) const {
    std::uint64_t largest = 0;
    for (std::size_t i = 0; i < segments; ++i) {
      std::uint64_t bytes = log_.raw_bytes(2 * i) + log_.raw_bytes(2 * i + 1);
      bytes += before_ == nullptr ? bundle_.tiles().raw_bytes(i) : before_->bytes(i);
      largest = std::max(largest, bytes);
    }
    return kWorkFactor * largest;
  }

  std::string name(std::uint32_t segment) const {
    return fmt::format("{}: segment {}", log_.path().string(), segment);
  }

  std::shared_ptr<Work> check(std::uint32_t segment) const {
    auto work = std::make_shared<Work>();
    const std::string what = name(segment);
    store::Bytes bytes;
    log_.read(2 * std::size_t{segment}, bytes);
    decode_records(bytes, what, work->log);
    log_.read(2 * std::size_t{segment} + 1, bytes);
    decode_survivors(bytes, what, work->log);
    if (work->log.level != level_) {
      throw CorruptionError(
          fmt::format("{}: says it is of level {}, not {}", what, work->log.level, level_));
    }
    before_ == nullptr ? take_tile(segment, *work) : take_faces(segment, *work);
    replay_records(work->log, what, work->faces);
    check_survivors(work->log, what, work->faces);
    return work;
  }

  void take_tile(std::uint32_t segment, Work& work) const {
    store::Bytes bytes;
    const std::string what = fmt::format("{}: tile {}", bundle_.tiles().path().string(), segment);
    bundle_.tiles().read(segment, bytes);
    decode_tile(bytes, what, work.tile);
    const Tile& tile = work.tile;
    for (const VertexId id : tile.vertex_id) {
      if (id >= bundle_.manifest().input_vertices + bundle_.manifest().copied_vertices) {
        throw CorruptionError(fmt::format("{}: there is no input vertex {}", what, id));
      }
    }
    if (tile.triangle.size() != work.log.faces) {
      throw CorruptionError(
          fmt::format("{}: has {} faces, its log {}", what, tile.triangle.size(), work.log.faces));
    }
    work.faces.reserve(tile.triangle.size());
    for (const auto& t : tile.triangle) {
      work.faces.push_back({tile.vertex_id[t[0]], tile.vertex_id[t[1]], tile.vertex_id[t[2]]});
      const Triangle& face = work.faces.back();
      if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
        throw CorruptionError(
            fmt::format("{}: face {} has a vertex twice", what, work.faces.size() - 1));
      }
    }
  }

  /// What the level before handed on must be what this level's log says it got.
  void take_faces(std::uint32_t segment, Work& work) const {
    store::Bytes bytes;
    before_->take(segment, bytes);
    work.faces.assign(work.log.faces, kDroppedFace);
    store::Unpacker unpacker(bytes, "faces between levels");
    while (!unpacker.done()) {
      const auto face = unpacker.get<LocalIndex>();
      const Triangle corners{unpacker.get40(), unpacker.get40(), unpacker.get40()};
      const auto from = unpacker.get<FaceLink>();
      const auto refuse = [&](const std::string& why) {
        throw CorruptionError(
            fmt::format("{}: face {} of segment {} of level {} leads to face {}, {}", name(segment),
                        from.face, from.segment, level_ - 1, face, why));
      };
      if (face >= work.log.faces) refuse("which does not exist");
      if (work.log.origin[face] != from) refuse("which says it came from elsewhere");
      if (work.faces[face] != kDroppedFace) refuse("and so does another");
      work.faces[face] = corners;
    }
    if (bytes.size() != kHandedBytes * work.log.faces) {
      throw CorruptionError(fmt::format("{}: {} faces, but the level before leads to {}",
                                        name(segment), work.log.faces,
                                        bytes.size() / kHandedBytes));
    }
  }

  void commit(std::uint32_t segment, const Work& work) {
    result_.records += work.log.records.size();
    if (before_ == nullptr) {
      result_.faces += work.tile.triangle.size();
      sinks_.tile(segment, work.tile);
    }
    sinks_.removed(work.log.removed);
    for (std::size_t i = 0; i < work.log.survivor.size(); ++i) {
      const FaceLink from{segment, work.log.survivor[i]};
      const FaceLink to = work.log.next[i];
      const Triangle& corners = work.faces[from.face];
      after_ != nullptr ? hand_on(from, to, corners) : add_base_face(from, to, corners);
    }
  }

  void hand_on(const FaceLink& from, const FaceLink& to, const Triangle& corners) {
    if (to.segment >= after_->buckets()) {
      throw CorruptionError(
          fmt::format("{}: face {} leads to segment {} of the next level, which has {}",
                      name(from.segment), from.face, to.segment, after_->buckets()));
    }
    after_->append_record(to.segment, [&](store::Packer& packer) {
      packer.put(to.face);
      for (const VertexId v : corners) packer.put40(v);
      packer.put(from);
    });
  }

  void add_base_face(const FaceLink& from, const FaceLink& to, const Triangle& corners) {
    const FaceLink expected{0, static_cast<LocalIndex>(result_.base.size())};
    if (to != expected) {
      throw CorruptionError(fmt::format("{}: face {} leads to base face {} (segment {}), not {}",
                                        name(from.segment), from.face, to.face, to.segment,
                                        expected.face));
    }
    result_.base.push_back(corners);
  }

  const Bundle& bundle_;
  const store::SectionFile& log_;
  const std::size_t level_;
  const ReplayOptions& options_;
  MemoryBudget& budget_;
  Progress& progress_;
  const ReplaySinks& sinks_;
  store::BucketFile* before_;
  store::BucketFile* after_;
  ReplayedBundle& result_;
};

}  // namespace

unsigned affordable_threads(unsigned wanted, std::uint64_t bytes_each, std::uint64_t available) {
  const std::uint64_t fit = available / std::max<std::uint64_t>(bytes_each, 1);
  return fit < 3 ? 1u : static_cast<unsigned>(std::min<std::uint64_t>(wanted, fit - 1));
}

ReplayedBundle replay_bundle(const Bundle& bundle, const ReplayOptions& options,
                             MemoryBudget& budget, Progress& progress, const ReplaySinks& sinks) {
  ReplayedBundle result;
  std::unique_ptr<store::BucketFile> before;
  const std::size_t levels = bundle.manifest().levels;
  for (std::size_t level = 0; level < levels; ++level) {
    progress.begin(fmt::format("records of level {}", level + 1));
    std::unique_ptr<store::BucketFile> after;
    if (level + 1 < levels) {
      after = std::make_unique<store::BucketFile>(
          options.temp_dir / fmt::format("faces-{}", level + 1),
          bundle.log(level + 1).sections() / 2, options.buffer_bytes / 2, budget);
    }
    LevelReplay(bundle, level, options, budget, progress, sinks, before.get(), after.get(), result)
        .run();
    before = std::move(after);
  }
  return result;
}

}  // namespace remaps::pipeline
