#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <vector>

#include "remaps/base/memory_budget.h"
#include "remaps/store/file.h"
#include "remaps/store/packing.h"

namespace remaps::store {

/// Many growing byte sequences ("buckets") in one temporary file: how data is sorted by place
/// without memory that grows with it. Each bucket fills a block in memory; full blocks go to the
/// file, checksummed. Blocks of consumed buckets are used again, so the file grows to the largest
/// amount alive at a time. What never fills a block never touches the disk.
///
/// Appending is for one thread. Reading and releasing may run on several, of buckets that nobody
/// appends to any more.
class BucketFile {
 public:
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
  void append(std::size_t bucket, ByteSpan data);
  std::uint64_t bytes(std::size_t bucket) const { return buckets_[bucket].bytes; }
  std::uint64_t total_bytes() const;

  /// Reads part of a bucket, in the order of appending; `out` is resized.
  /// @throws CorruptionError  a block fails its checksum
  void read(std::size_t bucket, std::uint64_t offset, std::uint64_t bytes, Bytes& out) const;
  /// Frees the space of a bucket, which is empty afterwards.
  void release(std::size_t bucket);
  /// Reads a whole bucket and frees it.
  void take(std::size_t bucket, Bytes& out) {
    read(bucket, 0, buckets_[bucket].bytes, out);
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
  struct Block {
    std::uint64_t offset;
    std::uint64_t checksum;
  };
  struct Bucket {
    std::uint64_t bytes = 0;
    std::vector<Block> blocks;
    Bytes filling;
  };

  void flush(Bucket& bucket);

  std::size_t block_bytes_;
  Reservation reservation_;
  std::filesystem::path path_;
  File file_;
  std::vector<Bucket> buckets_;
  Bytes record_;
  std::mutex mutex_;  // guards what follows
  std::uint64_t end_ = 0;
  std::vector<std::uint64_t> free_;
};

}  // namespace remaps::store
