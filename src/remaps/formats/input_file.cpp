#include "remaps/formats/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "remaps/base/errors.h"

namespace remaps {

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
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

InputFile::~InputFile() {
  if (file_ >= 0) ::close(file_);
}

std::size_t InputFile::read_at(char* to, std::size_t n, std::uint64_t offset) const {
  for (;;) {
    const ssize_t got = ::pread(file_, to, n, static_cast<off_t>(offset));
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) {
      throw IoError(fmt::format("{}: cannot read at byte {}: {}", path_.string(), offset,
                                std::strerror(errno)));
    }
  }
}

}  // namespace remaps
