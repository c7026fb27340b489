#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/store/disk_usage.h"
#include "remaps/store/file.h"
#include "remaps/store/packing.h"

namespace remaps::store {

/// Many growing byte sequences ("buckets") in one temporary file: how data is sorted by place
/// without memory that grows with it. Each bucket fills a block in memory; full blocks go to the
/// file behind their checksum. Space of consumed buckets goes back to the file system and is used
/// again. What never fills a block never touches the disk.
///
/// A bucket's blocks lie in extents, each twice as large as the one before up to a limit; the index
/// in memory is one offset an extent. The file is sparse: what is not written takes no disk.
///
/// Appending is for one thread. Reading and releasing may run on several, of buckets that nobody
/// appends to any more.
class BucketFile {
 public:
  /// Memory a bucket besides its block: itself and the first extents of its index.
  static constexpr std::uint64_t kBucketOverhead = 128;

  /// @param buffer_bytes  memory for all blocks being filled, reserved from the budget; the block
  /// size follows from it
  ///                      (512 B to 256 KiB)
  BucketFile(const std::filesystem::path& path, std::size_t buckets, std::uint64_t buffer_bytes,
             MemoryBudget& budget);
  /// Removes the file.
  ~BucketFile();
  BucketFile(const BucketFile&) = delete;
  BucketFile& operator=(const BucketFile&) = delete;

  std::size_t buckets() const { return buckets_.size(); }
  void append(std::size_t index, ByteSpan data) {
    Bucket& bucket = buckets_[index];
    if (data.size() < bucket.room) {
      std::memcpy(bucket.end, data.data(), data.size());
      bucket.end += data.size();
      bucket.room -= static_cast<std::uint32_t>(data.size());
    } else {
      append_across(bucket, data);
    }
  }
  std::uint64_t bytes(std::size_t index) const {
    const Bucket& bucket = buckets_[index];
    return bucket.blocks * payload_ + waiting(bucket);
  }
  std::uint64_t total_bytes() const;

  /// Reads part of a bucket, in the order of appending; `out` is resized.
  /// @throws CorruptionError  a block fails its checksum
  void read(std::size_t bucket, std::uint64_t offset, std::uint64_t bytes, Bytes& out) const;
  /// Frees the space of a bucket, which is empty afterwards.
  void release(std::size_t bucket);
  /// Reads a whole bucket and frees it.
  void take(std::size_t bucket, Bytes& out) {
    read(bucket, 0, bytes(bucket), out);
    release(bucket);
  }

  /// Appends a packed record: pack(Packer&) writes it.
  template <class Pack>
  void append_record(std::size_t bucket, Pack&& pack) {
    record_.clear();
    Packer packer(record_);
    pack(packer);
    append(bucket, record_);
  }

 private:
  struct Bucket {
    std::unique_ptr<std::byte[]> block;  // checksum, then what is being filled
    std::byte* end = nullptr;            // of what is filled
    std::uint32_t room = 0;              // behind it
    std::uint64_t blocks = 0;            // on disk
    std::vector<std::uint64_t> extents;  // offsets
  };
  struct Place {
    std::size_t extent;
    std::uint64_t block;  // within the extent
  };

  std::uint64_t waiting(const Bucket& bucket) const {
    return bucket.block == nullptr ? 0 : payload_ - bucket.room;
  }
  std::uint64_t extent_blocks(std::size_t extent) const;
  Place place_of(std::uint64_t block) const;
  std::uint64_t blocks_in(const Bucket& bucket, std::size_t extent) const;
  void append_across(Bucket& bucket, ByteSpan data);
  void flush(Bucket& bucket);
  std::uint64_t new_extent(std::size_t extent);
  void read_blocks(const Bucket& bucket, std::uint64_t first, std::uint64_t most, Bytes& out) const;

  std::uint64_t block_bytes_;  // on disk
  std::uint64_t payload_;      // of them, without the checksum
  std::uint64_t first_extent_;
  Reservation reservation_;
  std::filesystem::path path_;
  File file_;
  std::vector<Bucket> buckets_;
  Bytes record_;
  std::mutex mutex_;  // guards what follows
  std::uint64_t end_ = 0;
  std::vector<std::vector<std::uint64_t>> free_;  // by size
  DiskShare disk_;
};

}  // namespace remaps::store
