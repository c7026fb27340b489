#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "remaps/base/memory_budget.h"
#include "remaps/formats/decompressor.h"
#include "remaps/formats/input_file.h"

namespace remaps {

/// What an error says of a file may quote it: control characters become '?', and what is longer
/// than 400 bytes is cut.
std::string printable(std::string_view what);

/// A file read forward through one buffer. The bytes ahead are at data(), followed by a newline
/// that is not in the file, so that scanning for the end of a word or a line needs no bound.
///
/// Of a file compressed with gzip or Zstandard it reads the content: all offsets and sizes are
/// those of the content, but for the members named file_*. How much content there is, is known only
/// when its end was seen; until then size() is a bound that no file of this length can exceed.
class ByteSource {
 public:
  static constexpr std::size_t kDefaultBuffer = std::size_t{1} << 20;

  /// @param budget  optional: for the window of compressed data
  /// @throws InputError   missing, unreadable or not a regular file
  /// @throws BudgetError  the window does not fit the budget
  explicit ByteSource(std::filesystem::path path, std::size_t buffer_bytes = kDefaultBuffer,
                      MemoryBudget* budget = nullptr);
  ByteSource(ByteSource&& other) noexcept = default;
  ByteSource& operator=(ByteSource&&) = delete;

  const std::filesystem::path& path() const { return file_->path(); }
  bool is_compressed() const { return decompressor_ != nullptr; }
  std::uint64_t size() const { return size_; }
  /// False while size() is only a bound.
  bool size_is_known() const { return size_is_known_; }
  /// Offset of data().
  std::uint64_t offset() const { return end_offset_ - available(); }
  /// Bytes from data() to the end, a bound while the size is not known.
  std::uint64_t remaining() const { return size_ - offset(); }
  /// "the file has only N bytes left", N being what remains or less: for errors about counts that
  /// cannot be true.
  std::string room_text(std::uint64_t n) const;
  std::string room_text() const { return room_text(remaining()); }

  /// Bytes on disk.
  std::uint64_t file_size() const { return file_->size(); }
  /// How far in the file the bytes at data() are: of compressed data, what was used up.
  std::uint64_t file_offset() const {
    return is_compressed() ? decompressor_->file_offset() : offset();
  }
  /// About where in the file the byte at an offset is.
  std::uint64_t file_offset_of(std::uint64_t offset) const;
  /// The size, as well as it can be told by now.
  std::uint64_t expected_size() const;
  /// Bytes that came from the file so far, those read again included.
  std::uint64_t bytes_read_total() const {
    return is_compressed() ? decompressor_->bytes_read_total() : bytes_read_total_;
  }

  const char* data() const { return next_; }
  std::size_t available() const { return static_cast<std::size_t>(end_ - next_); }
  /// True when no byte follows those at data(). Of compressed data it may become true only when
  /// more is asked for than there is.
  bool exhausted() const { return end_offset_ == size_; }

  /// Makes n bytes available, or all that are left when the file has fewer. n <= the buffer's size.
  /// Invalidates data(). Returns available().
  std::size_t require(std::size_t n) {
    if (available() < n && !exhausted()) refill();
    return available();
  }
  /// Passes over n available bytes.
  void consume(std::size_t n) { next_ += n; }
  /// Passes over n bytes, or all that remain; those not yet read are never read, unless compressed.
  void skip(std::uint64_t n);
  /// Goes to an offset, or to the end. What the buffer holds is not read again. Compressed data is
  /// read again from its start to go back farther than the buffer reaches.
  void seek(std::uint64_t offset);

  /// Throws InputError: path, byte offset, what.
  [[noreturn]] void fail_at_byte(std::uint64_t offset, std::string_view what) const;
  /// Throws InputError: path, number of the line that holds the offset, what. Counts the lines only
  /// now, by reading the file again up to there.
  [[noreturn]] void fail_at_line(std::uint64_t offset, std::string_view what);

 private:
  void refill();
  void drop_buffer(std::uint64_t offset);
  std::string_view kind_of_place() const {
    return is_compressed() ? " of the decompressed content" : "";
  }

  std::unique_ptr<InputFile> file_;
  std::unique_ptr<Decompressor> decompressor_;
  std::uint64_t size_ = 0;
  bool size_is_known_ = true;
  std::uint64_t end_offset_ = 0;  // of end_
  std::uint64_t bytes_read_total_ = 0;
  std::size_t capacity_;
  std::unique_ptr<char[]> buffer_;  // capacity_ + 1 bytes
  const char* next_ = nullptr;
  char* end_ = nullptr;
};

}  // namespace remaps
