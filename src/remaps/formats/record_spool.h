#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace remaps {

/// Records of one size on disk, read and changed by number through a cache: for formats that want
/// them in another order than they come. Records that were never written are zeros. Numbers that
/// return to the same places soon, as the corners of a semi-regular mesh do, cost about one read
/// and one write a block; others a read each.
class RecordSpool {
 public:
  /// Memory of the cache, about.
  static constexpr std::size_t kCacheBytes = std::size_t{512} << 10;

  /// Makes a file beside `target` that has no name: it goes with the process.
  /// @throws IoError
  RecordSpool(const std::filesystem::path& target, std::size_t record_bytes);
  ~RecordSpool();
  RecordSpool(const RecordSpool&) = delete;
  RecordSpool& operator=(const RecordSpool&) = delete;

  std::size_t record_bytes() const { return record_bytes_; }
  /// A record to read. Valid until the next call.
  /// @throws IoError
  const std::byte* at(std::uint64_t number) { return find(number, false); }
  /// A record to change. Valid until the next call.
  /// @throws IoError
  std::byte* change(std::uint64_t number) { return find(number, true); }

 private:
  static constexpr std::size_t kBlock = 64;  // records
  static constexpr std::size_t kWays = 8;
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  struct Slot {
    std::uint64_t block = kNone;
    bool used = false;  // since the hand came by
    bool dirty = false;
  };

  std::byte* find(std::uint64_t number, bool dirty);
  std::size_t load(std::size_t set, std::uint64_t block);
  void read(std::uint64_t block, std::byte* to) const;
  void write(std::uint64_t block, const std::byte* from) const;
  [[noreturn]] void fail(const char* doing) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::size_t record_bytes_;
  unsigned set_bits_ = 0;
  std::vector<std::byte> cache_;    // (slots, block)
  std::vector<Slot> slots_;         // (sets, ways)
  std::vector<std::uint8_t> hand_;  // (sets): second chance
  std::size_t last_ = 0;            // slot
};

}  // namespace remaps
