#include "remaps/store/bucket_file.h"

#include <xxhash.h>

#include <algorithm>

namespace remaps::store {
namespace {

std::size_t block_size(std::size_t buckets, std::uint64_t buffer_bytes) {
  const std::uint64_t share = buffer_bytes / std::max<std::size_t>(buckets, 1);
  return static_cast<std::size_t>(std::clamp<std::uint64_t>(share, 512, 256 << 10));
}

}  // namespace

BucketFile::BucketFile(const std::filesystem::path& path, std::size_t buckets,
                       std::uint64_t buffer_bytes, MemoryBudget& budget)
    : block_bytes_(block_size(buckets, buffer_bytes)),
      reservation_(
          budget.reserve(block_bytes_ * buckets, "buffers for " + path.filename().string())),
      path_(path),
      file_(File::create(path)),
      buckets_(buckets) {}

BucketFile::~BucketFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

std::uint64_t BucketFile::total_bytes() const {
  std::uint64_t sum = 0;
  for (const Bucket& bucket : buckets_) sum += bucket.bytes;
  return sum;
}

void BucketFile::append(std::size_t index, ByteSpan data) {
  Bucket& bucket = buckets_[index];
  bucket.bytes += data.size();
  while (!data.empty()) {
    if (bucket.filling.capacity() < block_bytes_) bucket.filling.reserve(block_bytes_);
    const std::size_t part = std::min(data.size(), block_bytes_ - bucket.filling.size());
    bucket.filling.insert(bucket.filling.end(), data.begin(), data.begin() + std::ptrdiff_t(part));
    data = data.subspan(part);
    if (bucket.filling.size() == block_bytes_) flush(bucket);
  }
}

void BucketFile::flush(Bucket& bucket) {
  std::uint64_t offset = 0;
  {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) {
      offset = end_;
      end_ += block_bytes_;
    } else {
      offset = free_.back();
      free_.pop_back();
    }
  }
  file_.write_at(offset, bucket.filling);
  bucket.blocks.push_back({offset, XXH3_64bits(bucket.filling.data(), bucket.filling.size())});
  bucket.filling.clear();
}

void BucketFile::read(std::size_t index, std::uint64_t offset, std::uint64_t bytes,
                      Bytes& out) const {
  const Bucket& bucket = buckets_[index];
  out.resize(static_cast<std::size_t>(bytes));
  thread_local Bytes whole;
  std::size_t done = 0;
  while (done < out.size()) {
    const std::uint64_t at = offset + done;
    const auto number = static_cast<std::size_t>(at / block_bytes_);
    const auto within = static_cast<std::size_t>(at % block_bytes_);
    ByteSpan source = bucket.filling;
    if (number < bucket.blocks.size()) {
      const Block& block = bucket.blocks[number];
      whole.resize(block_bytes_);
      file_.read_at(block.offset, whole);
      if (XXH3_64bits(whole.data(), whole.size()) != block.checksum) {
        throw CorruptionError(path_.string() + ": block at byte " + std::to_string(block.offset) +
                              " fails its checksum; the disk or another program changed it");
      }
      source = whole;
    }
    source = source.subspan(within, std::min(source.size() - within, out.size() - done));
    std::copy(source.begin(), source.end(), out.begin() + std::ptrdiff_t(done));
    done += source.size();
  }
}

void BucketFile::release(std::size_t index) {
  Bucket& bucket = buckets_[index];
  const std::scoped_lock lock(mutex_);
  for (const Block& block : bucket.blocks) free_.push_back(block.offset);
  bucket = {};
}

}  // namespace remaps::store
