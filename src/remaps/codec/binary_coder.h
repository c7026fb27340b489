#pragma once

#include <cstddef>
#include <cstdint>

#include "remaps/store/packing.h"

namespace remaps::codec {

/// Binary arithmetic coding with probabilities of 16 bits, a byte at a time, without carries
/// (after Mahoney's lpaq): an interval of 32 bits, whose leading bytes go out when both ends agree
/// on them. Integers only: the same on every machine.
///
/// Encoder and decoder have the same `code`, so that one function serves both ways.
class BinaryEncoder {
 public:
  static constexpr bool kDecodes = false;

  explicit BinaryEncoder(store::Bytes& out) : out_(out) {}

  /// @param one  probability of a 1, of 2^16; 1 to 2^16 - 1
  bool code(bool bit, std::uint32_t one) {
    const std::uint32_t middle =
        low_ + static_cast<std::uint32_t>((std::uint64_t{high_ - low_} * one) >> 16);
    if (bit) {
      high_ = middle;
    } else {
      low_ = middle + 1;
    }
    while (((low_ ^ high_) >> 24) == 0) {
      out_.push_back(static_cast<std::byte>(high_ >> 24));
      low_ <<= 8;
      high_ = high_ << 8 | 0xFF;
    }
    return bit;
  }
  bool ended() const { return false; }
  /// Writes what the decoder looks ahead.
  void finish() {
    for (unsigned shift = 32; shift != 0; shift -= 8) {
      out_.push_back(static_cast<std::byte>(low_ >> (shift - 8)));
    }
  }

 private:
  store::Bytes& out_;
  std::uint32_t low_ = 0, high_ = 0xFFFFFFFF;
};

/// Decodes as long as all bytes that a bit depends on are there: a prefix gives a prefix of the
/// bits.
class BinaryDecoder {
 public:
  static constexpr bool kDecodes = true;

  explicit BinaryDecoder(store::ByteSpan in) : in_(in) {
    for (unsigned i = 0; i < 4; ++i) value_ = value_ << 8 | next();
  }

  bool code(bool, std::uint32_t one) {
    while (((low_ ^ high_) >> 24) == 0) {
      low_ <<= 8;
      high_ = high_ << 8 | 0xFF;
      value_ = value_ << 8 | next();
    }
    const std::uint32_t middle =
        low_ + static_cast<std::uint32_t>((std::uint64_t{high_ - low_} * one) >> 16);
    const bool bit = value_ <= middle;
    if (bit) {
      high_ = middle;
    } else {
      low_ = middle + 1;
    }
    return bit;
  }
  /// Whether the last bit was made up, for want of bytes.
  bool ended() const { return ended_; }

 private:
  std::uint32_t next() {
    if (at_ == in_.size()) {
      ended_ = true;
      return 0;
    }
    return static_cast<std::uint32_t>(in_[at_++]);
  }

  store::ByteSpan in_;
  std::size_t at_ = 0;
  bool ended_ = false;
  std::uint32_t value_ = 0, low_ = 0, high_ = 0xFFFFFFFF;
};

}  // namespace remaps::codec
