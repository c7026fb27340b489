#include "remaps/store/disk_usage.h"

#include <atomic>

namespace remaps::store {
namespace {

std::atomic<std::uint64_t> bytes_now{0};
std::atomic<std::uint64_t> bytes_peak{0};

}  // namespace

DiskUsage disk_usage() {
  return {bytes_now.load(), bytes_peak.load()};
}

void restart_disk_peak() {
  bytes_peak.store(bytes_now.load());
}

void DiskShare::grow(std::uint64_t bytes) {
  bytes_ += bytes;
  const std::uint64_t now = bytes_now.fetch_add(bytes) + bytes;
  std::uint64_t peak = bytes_peak.load();
  while (peak < now && !bytes_peak.compare_exchange_weak(peak, now)) {
  }
}

void DiskShare::shrink(std::uint64_t bytes) {
  bytes_ -= bytes;
  bytes_now.fetch_sub(bytes);
}

}  // namespace remaps::store
