#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace remaps {

/// A file being written through a buffer, under the temporary name `.NAME.partial-<pid>` until
/// `commit`. Destroyed without commit, it leaves nothing.
class ByteSink {
 public:
  static constexpr std::size_t kBuffer = std::size_t{1} << 20;

  /// @throws IoError  the temporary file cannot be created
  explicit ByteSink(std::filesystem::path path);
  ~ByteSink();
  ByteSink(const ByteSink&) = delete;
  ByteSink& operator=(const ByteSink&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// Room for n <= kBuffer bytes, to be filled and then kept by advance.
  /// @throws IoError  the buffer was full and could not be written
  char* room(std::size_t n) {
    if (kBuffer - used_ < n) flush();
    return buffer_.get() + used_;
  }
  void advance(std::size_t n) { used_ += n; }
  /// @throws IoError  as room
  void write(const void* bytes, std::size_t n);

  /// Replaces bytes that were written before, at an offset in the file.
  /// @throws IoError  as room
  void rewrite(std::uint64_t offset, const void* bytes, std::size_t n);

  /// Writes the rest, closes, and renames to the final name, replacing what was there.
  /// @throws IoError  a step failed; the temporary is removed
  void commit();

 private:
  void flush();
  void discard() noexcept;
  /// Removes the temporary and throws: after a failure nothing more can be written.
  [[noreturn]] void fail(const char* doing);

  std::filesystem::path path_, partial_path_;  // the latter empty once there is no temporary
  int file_ = -1;
  std::size_t used_ = 0;
  std::unique_ptr<char[]> buffer_;
};

}  // namespace remaps
