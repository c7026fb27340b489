#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"

namespace remaps {

/// Positions put aside on disk, as floats, to be looked up by number afterwards: for formats that
/// want them with each face. A cache of 768 KiB holds blocks of 64. Faces in the order of a
/// semi-regular mesh, or any other that returns to the same places soon, read each block about
/// once; for faces in random order each corner is a read.
class PositionSpool {
 public:
  /// Makes a file beside `target` that has no name: it goes with the process.
  /// @throws IoError
  explicit PositionSpool(const std::filesystem::path& target);
  ~PositionSpool();
  PositionSpool(const PositionSpool&) = delete;
  PositionSpool& operator=(const PositionSpool&) = delete;

  /// All appending comes before the first look-up.
  /// @throws IoError
  void append(std::span<const Vec3> positions);
  /// @param v  below the number of positions appended
  /// @throws IoError
  Vec3f at(VertexId v);

  /// Blocks read so far.
  std::uint64_t blocks_read() const { return blocks_read_; }

  static constexpr std::size_t kBlock = 64;

 private:
  static constexpr std::size_t kSetBits = 7, kWays = 8;
  static constexpr std::size_t kSlots = kWays << kSetBits;
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  struct Slot {
    std::uint64_t block = kNone;
    bool used = false;  // since the hand came by
  };

  const Vec3f* load(std::size_t set, std::uint64_t block);
  void flush();
  [[noreturn]] void fail(const char* doing) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t count_ = 0;     // appended
  std::vector<Vec3f> waiting_;  // the last of them, not yet in the file
  std::vector<Vec3f> cache_;    // (slots, block), once it is needed
  std::vector<Slot> slots_;
  std::array<std::uint8_t, std::size_t{1} << kSetBits> hand_{};  // second chance, in each set
  std::uint64_t blocks_read_ = 0;
};

}  // namespace remaps
