#include "remaps/mesh/segment_log.h"

#include <span>

namespace remaps {
namespace {

using store::Bytes;
using store::Packer;
using store::Unpacker;

void put_deltas(Packer& packer, std::span<const std::uint64_t> values) {
  std::uint64_t before = 0;
  for (const std::uint64_t value : values) {
    packer.put_signed(static_cast<std::int64_t>(value - before));
    before = value;
  }
}

void get_deltas(Unpacker& unpacker, std::uint64_t count, std::vector<std::uint64_t>& values) {
  if (count > unpacker.left())
    throw CorruptionError("a list announces more elements than it has bytes");
  values.resize(static_cast<std::size_t>(count));
  std::uint64_t before = 0;
  for (std::uint64_t& value : values) {
    value = before + static_cast<std::uint64_t>(unpacker.get_signed());
    before = value;
  }
}

[[noreturn]] void refuse(const std::string& what, const std::string& why) {
  throw CorruptionError(what + ": " + why);
}

/// The part of a tile before its ids.
void get_surface(Unpacker& unpacker, const std::string& what, Tile& tile) {
  tile.clear();
  tile.own_vertices = unpacker.get<LocalIndex>();
  const auto vertices = unpacker.get<std::uint32_t>();
  const auto faces = unpacker.get<std::uint32_t>();
  if (tile.own_vertices > vertices) refuse(what, "more own vertices than vertices");
  unpacker.get_vector(vertices, tile.position);
  if (faces > unpacker.left() / 3) refuse(what, "more faces announced than there are bytes for");
  tile.triangle.resize(faces);
  std::uint64_t before = 0;  // differences may be anything: wraps
  for (auto& t : tile.triangle) {
    for (LocalIndex& v : t) {
      before += static_cast<std::uint64_t>(unpacker.get_signed());
      if (before >= vertices) refuse(what, "a face names a vertex that does not exist");
      v = static_cast<LocalIndex>(before);
    }
  }
}

}  // namespace

void SegmentLog::clear() {
  faces = 0;
  origin.clear();
  records.clear();
  removed.clear();
  survivor.clear();
  next.clear();
}

Bytes encode_records(const SegmentLog& log) {
  Bytes bytes;
  bytes.reserve(log.records.words().size_bytes() + log.origin.size() * sizeof(FaceLink) +
                log.removed.size() * 3 + 64);
  Packer packer(bytes);
  packer.put(log.level);
  packer.put(log.faces);
  packer.put(static_cast<std::uint32_t>(log.origin.size()));
  packer.put(static_cast<std::uint32_t>(log.records.size()));
  packer.put(static_cast<std::uint32_t>(log.records.words().size()));
  packer.put_array(std::span<const FaceLink>(log.origin));
  packer.put_array(log.records.words());
  put_deltas(packer, log.removed);
  return bytes;
}

void decode_records(store::ByteSpan bytes, const std::string& what, SegmentLog& log) {
  Unpacker unpacker(bytes, what);
  log.clear();
  log.level = unpacker.get<std::uint32_t>();
  log.faces = unpacker.get<LocalIndex>();
  const auto origins = unpacker.get<std::uint32_t>();
  const auto records = unpacker.get<std::uint32_t>();
  const auto words = unpacker.get<std::uint32_t>();
  if (origins != (log.level == 0 ? 0 : log.faces)) refuse(what, "wrong number of face origins");
  unpacker.get_vector(origins, log.origin);
  std::vector<std::uint32_t> packed;
  unpacker.get_vector(words, packed);
  if (!log.records.assign(std::move(packed)) || log.records.size() != records) {
    refuse(what, "the records are malformed");
  }
  for (std::size_t r = 0; r < log.records.size(); ++r) {
    for (unsigned i = 0; i < log.records.wedges(r); ++i) {
      if (log.records.face(r, i) >= log.faces || log.records.turn(r, i) > 2) {
        refuse(what, "record " + std::to_string(r) + " names a face or corner that does not exist");
      }
    }
  }
  get_deltas(unpacker, records, log.removed);
  if (!unpacker.done()) refuse(what, "bytes are left over");
}

Bytes encode_survivors(const SegmentLog& log) {
  Bytes bytes;
  Packer packer(bytes);
  packer.put(static_cast<std::uint32_t>(log.survivor.size()));
  packer.put_array(std::span<const LocalIndex>(log.survivor));
  packer.put_array(std::span<const FaceLink>(log.next));
  return bytes;
}

void decode_survivors(store::ByteSpan bytes, const std::string& what, SegmentLog& log) {
  Unpacker unpacker(bytes, what);
  const auto count = unpacker.get<std::uint32_t>();
  unpacker.get_vector(count, log.survivor);
  unpacker.get_vector(count, log.next);
  if (!unpacker.done()) refuse(what, "bytes are left over");
  for (std::size_t i = 0; i < count; ++i) {
    if (log.survivor[i] >= log.faces || (i > 0 && log.survivor[i] <= log.survivor[i - 1])) {
      refuse(what, "the surviving faces are not ascending ids of this segment");
    }
  }
}

void Tile::clear() {
  own_vertices = 0;
  vertex_id.clear();
  position.clear();
  triangle.clear();
  face_id.clear();
}

Bytes encode_tile(const Tile& tile) {
  Bytes bytes;
  bytes.reserve(tile.position.size() * 16 + tile.triangle.size() * 14 + 64);
  Packer packer(bytes);
  packer.put(tile.own_vertices);
  packer.put(static_cast<std::uint32_t>(tile.position.size()));
  packer.put(static_cast<std::uint32_t>(tile.triangle.size()));
  packer.put_array(std::span<const Vec3f>(tile.position));
  std::int64_t before = 0;
  for (const auto& t : tile.triangle) {
    for (const LocalIndex v : t) {
      packer.put_signed(std::int64_t{v} - before);
      before = v;
    }
  }
  put_deltas(packer, tile.vertex_id);
  put_deltas(packer, tile.face_id);
  return bytes;
}

void decode_tile(store::ByteSpan bytes, const std::string& what, Tile& tile) {
  Unpacker unpacker(bytes, what);
  get_surface(unpacker, what, tile);
  get_deltas(unpacker, tile.position.size(), tile.vertex_id);
  get_deltas(unpacker, tile.triangle.size(), tile.face_id);
  if (!unpacker.done()) refuse(what, "bytes are left over");
}

void decode_tile_surface(store::ByteSpan bytes, const std::string& what, Tile& tile) {
  Unpacker unpacker(bytes, what);
  get_surface(unpacker, what, tile);
}

void decode_tile_face_ids(store::ByteSpan bytes, const std::string& what,
                          std::vector<FaceId>& face_id) {
  Unpacker unpacker(bytes, what);
  unpacker.get<LocalIndex>();
  unpacker.get<std::uint32_t>();
  const auto faces = unpacker.get<std::uint32_t>();
  // They are the last so many varints, and only the last byte of a varint is below 128.
  const std::size_t left = unpacker.left();
  const store::ByteSpan lists = bytes.last(left);
  std::size_t start = left;
  std::uint64_t ends = 0;
  while (start > 0 && (ends += (lists[start - 1] < std::byte{128})) <= faces) --start;
  Unpacker ids(lists.subspan(start), what);
  get_deltas(ids, faces, face_id);
  if (!ids.done()) refuse(what, "bytes are left over");
}

}  // namespace remaps
