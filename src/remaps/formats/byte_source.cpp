#include "remaps/formats/byte_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {

std::string printable(std::string_view what) {
  constexpr std::size_t kLongest = 400;
  std::string text(what.substr(0, kLongest));
  for (char& c : text) {
    if ((c >= 0 && c < ' ') || c == '\x7f') c = '?';
  }
  if (what.size() > kLongest) text += "...";
  return text;
}

ByteSource::ByteSource(std::filesystem::path path, std::size_t buffer_bytes, MemoryBudget* budget)
    : file_(std::make_unique<InputFile>(std::move(path))),
      decompressor_(make_decompressor(*file_, budget)),
      size_(decompressor_ ? decompressor_->most_content() : file_->size()),
      size_is_known_(!decompressor_),
      capacity_(buffer_bytes),
      buffer_(std::make_unique_for_overwrite<char[]>(buffer_bytes + 1)),
      next_(buffer_.get()),
      end_(buffer_.get()) {
  *end_ = '\n';
}

std::string ByteSource::room_text(std::uint64_t n) const {
  if (!is_compressed()) return fmt::format("the file has only {} bytes left", n);
  return fmt::format("the decompressed content has {} {} bytes left",
                     size_is_known_ ? "only" : "at most", n);
}

std::uint64_t ByteSource::expected_size() const {
  if (size_is_known_) return size_;
  const std::uint64_t used = decompressor_->file_offset();
  if (used == 0) return file_size();
  return static_cast<std::uint64_t>(double(end_offset_) / double(used) * double(file_size()));
}

std::uint64_t ByteSource::file_offset_of(std::uint64_t offset) const {
  if (!is_compressed()) return offset;
  const auto expected = double(std::max<std::uint64_t>(expected_size(), 1));
  return static_cast<std::uint64_t>(std::min(double(offset) / expected, 1.0) * double(file_size()));
}

void ByteSource::refill() {
  const std::size_t kept = available();
  std::memmove(buffer_.get(), next_, kept);
  next_ = buffer_.get();
  end_ = buffer_.get() + kept;
  while (static_cast<std::size_t>(end_ - next_) < capacity_ && !exhausted()) {
    const auto wanted = static_cast<std::size_t>(
        std::min<std::uint64_t>(capacity_ - available(), size_ - end_offset_));
    const std::size_t got = is_compressed() ? decompressor_->read(end_, wanted)
                                            : file_->read_at(end_, wanted, end_offset_);
    if (got == 0) {
      if (size_is_known_) fail_at_byte(end_offset_, "the file shrank while it was read");
      size_ = end_offset_;
      size_is_known_ = true;
    }
    end_ += got;
    end_offset_ += got;
    bytes_read_total_ += got;
  }
  *end_ = '\n';
}

void ByteSource::skip(std::uint64_t n) {
  if (n <= available()) {
    consume(static_cast<std::size_t>(n));
  } else {
    seek(offset() + n);
  }
}

/// Empties the buffer; what comes next is at `offset`.
void ByteSource::drop_buffer(std::uint64_t offset) {
  next_ = end_ = buffer_.get();
  *end_ = '\n';
  end_offset_ = offset;
}

void ByteSource::seek(std::uint64_t offset) {
  const std::uint64_t first = end_offset_ - static_cast<std::uint64_t>(end_ - buffer_.get());
  if (offset >= first && offset <= end_offset_) {
    next_ = buffer_.get() + (offset - first);
    return;
  }
  if (!is_compressed()) return drop_buffer(std::min(offset, size_));
  if (offset < first) {
    decompressor_->restart();
    drop_buffer(0);
  }
  while (end_offset_ < offset && !exhausted()) {
    drop_buffer(end_offset_);
    refill();
  }
  next_ = end_ - (end_offset_ - std::min(offset, end_offset_));
}

void ByteSource::fail_at_byte(std::uint64_t offset, std::string_view what) const {
  throw InputError(
      fmt::format("{}: byte {}{}: {}", path().string(), offset, kind_of_place(), printable(what)));
}

void ByteSource::fail_at_line(std::uint64_t offset, std::string_view what) {
  // The text may lie in the buffer that is filled again here.
  const std::string text(what);
  std::uint64_t line = 1;
  for (seek(0); this->offset() < offset && require(1) > 0;) {
    const auto n =
        static_cast<std::size_t>(std::min<std::uint64_t>(available(), offset - this->offset()));
    line += static_cast<std::uint64_t>(std::count(data(), data() + n, '\n'));
    consume(n);
  }
  throw InputError(
      fmt::format("{}: line {}{}: {}", path().string(), line, kind_of_place(), printable(text)));
}

}  // namespace remaps
