#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "remaps/store/disk_usage.h"
#include "remaps/store/file.h"

namespace remaps::store {

/// Rows of one size in a temporary file: appended in order, then read by number.
class RowSpool {
 public:
  RowSpool(const std::filesystem::path& path, std::size_t row_bytes)
      : path_(path), row_bytes_(row_bytes), file_(File::create(path)) {}
  /// Removes the file.
  ~RowSpool() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  RowSpool(const RowSpool&) = delete;
  RowSpool& operator=(const RowSpool&) = delete;

  std::size_t row_bytes() const { return row_bytes_; }
  std::uint64_t rows() const { return bytes_ / row_bytes_; }

  /// Whole rows, some thousands at a time: they are written at once.
  void append(ByteSpan rows) {
    file_.write_at(bytes_, rows);
    bytes_ += rows.size();
    disk_.grow(rows.size());
  }
  /// Reads rows first, first + 1, ...: as many as fit.
  /// @throws CorruptionError  there are not so many
  void read(std::uint64_t first, std::span<std::byte> out) const {
    file_.read_at(first * row_bytes_, out);
  }

 private:
  std::filesystem::path path_;
  std::size_t row_bytes_;
  File file_;
  DiskShare disk_;
  std::uint64_t bytes_ = 0;
};

}  // namespace remaps::store
