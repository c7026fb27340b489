#include "remaps/formats/position_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

constexpr std::size_t kFlushAt = std::size_t{1} << 14;

}  // namespace

PositionSpool::PositionSpool(const std::filesystem::path& target)
    : path_(target.parent_path() /
            fmt::format(".{}.positions-{}", target.filename().string(), ::getpid())) {
  // What a killed process of the same id left behind is in the way.
  ::unlink(path_.c_str());
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file_ < 0) fail("create");
  ::unlink(path_.c_str());
}

PositionSpool::~PositionSpool() {
  if (file_ >= 0) ::close(file_);
}

void PositionSpool::append(std::span<const Vec3> positions) {
  for (const Vec3& p : positions) waiting_.push_back(to_float(p));
  count_ += positions.size();
  if (waiting_.size() >= kFlushAt) flush();
}

Vec3f PositionSpool::at(VertexId v) {
  const std::uint64_t block = v / kBlock;
  // Neighbouring rows of a grid lie a fixed number of blocks apart: the product spreads them.
  const auto set = static_cast<std::size_t>((block * 0x9E3779B97F4A7C15ULL) >> (64 - kSetBits));
  if (!slots_.empty()) {
    for (std::size_t slot = set * kWays; slot < (set + 1) * kWays; ++slot) {
      if (slots_[slot].block != block) continue;
      slots_[slot].used = true;
      return cache_[slot * kBlock + v % kBlock];
    }
  }
  return load(set, block)[v % kBlock];
}

const Vec3f* PositionSpool::load(std::size_t set, std::uint64_t block) {
  if (slots_.empty()) {
    flush();
    waiting_ = {};
    slots_.resize(kSlots);
    cache_.resize(kSlots * kBlock);
  }
  std::uint8_t& hand = hand_[set];
  while (slots_[set * kWays + hand].used) {
    slots_[set * kWays + hand].used = false;
    hand = static_cast<std::uint8_t>((hand + 1) % kWays);
  }
  const std::size_t slot = set * kWays + hand;
  hand = static_cast<std::uint8_t>((hand + 1) % kWays);
  slots_[slot] = {};
  Vec3f* const to = &cache_[slot * kBlock];
  const std::uint64_t first = block * kBlock;
  const std::size_t bytes =
      static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, count_ - first)) * sizeof(Vec3f);
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t got = ::pread(file_, reinterpret_cast<char*>(to) + done, bytes - done,
                                static_cast<off_t>(first * sizeof(Vec3f) + done));
    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = EIO;
    if (got <= 0) fail("read");
    done += static_cast<std::size_t>(got);
  }
  slots_[slot] = {block, true};
  ++blocks_read_;
  return to;
}

void PositionSpool::flush() {
  const std::size_t bytes = waiting_.size() * sizeof(Vec3f);
  const std::uint64_t offset = (count_ - waiting_.size()) * sizeof(Vec3f);
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t wrote = ::pwrite(file_, reinterpret_cast<const char*>(waiting_.data()) + done,
                                   bytes - done, static_cast<off_t>(offset + done));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail("write");
    done += static_cast<std::size_t>(wrote);
  }
  waiting_.clear();
}

void PositionSpool::fail(const char* doing) const {
  throw IoError(fmt::format("{}: cannot {} the positions put aside: {}", path_.string(), doing,
                            std::strerror(errno)));
}

}  // namespace remaps
