#include "remaps/formats/decompressor.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <string_view>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

using Byte = unsigned char;

/// The compressed file, piece by piece.
class CompressedBytes {
 public:
  explicit CompressedBytes(const InputFile& file)
      : file_(file), buffer_(std::make_unique_for_overwrite<char[]>(kBuffer)) {}

  /// The bytes ahead: none only at the end of the file.
  std::string_view ahead() {
    if (left_.empty() && end_ < file_.size()) {
      const std::size_t n = file_.read_at(buffer_.get(), kBuffer, end_);
      if (n == 0) fail("the file shrank while it was read");
      left_ = {buffer_.get(), n};
      end_ += n;
      read_total_ += n;
    }
    return left_;
  }
  void consume(std::size_t n) { left_.remove_prefix(n); }
  void restart() {
    left_ = {};
    end_ = 0;
  }

  const InputFile& file() const { return file_; }
  std::uint64_t offset() const { return end_ - left_.size(); }
  std::uint64_t read_total() const { return read_total_; }

  [[noreturn]] void fail(std::string_view what) const {
    throw InputError(fmt::format("{}: byte {}: {}", file_.path().string(), offset(), what));
  }

 private:
  static constexpr std::size_t kBuffer = std::size_t{128} << 10;

  const InputFile& file_;
  std::unique_ptr<char[]> buffer_;
  std::string_view left_;
  std::uint64_t end_ = 0;  // in the file, of what was read
  std::uint64_t read_total_ = 0;
};

class OneFile : public Decompressor {
 public:
  /// @param most_ratio  no byte of the format makes more of content
  OneFile(const InputFile& file, std::uint64_t most_ratio) : input_(file), ratio_(most_ratio) {}

  std::uint64_t file_offset() const override { return input_.offset(); }
  std::uint64_t bytes_read_total() const override { return input_.read_total(); }
  std::uint64_t most_content() const override {
    constexpr std::uint64_t kMost = std::uint64_t{1} << 62;
    return input_.file().size() < kMost / ratio_ ? input_.file().size() * ratio_ : kMost;
  }

 protected:
  CompressedBytes input_;  // NOLINT: for the formats below

 private:
  std::uint64_t ratio_;
};

class Gzip final : public OneFile {
 public:
  explicit Gzip(const InputFile& file) : OneFile(file, kRatio) {
    constexpr int kGzip = 16;  // on top of the largest window
    if (::inflateInit2(&stream_, MAX_WBITS + kGzip) != Z_OK) throw std::bad_alloc();
  }
  ~Gzip() override { ::inflateEnd(&stream_); }

  std::size_t read(char* to, std::size_t n) override {
    const auto room = static_cast<uInt>(std::min<std::size_t>(n, std::size_t{1} << 30));
    stream_.next_out = reinterpret_cast<Byte*>(to);
    stream_.avail_out = room;
    while (stream_.avail_out == room) {
      if (between_members_ && !next_member()) return 0;
      inflate_some();
    }
    return room - stream_.avail_out;
  }

  void restart() override {
    input_.restart();
    ::inflateReset(&stream_);
    between_members_ = true;
    padding_ = false;
  }

 private:
  // Deflate makes at most 1032 bytes of one.
  static constexpr std::uint64_t kRatio = 1040;

  /// Passes over padding of zeros, as tapes have it; false at the end of the file.
  bool next_member() {
    for (;;) {
      const std::string_view ahead = input_.ahead();
      if (ahead.empty()) return false;
      const std::size_t zeros = std::min(ahead.find_first_not_of('\0'), ahead.size());
      padding_ = padding_ || zeros > 0;
      input_.consume(zeros);
      if (zeros == ahead.size()) continue;
      if (padding_ || ahead[zeros] != '\x1f')
        input_.fail("expected the end of the gzip file or another member, found other data");
      between_members_ = false;
      return true;
    }
  }

  void inflate_some() {
    const std::string_view ahead = input_.ahead();
    if (ahead.empty()) input_.fail("the gzip data ends too early: the file is cut off");
    stream_.next_in = reinterpret_cast<Byte*>(const_cast<char*>(ahead.data()));
    stream_.avail_in = static_cast<uInt>(ahead.size());
    const int code = ::inflate(&stream_, Z_NO_FLUSH);
    input_.consume(ahead.size() - stream_.avail_in);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    if (code == Z_STREAM_END) {
      ::inflateReset(&stream_);
      between_members_ = true;
    } else if (code != Z_OK) {
      input_.fail(fmt::format("the gzip data is damaged: {}",
                              stream_.msg != nullptr ? stream_.msg : "unexpected data"));
    }
  }

  z_stream stream_ = {};
  bool between_members_ = true;
  bool padding_ = false;
};

class Zstd final : public OneFile {
 public:
  Zstd(const InputFile& file, std::uint64_t window, Reservation reservation)
      : OneFile(file, kRatio), reservation_(std::move(reservation)), stream_(::ZSTD_createDCtx()) {
    if (stream_ == nullptr) throw std::bad_alloc();
    const int log = std::max(static_cast<int>(std::bit_width(window - 1)), 10);
    ::ZSTD_DCtx_setParameter(stream_.get(), ZSTD_d_windowLogMax, log);
  }

  std::size_t read(char* to, std::size_t n) override {
    ZSTD_outBuffer out = {to, n, 0};
    while (out.pos == 0) {
      const std::string_view ahead = input_.ahead();
      if (ahead.empty() && frame_ended_) return 0;
      ZSTD_inBuffer in = {ahead.data(), ahead.size(), 0};
      const std::size_t hint = ::ZSTD_decompressStream(stream_.get(), &out, &in);
      if (::ZSTD_isError(hint)) fail(hint);
      input_.consume(in.pos);
      frame_ended_ = hint == 0;
      if (ahead.empty() && out.pos == 0 && !frame_ended_)
        input_.fail("the Zstandard data ends too early: the file is cut off");
    }
    return out.pos;
  }

  void restart() override {
    input_.restart();
    ::ZSTD_DCtx_reset(stream_.get(), ZSTD_reset_session_only);
    frame_ended_ = true;
  }

 private:
  // A block of 4 bytes makes at most 128 KiB.
  static constexpr std::uint64_t kRatio = 40'000;

  [[noreturn]] void fail(std::size_t code) const {
    if (::ZSTD_getErrorCode(code) == ZSTD_error_frameParameter_windowTooLarge) {
      input_.fail("a Zstandard frame with a larger window than the first; compress it anew");
    }
    input_.fail(fmt::format("the Zstandard data is damaged: {}", ::ZSTD_getErrorName(code)));
  }

  struct Free {
    void operator()(ZSTD_DCtx* stream) const { ::ZSTD_freeDCtx(stream); }
  };
  Reservation reservation_;
  std::unique_ptr<ZSTD_DCtx, Free> stream_;
  bool frame_ended_ = true;
};

/// What a decoder must remember for the first frame: RFC 8878, 3.1.1.1.
std::uint64_t zstd_window(std::string_view head, bool skippable) {
  constexpr std::uint64_t kUsual = std::uint64_t{8} << 20;
  if (skippable || head.size() < 6) return kUsual;
  if ((static_cast<Byte>(head[4]) & 0x20) != 0) {
    const unsigned long long size = ::ZSTD_getFrameContentSize(head.data(), head.size());
    const bool known = size != ZSTD_CONTENTSIZE_UNKNOWN && size != ZSTD_CONTENTSIZE_ERROR;
    return known ? std::max<std::uint64_t>(size, 1024) : kUsual;
  }
  const auto code = static_cast<Byte>(head[5]);
  const std::uint64_t base = std::uint64_t{1} << (10 + (code >> 3));
  return base + base / 8 * (code & 7);
}

std::unique_ptr<Decompressor> make_zstd(const InputFile& file, std::string_view head,
                                        bool skippable, MemoryBudget* budget) {
  constexpr std::uint64_t kMostUnasked = std::uint64_t{128} << 20;
  constexpr std::uint64_t kMost = std::uint64_t{1} << 31;  // of the library
  constexpr std::uint64_t kSmall = std::uint64_t{1} << 20;
  const std::uint64_t window = zstd_window(head, skippable);
  if (window > kMost || (budget == nullptr && window > kMostUnasked)) {
    throw InputError(fmt::format(
        "{}: byte 4: this Zstandard data needs a window of {} MiB, the most is {} MiB; compress it "
        "anew",
        file.path().string(), window >> 20, (budget == nullptr ? kMostUnasked : kMost) >> 20));
  }
  Reservation reservation;
  if (budget != nullptr && window > kSmall) {
    reservation = budget->reserve(
        window, fmt::format("the Zstandard window of {}", file.path().filename().string()));
  }
  return std::make_unique<Zstd>(file, window, std::move(reservation));
}

}  // namespace

std::unique_ptr<Decompressor> make_decompressor(const InputFile& file, MemoryBudget* budget) {
  std::array<char, 18> bytes{};  // the longest header of a Zstandard frame
  const std::string_view head(bytes.data(), file.read_at(bytes.data(), bytes.size(), 0));
  if (head.starts_with("\x1f\x8b\x08")) return std::make_unique<Gzip>(file);
  if (head.starts_with("\x28\xb5\x2f\xfd")) return make_zstd(file, head, false, budget);
  if (head.size() >= 4 && head.substr(1, 3) == "\x2a\x4d\x18" &&
      (static_cast<Byte>(head[0]) & 0xF0) == 0x50) {
    return make_zstd(file, head, true, budget);
  }
  return nullptr;
}

}  // namespace remaps
