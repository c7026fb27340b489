#include <xxhash.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "fuzz_targets.h"
#include "remaps/base/errors.h"
#include "remaps/map/level_map.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/store/section_file.h"

namespace remaps::fuzz {
namespace {

/// Where docs/formats/sections.md has the checksums.
constexpr std::size_t kHeaderBytes = 16, kEntryBytes = 32, kTrailerBytes = 32;
/// Sections may unpack to 32768 times their size; a run decides by its budget whether to.
constexpr std::uint64_t kBudgetBytes = 1 << 20;

std::uint64_t load64(const store::Bytes& bytes, std::size_t at) {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void seal(store::Bytes& bytes, std::size_t at, std::size_t from, std::size_t size) {
  const std::uint64_t checksum = XXH3_64bits(bytes.data() + from, size);
  std::memcpy(bytes.data() + at, &checksum, sizeof checksum);
}

/// Puts the checksums of a section file right, as far as it has the shape of one.
void seal_section_file(store::Bytes& bytes) {
  if (bytes.size() < kHeaderBytes + kTrailerBytes) return;
  const std::size_t trailer = bytes.size() - kTrailerBytes;
  const std::uint64_t index = load64(bytes, trailer);
  const std::uint64_t sections = load64(bytes, trailer + 8);
  if (index > trailer || sections != (trailer - index) / kEntryBytes) return;
  for (std::size_t i = 0; i < sections; ++i) {
    const std::size_t entry = index + i * kEntryBytes;
    const std::uint64_t offset = load64(bytes, entry);
    const std::uint64_t size = load64(bytes, entry + 8);
    if (offset > index || size > index - offset) return;
    seal(bytes, entry + 24, offset, size);
  }
  seal(bytes, trailer + 16, index, trailer - index);
}

void read_section_file(const std::filesystem::path& path, std::array<char, 4> kind) {
  try {
    const store::SectionFile file(path, kind);
    store::Bytes bytes;
    for (std::size_t i = 0; i < file.sections(); ++i) {
      if (file.raw_bytes(i) > kBudgetBytes) continue;
      file.read(i, bytes);
      expect(bytes.size() == file.raw_bytes(i), "a section has the size that the index says");
    }
  } catch (const CorruptionError&) {
  }
}

void fuzz_section_file(Input input) {
  const std::filesystem::path path = scratch_directory() / "sections.bin";
  store::Bytes bytes(input.begin(), input.end());
  write_file(path, bytes);
  read_section_file(path, kLogKind);
  seal_section_file(bytes);
  write_file(path, bytes);
  read_section_file(path, kLogKind);
  read_section_file(path, kTileKind);
}

/// A few points on each of a few faces: corners, a midpoint of an edge, the middle.
std::vector<map::FacePoint> some_points(std::span<const LocalIndex> faces) {
  constexpr std::pair<double, double> kWeights[] = {
      {0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {1 / 3.0, 1 / 3.0}};
  constexpr std::size_t kFaces = 64;
  std::vector<map::FacePoint> points;
  const std::size_t step = std::max<std::size_t>(1, faces.size() / kFaces);
  for (std::size_t i = 0; i < faces.size(); i += step) {
    for (const auto& [u, v] : kWeights) points.push_back({faces[i], u, v});
  }
  return points;
}

void check_points(std::span<const map::FacePoint> points, std::size_t faces) {
  for (const map::FacePoint& p : points) {
    expect(p.face < faces, "a point ends on a face that exists");
    expect(!(p.u < 0) && !(p.v < 0) && !(p.u + p.v > 1 + 1e-9), "weights are not negative");
  }
}

void carry(const map::LevelMap& level, map::SegmentMap::Direction direction,
           const SegmentLog& log) {
  const auto loaded = level.load(0, direction);
  std::vector<LocalIndex> faces = log.survivor;
  if (direction == map::SegmentMap::Direction::kForward) {
    faces.resize(std::min<std::size_t>(log.faces, 1 << 16));
    for (LocalIndex f = 0; f < faces.size(); ++f) faces[f] = f;
    std::vector<map::FacePoint> removed(loaded->map.records());
    loaded->map.carry_removed(removed);
    check_points(removed, log.faces);
  }
  std::vector<map::FacePoint> points = some_points(faces);
  loaded->carry(points);
  check_points(points, log.faces);
}

/// The input is the length of the first section in two bytes, that section, and the second one.
void fuzz_segment(Input input) {
  std::uint16_t length = 0;
  if (input.size() < sizeof length) return;
  std::memcpy(&length, input.data(), sizeof length);
  input = input.subspan(sizeof length);
  const Input first = input.first(std::min<std::size_t>(length, input.size()));
  const Input second = input.subspan(first.size());
  const std::filesystem::path path = scratch_directory() / "log-0.bin";
  try {
    SegmentLog log;
    decode_records(first, "records", log);
    decode_survivors(second, "survivors", log);
    const store::Bytes records = encode_records(log);
    const store::Bytes survivors = encode_survivors(log);
    SegmentLog again;
    decode_records(records, "records again", again);
    decode_survivors(survivors, "survivors again", again);
    expect(encode_records(again) == records && encode_survivors(again) == survivors,
           "a log is encoded and decoded the same");
    {
      store::SectionFileWriter writer(path, kLogKind);
      writer.append(store::pack_section(first));
      writer.append(store::pack_section(second));
      writer.seal();
    }
    const store::SectionFile file(path, kLogKind);
    const map::LevelMap level(file);
    carry(level, map::SegmentMap::Direction::kForward, log);
    carry(level, map::SegmentMap::Direction::kInverse, log);
  } catch (const CorruptionError&) {
  }
}

void fuzz_tile(Input input) {
  Tile surface;
  bool has_surface = false;
  try {
    decode_tile_surface(input, "surface", surface);
    has_surface = true;
  } catch (const CorruptionError&) {
  }
  std::vector<FaceId> ids;
  bool has_ids = false;
  try {
    decode_tile_face_ids(input, "face ids", ids);
    has_ids = true;
  } catch (const CorruptionError&) {
  }
  try {
    Tile tile;
    decode_tile(input, "tile", tile);
    expect(has_surface && has_ids, "what is read as a whole is read in parts");
    expect(tile.triangle == surface.triangle && tile.face_id == ids,
           "parts of a tile are those of the whole");
    for (const auto& t : tile.triangle) {
      expect(std::max({t[0], t[1], t[2]}) < tile.position.size(), "corners of tiles exist");
    }
    const store::Bytes bytes = encode_tile(tile);
    Tile again;
    decode_tile(bytes, "tile again", again);
    expect(encode_tile(again) == bytes, "a tile is encoded and decoded the same");
  } catch (const CorruptionError&) {
  }
}

}  // namespace

void fuzz_sections(Input input) {
  if (input.empty()) return;
  const Input rest = input.subspan(1);
  switch (static_cast<unsigned>(input[0]) % 3) {
    case 0:
      fuzz_section_file(rest);
      break;
    case 1:
      fuzz_segment(rest);
      break;
    default:
      fuzz_tile(rest);
  }
}

}  // namespace remaps::fuzz
