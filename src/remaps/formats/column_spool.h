#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "remaps/formats/byte_sink.h"

namespace remaps {

/// Turns rows into columns on disk: for formats that have an array for each attribute. Rows are
/// known by number; each column is copied out as a whole. Memory: the rows that are put at a time.
class ColumnSpool {
 public:
  /// Makes a file beside `target` that has no name: it goes with the process.
  /// @param widths  bytes of each column, in the order of a row
  /// @throws IoError
  ColumnSpool(const std::filesystem::path& target, std::uint64_t rows,
              std::vector<std::size_t> widths);
  ~ColumnSpool();
  ColumnSpool(const ColumnSpool&) = delete;
  ColumnSpool& operator=(const ColumnSpool&) = delete;

  /// The next rows, as many as announced in all.
  /// @throws IoError
  void append(std::span<const std::byte> rows);
  /// @throws IoError
  void copy(std::size_t column, ByteSink& to) const;

 private:
  void write(std::uint64_t offset, std::span<const std::byte> bytes) const;
  [[noreturn]] void fail(const char* doing) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t rows_, done_ = 0;
  std::vector<std::size_t> widths_;
  std::vector<std::uint64_t> begin_;  // of each column, in the file
  std::size_t row_bytes_ = 0;
  std::vector<std::byte> column_;
};

}  // namespace remaps
