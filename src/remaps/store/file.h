#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "remaps/store/packing.h"

namespace remaps::store {

/// An open file with positioned reads and writes. Move-only; every call checks its result. Reads
/// may run on several threads at once. The bytes that went through all files of the process are
/// counted for the report.
class File {
 public:
  File() = default;
  /// @throws IoError  with the path and the system's reason
  static File open_read(const std::filesystem::path& path);
  /// Creates or truncates, for reading and writing.
  static File create(const std::filesystem::path& path);

  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File();

  std::uint64_t size() const;
  /// Reads exactly data.size() bytes.
  /// @throws CorruptionError  the file ends before that
  void read_at(std::uint64_t offset, std::span<std::byte> data) const;
  void write_at(std::uint64_t offset, ByteSpan data);
  /// Gives the space of a part back to the file system, where that can. It reads as zeros then.
  void punch_hole(std::uint64_t offset, std::uint64_t bytes);
  void close();

  const std::filesystem::path& path() const { return path_; }

 private:
  [[noreturn]] void fail(const char* what) const;

  int descriptor_ = -1;
  std::filesystem::path path_;
};

/// Bytes read and written by all File objects so far.
struct IoCounts {
  std::uint64_t read = 0;
  std::uint64_t written = 0;
};
IoCounts io_counts();

/// Writes a whole file under a temporary name and renames it: the final name never shows a part.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);
/// @throws IoError, CorruptionError
std::string read_whole_file(const std::filesystem::path& path);

/// A name beside `path` to write to before the rename: hidden, with the process id.
std::filesystem::path partial_name(const std::filesystem::path& path);

/// A directory of its own, removed with everything in it when the object goes.
class TempDir {
 public:
  /// Creates parent/.remaps-PID-N.
  explicit TempDir(const std::filesystem::path& parent);
  ~TempDir();
  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace remaps::store
