#include "remaps/pipeline/map_file.h"

#include <xxhash.h>

#include <algorithm>
#include <vector>

namespace remaps::pipeline {
namespace {

constexpr std::uint64_t kRecordBytes = 4 + sizeof(MapRecord);

}  // namespace

MapFileWriter::MapFileWriter(const std::filesystem::path& temp_dir, std::uint64_t vertices,
                             std::uint64_t buffer_bytes, MemoryBudget& budget)
    : vertices_(vertices),
      block_(std::clamp<std::uint64_t>(buffer_bytes / (2 * (kRecordBytes + sizeof(MapRecord))),
                                       1 << 12, 1 << 22)),
      file_(temp_dir / "map-records", static_cast<std::size_t>((vertices + block_ - 1) / block_),
            buffer_bytes / 2, budget),
      reservation_(budget.reserve(std::min(block_, vertices) * (kRecordBytes + sizeof(MapRecord)),
                                  "a block of map.bin")) {}

void MapFileWriter::add(VertexId vertex, const map::FacePoint& on_base) {
  if (vertex >= vertices_) {
    ++copies_;
    return;
  }
  file_.append_record(static_cast<std::size_t>(vertex / block_), [&](store::Packer& packer) {
    packer.put(static_cast<std::uint32_t>(vertex % block_));
    packer.put(
        MapRecord{on_base.face, static_cast<float>(on_base.u), static_cast<float>(on_base.v)});
  });
}

std::uint64_t MapFileWriter::write(const std::filesystem::path& path, std::uint64_t expected) {
  const std::filesystem::path partial = store::partial_name(path);
  store::File out = store::File::create(partial);
  XXH3_state_t* hash = XXH3_createState();
  XXH3_64bits_reset(hash);
  std::vector<MapRecord> records;
  store::Bytes bytes;
  std::uint64_t placed = 0;
  std::uint64_t at = 0;
  for (std::size_t b = 0; b < file_.buckets(); ++b) {
    file_.take(b, bytes);
    records.assign(static_cast<std::size_t>(std::min(block_, vertices_ - b * block_)), MapRecord{});
    store::Unpacker unpacker(bytes, "map records");
    while (!unpacker.done()) {
      MapRecord& record = records.at(unpacker.get<std::uint32_t>());
      placed += record.face == 0xFFFFFFFFu;
      record = unpacker.get<MapRecord>();
    }
    const auto block = std::as_bytes(std::span(records));
    XXH3_64bits_update(hash, block.data(), block.size());
    out.write_at(at, block);
    at += block.size();
  }
  const std::uint64_t checksum = XXH3_64bits_digest(hash);
  XXH3_freeState(hash);
  out.close();
  if (placed + copies_ != expected) {
    std::filesystem::remove(partial);
    throw CorruptionError("the map holds " + std::to_string(placed + copies_) +
                          " vertices instead of " + std::to_string(expected));
  }
  std::filesystem::rename(partial, path);
  return checksum;
}

}  // namespace remaps::pipeline
