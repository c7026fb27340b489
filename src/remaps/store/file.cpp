#include "remaps/store/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <utility>

namespace remaps::store {
namespace {

std::atomic<std::uint64_t> bytes_read{0};
std::atomic<std::uint64_t> bytes_written{0};

}  // namespace

IoCounts io_counts() {
  return {bytes_read.load(), bytes_written.load()};
}

void File::fail(const char* what) const {
  throw IoError(path_.string() + ": cannot " + what + ": " +
                std::generic_category().message(errno));
}

File File::open_read(const std::filesystem::path& path) {
  File file;
  file.path_ = path;
  file.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file.descriptor_ < 0) file.fail("open");
  return file;
}

File File::create(const std::filesystem::path& path) {
  File file;
  file.path_ = path;
  file.descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file.descriptor_ < 0) file.fail("create");
  return file;
}

File::File(File&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::uint64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail("stat");
  return static_cast<std::uint64_t>(status.st_size);
}

void File::read_at(std::uint64_t offset, std::span<std::byte> data) const {
  std::size_t done = 0;
  while (done < data.size()) {
    const ssize_t n = ::pread(descriptor_, data.data() + done, data.size() - done,
                              static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("read");
    if (n == 0) {
      throw CorruptionError(path_.string() + ": ends at byte " + std::to_string(offset + done) +
                            ", " + std::to_string(data.size() - done) + " more were expected");
    }
    done += static_cast<std::size_t>(n);
  }
  bytes_read += data.size();
}

void File::write_at(std::uint64_t offset, ByteSpan data) {
  std::size_t done = 0;
  while (done < data.size()) {
    const ssize_t n = ::pwrite(descriptor_, data.data() + done, data.size() - done,
                               static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("write");
    done += static_cast<std::size_t>(n);
  }
  bytes_written += data.size();
}

void File::punch_hole(std::uint64_t offset, std::uint64_t bytes) {
  const int mode = FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE;
  int result = 0;
  do {
    result = ::fallocate(descriptor_, mode, static_cast<off_t>(offset), static_cast<off_t>(bytes));
  } while (result != 0 && errno == EINTR);
  if (result != 0 && errno != EOPNOTSUPP && errno != ENOSYS) fail("free space");
}

void File::close() {
  const int descriptor = std::exchange(descriptor_, -1);
  if (descriptor >= 0 && ::close(descriptor) != 0) fail("close");
}

std::filesystem::path partial_name(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.partial-{}", path.filename().string(), ::getpid());
}

void write_file_atomically(const std::filesystem::path& path, std::string_view content) {
  const std::filesystem::path partial = partial_name(path);
  try {
    File file = File::create(partial);
    file.write_at(0, std::as_bytes(std::span(content.data(), content.size())));
    file.close();
    std::filesystem::rename(partial, path);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw;
  }
}

std::string read_whole_file(const std::filesystem::path& path) {
  const File file = File::open_read(path);
  std::string content(file.size(), '\0');
  file.read_at(0, std::as_writable_bytes(std::span(content.data(), content.size())));
  return content;
}

TempDir::TempDir(const std::filesystem::path& parent) {
  for (unsigned i = 0;; ++i) {
    path_ = parent / fmt::format(".remaps-{}-{}", ::getpid(), i);
    std::error_code error;
    if (std::filesystem::create_directory(path_, error)) return;
    if (error) throw IoError(path_.string() + ": cannot create the directory: " + error.message());
  }
}

TempDir::~TempDir() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace remaps::store
