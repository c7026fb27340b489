#pragma once

#include <cstdint>
#include <utility>

namespace remaps::store {

/// Bytes that this process has on disk in files that it counts: temporary files and sections.
struct DiskUsage {
  std::uint64_t now = 0;
  std::uint64_t peak = 0;
};
DiskUsage disk_usage();
/// Lets the peak start again from what is there now: at the start of a run.
void restart_disk_peak();

/// What one file has on disk, counted while the object lives. Move-only; thread-safe only as its
/// owner makes it.
class DiskShare {
 public:
  DiskShare() = default;
  DiskShare(DiskShare&& other) noexcept : bytes_(std::exchange(other.bytes_, 0)) {}
  DiskShare& operator=(DiskShare&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~DiskShare() { shrink(bytes_); }

  void grow(std::uint64_t bytes);
  void shrink(std::uint64_t bytes);
  std::uint64_t bytes() const { return bytes_; }

 private:
  std::uint64_t bytes_ = 0;
};

}  // namespace remaps::store
