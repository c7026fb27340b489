#include "remaps/pipeline/vertex_ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "remaps/base/workers.h"
#include "remaps/pipeline/level_replay.h"
#include "remaps/pipeline/map_file.h"

namespace remaps::pipeline {
namespace {

/// What a distance may amount to, as a fraction of the diagonal: floats in map.bin and a chain of
/// some dozens of records on the grid stay far below.
constexpr double kTolerance = 1e-6;

/// What weights on the same base face may differ by: map.bin is made by the same exact steps, and
/// then rounded to floats, by at most 2^-25.
constexpr double kFloatTolerance = 0x1p-23;

/// Bytes in the file and in memory that a vertex takes, about.
constexpr std::uint64_t kBytesPerVertex = 160;

constexpr std::uint64_t kCensusBlock = 1 << 20;

enum Kind : std::uint8_t { kTile, kRemoved, kBase, kOnBase, kReturned };

/// What has been said of a vertex.
enum Seen : std::uint8_t { kOwn = 1, kUsed = 2, kGone = 4, kCarried = 8, kBack = 16 };

std::size_t blocks_for(std::uint64_t count, std::uint64_t block) {
  return static_cast<std::size_t>((count + block - 1) / block);
}

}  // namespace

Vec3 position_on_base(const BaseMesh& base, const map::FacePoint& at) {
  const auto& t = base.triangle[at.face];
  const Vec3 a = widen(base.position[t[0]]);
  return a + at.u * (widen(base.position[t[1]]) - a) + at.v * (widen(base.position[t[2]]) - a);
}

NumberCensus::NumberCensus(const std::filesystem::path& path, std::uint64_t count,
                           std::uint64_t buffer_bytes, MemoryBudget& budget)
    : count_(count), file_(path, blocks_for(count, kCensusBlock), buffer_bytes, budget) {}

void NumberCensus::add(std::uint64_t number, const char* what) {
  if (number >= count_) {
    throw CorruptionError(
        fmt::format("the tiles name {} {}, but the input has {}", what, number, count_));
  }
  file_.append_record(static_cast<std::size_t>(number / kCensusBlock), [&](store::Packer& packer) {
    packer.put(static_cast<std::uint32_t>(number % kCensusBlock));
  });
}

void NumberCensus::finish(const char* what, std::uint64_t absent) {
  store::Bytes bytes;
  std::uint64_t missed = 0;
  std::vector<bool> seen;
  for (std::size_t b = 0; b < file_.buckets(); ++b) {
    const std::uint64_t first = b * kCensusBlock;
    seen.assign(static_cast<std::size_t>(std::min(kCensusBlock, count_ - first)), false);
    for (std::uint64_t at = 0; at < file_.bytes(b); at += bytes.size()) {
      file_.read(b, at, std::min<std::uint64_t>(file_.bytes(b) - at, 4 << 16), bytes);
      store::Unpacker unpacker(bytes, "a census");
      while (!unpacker.done()) {
        const auto number = unpacker.get<std::uint32_t>();
        if (seen[number]) {
          throw CorruptionError(fmt::format("{} {} is in the tiles twice", what, first + number));
        }
        seen[number] = true;
      }
    }
    file_.release(b);
    const auto missing = std::find(seen.begin(), seen.end(), false);
    missed += static_cast<std::uint64_t>(std::count(missing, seen.end(), false));
    if (missed > absent) {
      throw CorruptionError(fmt::format(
          "{} {} is in no tile", what, first + static_cast<std::uint64_t>(missing - seen.begin())));
    }
  }
  if (missed != absent) {
    throw CorruptionError(
        fmt::format("{} faces were left out by repair, but {} are in no tile", absent, missed));
  }
}

/// The entries of consecutive ids, joined.
struct VertexLedger::Block {
  const Bundle& bundle;
  std::uint64_t first = 0;
  double scale = 0;                // 1 / diagonal
  std::vector<std::uint8_t> seen;  // (n) flags
  std::vector<Vec3f> position;     // (n)
  std::vector<MapRecord> map;      // (n) without copies, which come last
  std::vector<double> error;       // (n) round trip, largest of the vertex
  LedgerResult result;

  [[noreturn]] void refuse(std::uint32_t i, const std::string& why) const {
    throw CorruptionError(
        fmt::format("{}: input vertex {}: {}", bundle.directory().string(), first + i, why));
  }
  void note(std::uint32_t i, Seen flag) { seen[i] = static_cast<std::uint8_t>(seen[i] | flag); }

  void set_own(std::uint32_t i, const Vec3f& p) {
    if (seen[i] & kOwn) refuse(i, "two tiles call it their own");
    note(i, kOwn);
    position[i] = p;
    result.box.add(widen(p));
  }

  void check_gone(std::uint32_t i) {
    if (seen[i] & kGone) refuse(i, "it is removed twice, or removed and in the base");
    note(i, kGone);
  }

  void check_base(std::uint32_t i, std::uint32_t base_vertex) {
    check_gone(i);
    const Vec3& origin = bundle.manifest().origin;
    const Vec3f stored = to_float(origin + widen(position[i]));
    if (to_float(widen(stored) - origin) != bundle.base().position[base_vertex]) {
      refuse(i, fmt::format("base.ply has it elsewhere, as base vertex {}", base_vertex));
    }
  }

  void check_on_base(std::uint32_t i, const map::FacePoint& at) {
    note(i, kCarried);
    if (i >= map.size()) return;  // a copy
    const MapRecord& m = map[i];
    const map::FacePoint stored{m.face, m.u, m.v};
    if (m.face >= bundle.base().triangle.size()) {
      refuse(i, m.face == MapRecord{}.face
                    ? "map.bin says that it has no face"
                    : fmt::format("map.bin has it on base face {}, which does not exist", m.face));
    }
    const bool inside = m.u >= 0 && m.v >= 0 && stored.u + stored.v <= 1 + kTolerance;
    if (!inside) refuse(i, fmt::format("its weights in map.bin are {} and {}", m.u, m.v));
    const double distance =
        scale * norm(position_on_base(bundle.base(), stored) - position_on_base(bundle.base(), at));
    const bool same = at.face != m.face || (std::abs(at.u - stored.u) <= kFloatTolerance &&
                                            std::abs(at.v - stored.v) <= kFloatTolerance);
    if (!(distance <= kTolerance) || !same) {
      refuse(i, fmt::format("map.bin has it on base face {} at ({}, {}), the log on {} at ({}, {})",
                            m.face, m.u, m.v, at.face, at.u, at.v));
    }
    result.map_file_max = std::max(result.map_file_max, distance);
  }

  void check_returned(std::uint32_t i, const Vec3& p) {
    note(i, kBack);
    const double distance = scale * norm(p - widen(position[i]));
    if (!(distance <= kTolerance)) {
      refuse(i, fmt::format("it returns from the base {} diagonals beside its place", distance));
    }
    error[i] = std::max(error[i], distance);
  }

  /// The first pass finds the position of each vertex, the second compares the rest.
  void read(store::ByteSpan bytes, bool own_pass) {
    store::Unpacker unpacker(bytes, "the vertex ledger");
    while (!unpacker.done()) {
      const auto kind = unpacker.get<std::uint8_t>();
      const auto i = unpacker.get<std::uint32_t>();
      if (kind == kTile) {
        const auto flags = unpacker.get<std::uint8_t>();
        const auto p = unpacker.get<Vec3f>();
        if (own_pass && (flags & kOwn)) set_own(i, p);
        if (own_pass) continue;
        if (!(seen[i] & kOwn)) refuse(i, "no tile calls it its own");
        if (std::memcmp(&p, &position[i], sizeof p) != 0) {
          refuse(i, "two tiles have it at different places");
        }
        if (flags & kUsed) note(i, kUsed);
      } else if (kind == kRemoved) {
        if (!own_pass) check_gone(i);
      } else if (kind == kBase) {
        const auto base_vertex = unpacker.get<std::uint32_t>();
        if (!own_pass) check_base(i, base_vertex);
      } else if (kind == kOnBase) {
        const auto at = unpacker.get<map::FacePoint>();
        if (!own_pass) check_on_base(i, at);
      } else {
        const auto p = unpacker.get<Vec3>();
        if (!own_pass) check_returned(i, p);
      }
    }
  }

  void check_complete() {
    for (std::uint32_t i = 0; i < seen.size(); ++i) {
      if (!(seen[i] & kOwn)) {
        if (i >= map.size() || map[i].face != MapRecord{}.face) refuse(i, "no tile has it");
        ++result.absent;
        continue;
      }
      const bool used = (seen[i] & kUsed) != 0;
      if (used != ((seen[i] & kGone) != 0)) {
        refuse(i, used ? "it has faces, but is neither removed nor in the base"
                       : "it has no face, but is removed or in the base");
      }
      const bool placed = i < map.size() && map[i].face != MapRecord{}.face;
      if (!used && placed) refuse(i, "has no face, but one in map.bin");
      if (!used) continue;
      if (!(seen[i] & kCarried)) refuse(i, "it was not carried to the base");
      if (!(seen[i] & kBack)) refuse(i, "it did not return from the base");
      ++result.vertices;
      result.round_trip_max = std::max(result.round_trip_max, error[i]);
      result.round_trip_sum += error[i];
    }
  }
};

VertexLedger::VertexLedger(const std::filesystem::path& temp_dir, const Bundle& bundle,
                           std::uint64_t buffer_bytes, MemoryBudget& budget)
    : bundle_(bundle),
      budget_(budget),
      vertices_(bundle.manifest().input_vertices + bundle.manifest().copied_vertices),
      block_(std::clamp<std::uint64_t>(buffer_bytes / kBytesPerVertex, 1 << 12, 1 << 20)),
      map_file_(store::File::open_read(bundle.directory() / kMapName)),
      file_(temp_dir / "vertex-ledger", blocks_for(vertices_, block_), buffer_bytes / 2, budget) {}

void VertexLedger::append(VertexId vertex, std::uint8_t kind, store::ByteSpan rest) {
  if (vertex >= vertices_) {
    throw CorruptionError(
        fmt::format("{}: there is no input vertex {}", bundle_.directory().string(), vertex));
  }
  file_.append_record(static_cast<std::size_t>(vertex / block_), [&](store::Packer& packer) {
    packer.put(kind);
    packer.put(static_cast<std::uint32_t>(vertex % block_));
    packer.put_array(rest);
  });
}

void VertexLedger::add_tile(const Tile& tile) {
  std::vector<std::uint8_t> flags(tile.vertex_id.size(), 0);
  std::fill_n(flags.begin(), tile.own_vertices, std::uint8_t{kOwn});
  for (const auto& t : tile.triangle) {
    for (const LocalIndex v : t) flags[v] |= kUsed;
  }
  for (std::size_t v = 0; v < flags.size(); ++v) {
    std::array<std::byte, 1 + sizeof(Vec3f)> rest{std::byte{flags[v]}};
    std::memcpy(rest.data() + 1, &tile.position[v], sizeof(Vec3f));
    append(tile.vertex_id[v], kTile, rest);
  }
}

void VertexLedger::add_removed(VertexId vertex) {
  append(vertex, kRemoved, {});
}

void VertexLedger::add_base(VertexId vertex, std::uint32_t base_vertex) {
  append(vertex, kBase, std::as_bytes(std::span(&base_vertex, 1)));
}

void VertexLedger::add_on_base(VertexId vertex, const map::FacePoint& at) {
  append(vertex, kOnBase, std::as_bytes(std::span(&at, 1)));
}

void VertexLedger::add_returned(VertexId vertex, const Vec3& position) {
  append(vertex, kReturned, std::as_bytes(std::span(&position, 1)));
}

VertexLedger::Block VertexLedger::take_block(std::size_t number) {
  const std::uint64_t first = number * block_;
  const auto n = static_cast<std::size_t>(std::min(block_, vertices_ - first));
  const double diagonal = bundle_.manifest().diagonal;
  Block block{bundle_, first, diagonal > 0 ? 1 / diagonal : 0, {}, {}, {}, {}, {}};
  block.seen.assign(n, 0);
  block.position.resize(n);
  const std::uint64_t of_input = bundle_.manifest().input_vertices;
  block.map.resize(
      static_cast<std::size_t>(std::min<std::uint64_t>(n, of_input - std::min(first, of_input))));
  block.error.assign(n, 0);
  map_file_.read_at(first * sizeof(MapRecord), std::as_writable_bytes(std::span(block.map)));
  store::Bytes bytes;
  file_.take(number, bytes);
  block.read(bytes, true);
  block.read(bytes, false);
  block.check_complete();
  return block;
}

LedgerResult VertexLedger::compare(unsigned threads, Progress& progress) {
  std::uint64_t largest = 0;
  for (std::size_t b = 0; b < file_.buckets(); ++b) largest = std::max(largest, file_.bytes(b));
  largest += block_ * (sizeof(Vec3f) + sizeof(MapRecord) + sizeof(double) + 1);
  threads = affordable_threads(threads, largest, budget_.available());
  const Reservation reservation = budget_.reserve(largest * threads, "comparing vertices");
  LedgerResult total;
  run_ordered(file_.buckets(), threads, [&](std::size_t b, unsigned) -> Commit {
    progress.check();
    const LedgerResult part = take_block(b).result;
    return [&, part, b] {
      total.vertices += part.vertices;
      total.absent += part.absent;
      total.round_trip_max = std::max(total.round_trip_max, part.round_trip_max);
      total.round_trip_sum += part.round_trip_sum;
      total.map_file_max = std::max(total.map_file_max, part.map_file_max);
      if (!part.box.empty()) {
        total.box.add(part.box.low);
        total.box.add(part.box.high);
      }
      progress.advance(double(b + 1) / double(file_.buckets()));
    };
  });
  return total;
}

}  // namespace remaps::pipeline
