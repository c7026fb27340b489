#include "remaps/formats/byte_sink.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {

ByteSink::ByteSink(std::filesystem::path path)
    : path_(std::move(path)), buffer_(std::make_unique_for_overwrite<char[]>(kBuffer)) {
  partial_path_ =
      path_.parent_path() / fmt::format(".{}.partial-{}", path_.filename().string(), ::getpid());
  // What a killed process of the same id left behind is in the way.
  ::unlink(partial_path_.c_str());
  file_ = ::open(partial_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file_ < 0) fail("create");
}

ByteSink::~ByteSink() {
  discard();
}

void ByteSink::write(const void* bytes, std::size_t n) {
  const char* from = static_cast<const char*>(bytes);
  while (n > 0) {
    const std::size_t piece = std::min(n, kBuffer);
    std::memcpy(room(piece), from, piece);
    advance(piece);
    from += piece;
    n -= piece;
  }
}

void ByteSink::rewrite(std::uint64_t offset, const void* bytes, std::size_t n) {
  flush();
  const char* const from = static_cast<const char*>(bytes);
  for (std::size_t done = 0; done < n;) {
    const ssize_t wrote = ::pwrite(file_, from + done, n - done, static_cast<off_t>(offset + done));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail("write");
    done += static_cast<std::size_t>(wrote);
  }
}

void ByteSink::commit() {
  flush();
  if (::close(std::exchange(file_, -1)) != 0) fail("close");
  if (::rename(partial_path_.c_str(), path_.c_str()) != 0) {
    fail("rename the finished file to its name");
  }
  partial_path_.clear();
}

void ByteSink::flush() {
  for (std::size_t done = 0; done < used_;) {
    const ssize_t wrote = ::write(file_, buffer_.get() + done, used_ - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail("write");
    done += static_cast<std::size_t>(wrote);
  }
  used_ = 0;
}

void ByteSink::discard() noexcept {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
  if (!partial_path_.empty()) ::unlink(partial_path_.c_str());
  partial_path_.clear();
}

void ByteSink::fail(const char* doing) {
  const int error = errno;
  discard();
  throw IoError(fmt::format("{}: cannot {}: {}", path_.string(), doing, std::strerror(error)));
}

}  // namespace remaps
