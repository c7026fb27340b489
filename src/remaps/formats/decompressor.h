#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "remaps/base/memory_budget.h"
#include "remaps/formats/input_file.h"

namespace remaps {

/// What a compressed file holds, as a stream of bytes from its start. Memory is bounded by the
/// format's window, not by what the file announces about its content.
class Decompressor {
 public:
  virtual ~Decompressor() = default;

  /// The next bytes, at most n; 0 at the end, and only there.
  /// @throws InputError  damaged or cut-off data: names the byte of the compressed file
  virtual std::size_t read(char* to, std::size_t n) = 0;
  /// Goes back to the start.
  virtual void restart() = 0;

  /// Bytes of the file that were used up since the start.
  virtual std::uint64_t file_offset() const = 0;
  /// Bytes that came from the file so far, those read again included.
  virtual std::uint64_t bytes_read_total() const = 0;
  /// More than this no file of this size can hold.
  virtual std::uint64_t most_content() const = 0;
};

/// A decompressor for what the first bytes of the file say it is: gzip (of any number of members)
/// or Zstandard (of any number of frames); nullptr if it is neither.
///
/// @param file    must outlive the decompressor
/// @param budget  optional; a window of more than 1 MiB is reserved from it
/// @throws BudgetError  the window does not fit the budget
/// @throws InputError   without a budget: the window is larger than 128 MiB
std::unique_ptr<Decompressor> make_decompressor(const InputFile& file, MemoryBudget* budget);

}  // namespace remaps
