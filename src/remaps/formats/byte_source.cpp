#include "remaps/formats/byte_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

/// Reads up to n bytes at an offset; 0 at the end of the file.
std::size_t read_at(int file, char* to, std::size_t n, std::uint64_t offset,
                    const std::filesystem::path& path) {
  for (;;) {
    const ssize_t got = ::pread(file, to, n, static_cast<off_t>(offset));
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) {
      throw IoError(fmt::format("{}: cannot read at byte {}: {}", path.string(), offset,
                                std::strerror(errno)));
    }
  }
}

}  // namespace

std::string printable(std::string_view what) {
  constexpr std::size_t kLongest = 400;
  std::string text(what.substr(0, kLongest));
  for (char& c : text) {
    if ((c >= 0 && c < ' ') || c == '\x7f') c = '?';
  }
  if (what.size() > kLongest) text += "...";
  return text;
}

ByteSource::ByteSource(std::filesystem::path path, std::size_t buffer_bytes)
    : path_(std::move(path)),
      capacity_(buffer_bytes),
      buffer_(std::make_unique_for_overwrite<char[]>(buffer_bytes + 1)),
      next_(buffer_.get()),
      end_(buffer_.get()) {
  *end_ = '\n';
  const int file = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) {
    throw InputError(fmt::format("{}: cannot open: {}", path_.string(), std::strerror(errno)));
  }
  struct stat status = {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(file);
    throw InputError(fmt::format("{}: expected a regular file", path_.string()));
  }
  file_ = file;
  // Advice only: a larger read-ahead, where the system follows it.
  ::posix_fadvise(file_, 0, 0, POSIX_FADV_SEQUENTIAL);
  size_ = static_cast<std::uint64_t>(status.st_size);
}

ByteSource::~ByteSource() {
  if (file_ >= 0) ::close(file_);
}

ByteSource::ByteSource(ByteSource&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      size_(other.size_),
      end_offset_(other.end_offset_),
      bytes_read_total_(other.bytes_read_total_),
      capacity_(other.capacity_),
      buffer_(std::move(other.buffer_)),
      next_(other.next_),
      end_(other.end_) {}

void ByteSource::refill() {
  const std::size_t kept = available();
  std::memmove(buffer_.get(), next_, kept);
  next_ = buffer_.get();
  end_ = buffer_.get() + kept;
  while (static_cast<std::size_t>(end_ - next_) < capacity_ && !exhausted()) {
    const std::uint64_t wanted =
        std::min<std::uint64_t>(capacity_ - available(), size_ - end_offset_);
    const std::size_t got =
        read_at(file_, end_, static_cast<std::size_t>(wanted), end_offset_, path_);
    if (got == 0) fail_at_byte(end_offset_, "the file shrank while it was read");
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

void ByteSource::seek(std::uint64_t offset) {
  const std::uint64_t first = end_offset_ - static_cast<std::uint64_t>(end_ - buffer_.get());
  if (offset >= first && offset <= end_offset_) {
    next_ = buffer_.get() + (offset - first);
    return;
  }
  next_ = end_ = buffer_.get();
  *end_ = '\n';
  end_offset_ = std::min(offset, size_);
}

void ByteSource::fail_at_byte(std::uint64_t offset, std::string_view what) const {
  throw InputError(fmt::format("{}: byte {}: {}", path_.string(), offset, printable(what)));
}

void ByteSource::fail_at_line(std::uint64_t offset, std::string_view what) const {
  constexpr std::size_t kPiece = std::size_t{1} << 16;
  const auto piece = std::make_unique_for_overwrite<char[]>(kPiece);
  std::uint64_t line = 1;
  for (std::uint64_t at = 0; at < offset;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, offset - at));
    const std::size_t got = read_at(file_, piece.get(), wanted, at, path_);
    if (got == 0) break;
    line += static_cast<std::uint64_t>(std::count(piece.get(), piece.get() + got, '\n'));
    at += got;
  }
  throw InputError(fmt::format("{}: line {}: {}", path_.string(), line, printable(what)));
}

}  // namespace remaps
