#include "remaps/store/bucket_file.h"

#include <xxhash.h>

#include <algorithm>

namespace remaps::store {
namespace {

constexpr std::uint64_t kChecksum = sizeof(std::uint64_t);
constexpr std::uint64_t kFirstExtent = 64 << 10;
/// Extents double so many times.
constexpr std::size_t kDoublings = 8;
/// Blocks are read together up to so many bytes.
constexpr std::uint64_t kReadBytes = 256 << 10;

/// The file system takes back whole pages only.
std::uint64_t whole_pages(std::uint64_t bytes) {
  constexpr std::uint64_t kPage = 4096;
  return (bytes + kPage - 1) / kPage * kPage;
}

std::uint64_t block_size(std::size_t buckets, std::uint64_t buffer_bytes) {
  const std::uint64_t share = buffer_bytes / std::max<std::size_t>(buckets, 1);
  return std::clamp<std::uint64_t>(share / 512 * 512, 512, 256 << 10);
}

}  // namespace

BucketFile::BucketFile(const std::filesystem::path& path, std::size_t buckets,
                       std::uint64_t buffer_bytes, MemoryBudget& budget)
    : block_bytes_(block_size(buckets, buffer_bytes)),
      payload_(block_bytes_ - kChecksum),
      first_extent_(std::max<std::uint64_t>(kFirstExtent / block_bytes_, 1)),
      reservation_(budget.reserve((block_bytes_ + kBucketOverhead) * buckets,
                                  "buffers for " + path.filename().string())),
      path_(path),
      file_(File::create(path)),
      buckets_(buckets),
      free_(kDoublings + 1) {}

BucketFile::~BucketFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

std::uint64_t BucketFile::total_bytes() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < buckets_.size(); ++i) sum += bytes(i);
  return sum;
}

std::uint64_t BucketFile::extent_blocks(std::size_t extent) const {
  return first_extent_ << std::min(extent, kDoublings);
}

BucketFile::Place BucketFile::place_of(std::uint64_t block) const {
  std::size_t extent = 0;
  while (block >= extent_blocks(extent)) {
    if (extent >= kDoublings) {
      extent += static_cast<std::size_t>(block / extent_blocks(extent));
      return {extent, block % extent_blocks(extent)};
    }
    block -= extent_blocks(extent++);
  }
  return {extent, block};
}

/// Blocks written in an extent.
std::uint64_t BucketFile::blocks_in(const Bucket& bucket, std::size_t extent) const {
  const Place end = place_of(bucket.blocks);
  return extent < end.extent ? extent_blocks(extent) : end.block;
}

void BucketFile::append_across(Bucket& bucket, ByteSpan data) {
  while (!data.empty()) {
    if (bucket.block == nullptr) {
      bucket.block = std::make_unique_for_overwrite<std::byte[]>(block_bytes_);
      bucket.end = bucket.block.get() + kChecksum;
      bucket.room = static_cast<std::uint32_t>(payload_);
    }
    const std::size_t part = std::min<std::size_t>(data.size(), bucket.room);
    std::memcpy(bucket.end, data.data(), part);
    bucket.end += part;
    bucket.room -= static_cast<std::uint32_t>(part);
    data = data.subspan(part);
    if (bucket.room == 0) flush(bucket);
  }
}

std::uint64_t BucketFile::new_extent(std::size_t extent) {
  const std::size_t size = std::min(extent, kDoublings);
  const std::scoped_lock lock(mutex_);
  if (free_[size].empty()) {
    const std::uint64_t offset = end_;
    end_ += whole_pages(extent_blocks(size) * block_bytes_);
    return offset;
  }
  const std::uint64_t offset = free_[size].back();
  free_[size].pop_back();
  return offset;
}

void BucketFile::flush(Bucket& bucket) {
  const Place place = place_of(bucket.blocks);
  if (place.extent == bucket.extents.size()) bucket.extents.push_back(new_extent(place.extent));
  std::byte* block = bucket.block.get();
  const std::uint64_t checksum = XXH3_64bits(block + kChecksum, payload_);
  std::memcpy(block, &checksum, kChecksum);
  file_.write_at(bucket.extents[place.extent] + place.block * block_bytes_, {block, block_bytes_});
  ++bucket.blocks;
  bucket.end = block + kChecksum;
  bucket.room = static_cast<std::uint32_t>(payload_);
  const std::scoped_lock lock(mutex_);
  disk_.grow(block_bytes_);
}

/// Reads block `first` and up to `most` - 1 that lie behind it on disk.
void BucketFile::read_blocks(const Bucket& bucket, std::uint64_t first, std::uint64_t most,
                             Bytes& out) const {
  const Place place = place_of(first);
  const std::uint64_t together = std::max<std::uint64_t>(kReadBytes / block_bytes_, 1);
  const std::uint64_t count =
      std::min({most, together, blocks_in(bucket, place.extent) - place.block});
  const std::uint64_t offset = bucket.extents[place.extent] + place.block * block_bytes_;
  out.resize(static_cast<std::size_t>(count * block_bytes_));
  file_.read_at(offset, out);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::byte* block = out.data() + i * block_bytes_;
    std::uint64_t checksum = 0;
    std::memcpy(&checksum, block, kChecksum);
    if (XXH3_64bits(block + kChecksum, payload_) != checksum) {
      throw CorruptionError(path_.string() + ": block at byte " +
                            std::to_string(offset + i * block_bytes_) +
                            " fails its checksum; the disk or another program changed it");
    }
  }
}

void BucketFile::read(std::size_t index, std::uint64_t offset, std::uint64_t bytes,
                      Bytes& out) const {
  const Bucket& bucket = buckets_[index];
  out.resize(static_cast<std::size_t>(bytes));
  thread_local Bytes blocks;
  std::size_t done = 0;
  const auto copy = [&](const std::byte* payload, std::uint64_t from, std::uint64_t size) {
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(size - from, bytes - done));
    std::memcpy(out.data() + done, payload + from, part);
    done += part;
  };
  while (done < out.size()) {
    const std::uint64_t number = (offset + done) / payload_;
    std::uint64_t within = (offset + done) % payload_;
    if (number >= bucket.blocks) {
      copy(bucket.block.get() + kChecksum, within, waiting(bucket));
      continue;
    }
    const std::uint64_t last = (offset + bytes - 1) / payload_;
    read_blocks(bucket, number, std::min(last, bucket.blocks - 1) - number + 1, blocks);
    for (std::size_t at = 0; at < blocks.size(); at += block_bytes_, within = 0)
      copy(blocks.data() + at + kChecksum, within, payload_);
  }
}

void BucketFile::release(std::size_t index) {
  Bucket& bucket = buckets_[index];
  for (std::size_t e = 0; e < bucket.extents.size(); ++e)
    file_.punch_hole(bucket.extents[e], whole_pages(blocks_in(bucket, e) * block_bytes_));
  const std::scoped_lock lock(mutex_);
  for (std::size_t e = 0; e < bucket.extents.size(); ++e)
    free_[std::min(e, kDoublings)].push_back(bucket.extents[e]);
  disk_.shrink(bucket.blocks * block_bytes_);
  bucket = {};
}

}  // namespace remaps::store
