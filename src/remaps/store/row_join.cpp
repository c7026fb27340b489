#include "remaps/store/row_join.h"

#include <algorithm>
#include <utility>

namespace remaps::store {
namespace {

/// Bytes of a bucket that are looked at together.
constexpr std::uint64_t kPiece = 256 << 10;
/// A range of numbers has so many at most: they are numbered in 32 bits.
constexpr std::uint64_t kMostInRange = 1 << 24;
constexpr std::uint64_t kLeastInRange = 1 << 10;

/// So many numbers that `bytes_each` of all of them fit.
std::uint64_t range_of(std::uint64_t bytes, std::uint64_t bytes_each) {
  return std::clamp(bytes / std::max<std::uint64_t>(bytes_each, 1), kLeastInRange, kMostInRange);
}

std::size_t ranges(std::uint64_t count, std::uint64_t range) {
  return static_cast<std::size_t>(count / range + (count % range != 0));
}

/// Calls f(bytes) with whole records of a bucket, a piece at a time, and frees the bucket.
template <class F>
void take_pieces(BucketFile& file, std::size_t bucket, std::size_t record, Bytes& bytes, F f) {
  const std::uint64_t piece = std::max<std::uint64_t>(kPiece / record, 1) * record;
  for (std::uint64_t at = 0; at < file.bytes(bucket); at += piece) {
    file.read(bucket, at, std::min(piece, file.bytes(bucket) - at), bytes);
    f(ByteSpan(bytes));
  }
  file.release(bucket);
}

}  // namespace

RowJoin::RowJoin(std::string name, std::filesystem::path temp_dir, const Shape& shape,
                 std::uint64_t buffer_bytes, MemoryBudget& budget)
    : name_(std::move(name)),
      temp_dir_(std::move(temp_dir)),
      shape_(shape),
      budget_(budget),
      range_(range_of(buffer_bytes, shape.row_bytes)) {
  requests_.emplace(temp_dir_ / (name_ + "-wanted"), ranges(shape.rows, range_), buffer_bytes,
                    budget);
}

void RowJoin::ask(std::uint64_t row, std::uint64_t asker, ByteSpan payload) {
  if (row >= shape_.rows) {
    throw CorruptionError(name_ + " " + std::to_string(row) + " of " + std::to_string(shape_.rows) +
                          " was asked for");
  }
  ++asked_;
  requests_->append_record(static_cast<std::size_t>(row / range_), [&](Packer& packer) {
    packer.put(static_cast<std::uint32_t>(row % range_));
    packer.put40(asker);
    packer.put_array(payload);
  });
}

/// Reads the ranges of rows and sends each request on with its row.
void RowJoin::fetch(Read read, BucketFile& answers, std::uint64_t block,
                    FunctionRef<void(double)> progress) {
  const std::size_t width = shape_.row_bytes;
  const Reservation reservation =
      budget_.reserve(std::min(range_, shape_.rows) * width, "a range of " + name_);
  Bytes rows, requests, answer;
  for (std::size_t r = 0; r < requests_->buckets(); ++r) {
    progress(double(r) / double(requests_->buckets()));
    if (requests_->bytes(r) == 0) continue;
    const std::uint64_t first = r * range_;
    rows.resize(static_cast<std::size_t>(std::min(range_, shape_.rows - first)) * width);
    read(first, rows);
    take_pieces(*requests_, r, 9 + shape_.payload_bytes, requests, [&](ByteSpan bytes) {
      Unpacker unpacker(bytes, name_);
      answer.resize(shape_.payload_bytes + width);
      while (!unpacker.done()) {
        const auto row = unpacker.get<std::uint32_t>();
        const std::uint64_t asker = unpacker.get40();
        unpacker.get_array(std::span(answer).first(shape_.payload_bytes));
        std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(row * width), width,
                    answer.begin() + static_cast<std::ptrdiff_t>(shape_.payload_bytes));
        answers.append_record(static_cast<std::size_t>(asker / block), [&](Packer& packer) {
          packer.put(static_cast<std::uint32_t>(asker % block));
          packer.put_array(ByteSpan(answer));
        });
      }
    });
  }
}

void RowJoin::run(Read read, Gather& gather, std::uint64_t buffer_bytes,
                  FunctionRef<void(double)> progress) {
  const std::uint64_t block = range_of(buffer_bytes / 2, shape_.gather_bytes);
  BucketFile answers(temp_dir_ / (name_ + "-found"), ranges(shape_.askers, block), buffer_bytes / 4,
                     budget_);
  fetch(read, answers, block, [&](double fraction) { progress(0.6 * fraction); });
  requests_.reset();
  const Reservation reservation = budget_.reserve(
      std::min(block, shape_.askers) * shape_.gather_bytes, "what is gathered of " + name_);
  const std::size_t record = 4 + shape_.payload_bytes + shape_.row_bytes;
  Bytes bytes;
  for (std::size_t b = 0; b < answers.buckets(); ++b) {
    progress(0.6 + 0.4 * double(b) / double(answers.buckets()));
    const std::uint64_t first = b * block;
    const std::uint64_t count = std::min(block, shape_.askers - first);
    gather.begin(count);
    take_pieces(answers, b, record, bytes, [&](ByteSpan all) {
      for (; !all.empty(); all = all.subspan(record)) {
        std::uint32_t number = 0;
        std::copy_n(all.begin(), sizeof number,
                    std::as_writable_bytes(std::span(&number, 1)).begin());
        gather.take(number, all.subspan(4, shape_.payload_bytes),
                    all.subspan(4 + shape_.payload_bytes, shape_.row_bytes));
      }
    });
    gather.end();
  }
}

}  // namespace remaps::store
