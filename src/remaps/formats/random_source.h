#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace remaps {

/// A file read at any place, without a buffer of its own.
class RandomSource {
 public:
  /// @throws InputError  missing, unreadable or not a regular file
  explicit RandomSource(std::filesystem::path path);
  ~RandomSource();
  RandomSource(const RandomSource&) = delete;
  RandomSource& operator=(const RandomSource&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// Reads exactly so many bytes.
  /// @throws InputError  the file ends before that
  /// @throws IoError     reading failed
  void read_at(std::uint64_t offset, std::span<char> bytes) const;
  /// Bytes that came from the file so far.
  std::uint64_t bytes_read_total() const { return bytes_read_total_; }

  /// Throws InputError: path, byte offset, what.
  [[noreturn]] void fail_at_byte(std::uint64_t offset, std::string_view what) const;

 private:
  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  mutable std::uint64_t bytes_read_total_ = 0;
};

}  // namespace remaps
