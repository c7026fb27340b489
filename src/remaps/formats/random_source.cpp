#include "remaps/formats/random_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {

RandomSource::RandomSource(std::filesystem::path path) : path_(std::move(path)) {
  // Opening a pipe must not wait for its other end.
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file_ < 0) {
    throw InputError(fmt::format("{}: cannot open: {}", path_.string(), std::strerror(errno)));
  }
  struct stat status = {};
  if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(std::exchange(file_, -1));
    throw InputError(fmt::format("{}: expected a regular file", path_.string()));
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

RandomSource::~RandomSource() {
  if (file_ >= 0) ::close(file_);
}

void RandomSource::read_at(std::uint64_t offset, std::span<char> bytes) const {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got =
        ::pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      throw IoError(fmt::format("{}: cannot read at byte {}: {}", path_.string(), offset + done,
                                std::strerror(errno)));
    }
    if (got == 0) {
      fail_at_byte(offset + done, fmt::format("expected {} more bytes, found the end of the file",
                                              bytes.size() - done));
    }
    done += static_cast<std::size_t>(got);
  }
  bytes_read_total_ += bytes.size();
}

void RandomSource::fail_at_byte(std::uint64_t offset, std::string_view what) const {
  throw InputError(fmt::format("{}: byte {}: {}", path_.string(), offset, what));
}

}  // namespace remaps
