#include "remaps/formats/record_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "remaps/base/errors.h"

namespace remaps {

RecordSpool::RecordSpool(const std::filesystem::path& target, std::size_t record_bytes)
    : path_(target.parent_path() /
            fmt::format(".{}.records-{}", target.filename().string(), ::getpid())),
      record_bytes_(record_bytes) {
  // What a killed process of the same id left behind is in the way.
  ::unlink(path_.c_str());
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file_ < 0) fail("create");
  ::unlink(path_.c_str());
  while ((std::size_t{2} << set_bits_) * kWays * kBlock * record_bytes <= kCacheBytes) ++set_bits_;
  slots_.resize(kWays << set_bits_);
  hand_.resize(std::size_t{1} << set_bits_);
  cache_.resize(slots_.size() * kBlock * record_bytes);
}

RecordSpool::~RecordSpool() {
  if (file_ >= 0) ::close(file_);
}

std::byte* RecordSpool::find(std::uint64_t number, bool dirty) {
  const std::uint64_t block = number / kBlock;
  if (slots_[last_].block != block) {
    // Neighbouring rows of a grid lie a fixed number of blocks apart: the product spreads them.
    const std::uint64_t spread = block * 0x9E3779B97F4A7C15ULL;
    const auto set = static_cast<std::size_t>(set_bits_ == 0 ? 0 : spread >> (64 - set_bits_));
    last_ = set * kWays;
    while (last_ < (set + 1) * kWays && slots_[last_].block != block) ++last_;
    if (last_ == (set + 1) * kWays) last_ = load(set, block);
  }
  Slot& slot = slots_[last_];
  slot.used = true;
  slot.dirty = slot.dirty || dirty;
  return cache_.data() +
         (last_ * kBlock + static_cast<std::size_t>(number % kBlock)) * record_bytes_;
}

std::size_t RecordSpool::load(std::size_t set, std::uint64_t block) {
  std::uint8_t& hand = hand_[set];
  const auto step = [&] { hand = static_cast<std::uint8_t>((hand + 1) % kWays); };
  for (; slots_[set * kWays + hand].used; step()) slots_[set * kWays + hand].used = false;
  const std::size_t at = set * kWays + hand;
  step();
  std::byte* const bytes = cache_.data() + at * kBlock * record_bytes_;
  Slot& slot = slots_[at];
  if (slot.dirty) write(slot.block, bytes);
  slot = {};
  read(block, bytes);
  slot.block = block;
  return at;
}

void RecordSpool::read(std::uint64_t block, std::byte* to) const {
  const std::size_t bytes = kBlock * record_bytes_;
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t got =
        ::pread(file_, to + done, bytes - done, static_cast<off_t>(block * bytes + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("read");
    if (got == 0) {  // never written
      std::fill(to + done, to + bytes, std::byte{0});
      return;
    }
    done += static_cast<std::size_t>(got);
  }
}

void RecordSpool::write(std::uint64_t block, const std::byte* from) const {
  const std::size_t bytes = kBlock * record_bytes_;
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t wrote =
        ::pwrite(file_, from + done, bytes - done, static_cast<off_t>(block * bytes + done));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail("write");
    done += static_cast<std::size_t>(wrote);
  }
}

void RecordSpool::fail(const char* doing) const {
  throw IoError(fmt::format("{}: cannot {} what was put aside: {}", path_.string(), doing,
                            std::strerror(errno)));
}

}  // namespace remaps
