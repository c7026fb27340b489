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

void ByteSink::commit() {
  flush();
  const bool closed = ::close(std::exchange(file_, -1)) == 0;
  if (closed && ::rename(partial_path_.c_str(), path_.c_str()) == 0) return;
  const int error = errno;
  ::unlink(partial_path_.c_str());
  errno = error;
  fail(closed ? "rename the finished file to its name" : "close");
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
  if (file_ < 0) return;
  ::close(std::exchange(file_, -1));
  ::unlink(partial_path_.c_str());
}

void ByteSink::fail(const char* doing) const {
  throw IoError(fmt::format("{}: cannot {}: {}", path_.string(), doing, std::strerror(errno)));
}

}  // namespace remaps
