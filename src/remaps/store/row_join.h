#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "remaps/base/function_ref.h"
#include "remaps/base/memory_budget.h"
#include "remaps/store/bucket_file.h"

namespace remaps::store {

/// Brings rows of an array to those who asked for them, where neither the rows nor the requests fit
/// in memory. Requests wait in the bucket of the range of rows that they want one of; ranges are
/// read one after the other; requests with their rows wait in the bucket of the range of numbers
/// that asked; and are handed over range by range.
///
/// A number that asks in the order of rows gets its answers in that order, whatever the memory.
class RowJoin {
 public:
  struct Shape {
    std::uint64_t rows = 0;         ///< of the array
    std::uint64_t askers = 0;       ///< numbers that may ask
    std::size_t row_bytes = 0;      ///< at least 1
    std::size_t payload_bytes = 0;  ///< that a request carries along
    std::size_t gather_bytes = 0;  ///< that whoever gathers keeps for a number of the present range
  };

  /// @param buffer_bytes  for the write buffers of the requests
  RowJoin(std::string name, std::filesystem::path temp_dir, const Shape& shape,
          std::uint64_t buffer_bytes, MemoryBudget& budget);

  /// @param payload  payload_bytes of them
  /// @throws CorruptionError  there is no such row
  void ask(std::uint64_t row, std::uint64_t asker, ByteSpan payload);
  std::uint64_t asked() const { return asked_; }

  /// Fills `out` with rows from `first` on.
  using Read = FunctionRef<void(std::uint64_t first, std::span<std::byte> out)>;
  /// Receives the requests with their rows, range by range.
  class Gather {
   public:
    virtual ~Gather() = default;
    virtual void begin(std::uint64_t count) = 0;
    /// @param number  counts from the first of the range
    virtual void take(std::size_t number, ByteSpan payload, ByteSpan row) = 0;
    virtual void end() = 0;
  };

  /// Hands all requests over. May be called once. `progress` hears of the fraction done.
  /// @param buffer_bytes  for rows, write buffers and what is gathered, reserved from the budget
  void run(Read read, Gather& gather, std::uint64_t buffer_bytes,
           FunctionRef<void(double)> progress);

 private:
  void fetch(Read read, BucketFile& answers, std::uint64_t block,
             FunctionRef<void(double)> progress);

  std::string name_;
  std::filesystem::path temp_dir_;
  Shape shape_;
  MemoryBudget& budget_;
  std::uint64_t range_;  // rows
  std::uint64_t asked_ = 0;
  std::optional<BucketFile> requests_;
};

}  // namespace remaps::store
