#include "remaps/formats/column_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {

ColumnSpool::ColumnSpool(const std::filesystem::path& target, std::uint64_t rows,
                         std::vector<std::size_t> widths)
    : path_(target.parent_path() /
            fmt::format(".{}.columns-{}", target.filename().string(), ::getpid())),
      rows_(rows),
      widths_(std::move(widths)) {
  for (const std::size_t width : widths_) {
    begin_.push_back(rows * row_bytes_);
    row_bytes_ += width;
  }
  // What a killed process of the same id left behind is in the way.
  ::unlink(path_.c_str());
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file_ < 0) fail("create");
  ::unlink(path_.c_str());
}

ColumnSpool::~ColumnSpool() {
  if (file_ >= 0) ::close(file_);
}

void ColumnSpool::append(std::span<const std::byte> rows) {
  const std::size_t n = rows.size() / row_bytes_;
  std::size_t at = 0;
  for (std::size_t c = 0; c < widths_.size(); at += widths_[c++]) {
    column_.resize(n * widths_[c]);
    for (std::size_t i = 0; i < n; ++i) {
      std::memcpy(column_.data() + i * widths_[c], rows.data() + i * row_bytes_ + at, widths_[c]);
    }
    write(begin_[c] + done_ * widths_[c], column_);
  }
  done_ += n;
}

void ColumnSpool::copy(std::size_t column, ByteSink& to) const {
  std::uint64_t at = begin_[column];
  const std::uint64_t end = at + rows_ * widths_[column];
  while (at < end) {
    constexpr std::size_t kPiece = std::size_t{1} << 16;
    const auto want = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, end - at));
    const ssize_t got = ::pread(file_, to.room(want), want, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = EIO;
    if (got <= 0) fail("read");
    to.advance(static_cast<std::size_t>(got));
    at += static_cast<std::uint64_t>(got);
  }
}

void ColumnSpool::write(std::uint64_t offset, std::span<const std::byte> bytes) const {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = ::pwrite(file_, bytes.data() + done, bytes.size() - done,
                                   static_cast<off_t>(offset + done));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail("write");
    done += static_cast<std::size_t>(wrote);
  }
}

void ColumnSpool::fail(const char* doing) const {
  throw IoError(fmt::format("{}: cannot {} the attributes put aside: {}", path_.string(), doing,
                            std::strerror(errno)));
}

}  // namespace remaps
