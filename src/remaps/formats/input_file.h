#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace remaps {

/// A regular file, open for reading at any place.
class InputFile {
 public:
  /// @throws InputError  missing, unreadable or not a regular file
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// Reads up to n bytes at an offset; 0 at the end of the file.
  /// @throws IoError
  std::size_t read_at(char* to, std::size_t n, std::uint64_t offset) const;

 private:
  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace remaps
