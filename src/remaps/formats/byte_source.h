#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace remaps {

/// What an error says of a file may quote it: control characters become '?', and what is longer
/// than 400 bytes is cut.
std::string printable(std::string_view what);

/// A file read forward through one buffer. The bytes ahead are at data(), followed by a newline
/// that is not in the file, so that scanning for the end of a word or a line needs no bound.
class ByteSource {
 public:
  static constexpr std::size_t kDefaultBuffer = std::size_t{1} << 20;

  /// @throws InputError  missing, unreadable or not a regular file
  explicit ByteSource(std::filesystem::path path, std::size_t buffer_bytes = kDefaultBuffer);
  ~ByteSource();
  ByteSource(ByteSource&& other) noexcept;
  ByteSource& operator=(ByteSource&&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// Offset in the file of data().
  std::uint64_t offset() const { return end_offset_ - available(); }
  /// Bytes that came from the file so far, those read again included.
  std::uint64_t bytes_read_total() const { return bytes_read_total_; }
  /// Bytes from data() to the end of the file.
  std::uint64_t remaining() const { return size_ - offset(); }

  const char* data() const { return next_; }
  std::size_t available() const { return static_cast<std::size_t>(end_ - next_); }
  /// True when no byte follows those at data().
  bool exhausted() const { return end_offset_ == size_; }

  /// Makes n bytes available, or all that are left when the file has fewer. n <= the buffer's size.
  /// Invalidates data(). Returns available().
  std::size_t require(std::size_t n) {
    if (available() < n && !exhausted()) refill();
    return available();
  }
  /// Passes over n available bytes.
  void consume(std::size_t n) { next_ += n; }
  /// Passes over n remaining bytes; those not yet read are never read.
  void skip(std::uint64_t n);
  /// Goes to an offset of at most size(). What the buffer holds is not read again.
  void seek(std::uint64_t offset);

  /// Throws InputError: path, byte offset, what.
  [[noreturn]] void fail_at_byte(std::uint64_t offset, std::string_view what) const;
  /// Throws InputError: path, number of the line that holds the offset, what. Counts the lines only
  /// now, by reading the file again up to there.
  [[noreturn]] void fail_at_line(std::uint64_t offset, std::string_view what) const;

 private:
  void refill();

  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t end_offset_ = 0;  // in the file, of end_
  std::uint64_t bytes_read_total_ = 0;
  std::size_t capacity_;
  std::unique_ptr<char[]> buffer_;  // capacity_ + 1 bytes
  const char* next_ = nullptr;
  char* end_ = nullptr;
};

}  // namespace remaps
