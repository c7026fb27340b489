#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "remaps/base/errors.h"

namespace remaps::store {

static_assert(std::endian::native == std::endian::little,
              "files are little-endian, and so must the machine be");

using Bytes = std::vector<std::byte>;
using ByteSpan = std::span<const std::byte>;

/// Ids in files take 40 bits: a million million vertices or faces.
inline constexpr std::uint64_t kMaxId40 = (std::uint64_t{1} << 40) - 1;

/// Appends little-endian values to a growing buffer.
class Packer {
 public:
  explicit Packer(Bytes& out) : out_(out) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { append(&value, sizeof value); }
  void put40(std::uint64_t id) { append(&id, 5); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put_array(std::span<const T> values) { append(values.data(), values.size_bytes()); }
  /// Unsigned LEB128.
  void put_varint(std::uint64_t value) {
    while (value >= 128) {
      out_.push_back(static_cast<std::byte>(value | 128));
      value >>= 7;
    }
    out_.push_back(static_cast<std::byte>(value));
  }
  /// Small for values near 0 of either sign.
  void put_signed(std::int64_t value) {
    put_varint((static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
  }

 private:
  void append(const void* data, std::size_t size) {
    const std::size_t at = out_.size();
    out_.resize(at + size);
    if (size > 0) std::memcpy(out_.data() + at, data, size);
  }

  Bytes& out_;
};

/// Reads what a Packer wrote; every read is checked against what is left.
/// @throws CorruptionError  from any get, when the bytes end too early; names `what`
class Unpacker {
 public:
  Unpacker(ByteSpan bytes, std::string_view what) : bytes_(bytes), what_(what) {}

  bool done() const { return at_ == bytes_.size(); }
  std::size_t left() const { return bytes_.size() - at_; }

  template <class T>
  requires std::is_trivially_copyable_v<T> T get() {
    T value;
    take(&value, sizeof value);
    return value;
  }
  std::uint64_t get40() {
    std::uint64_t id = 0;
    take(&id, 5);
    return id;
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get_array(std::span<T> values) { take(values.data(), values.size_bytes()); }
  /// Resizes to `count` elements and fills them; the count is checked before memory is taken.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get_vector(std::uint64_t count, std::vector<T>& values) {
    if (count > left() / sizeof(T)) fail();
    values.resize(static_cast<std::size_t>(count));
    get_array(std::span<T>(values));
  }
  std::uint64_t get_varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto byte = static_cast<std::uint64_t>(get<std::byte>());
      value |= (byte & 127) << shift;
      if (byte < 128) return value;
    }
    fail();
  }
  std::int64_t get_signed() {
    const std::uint64_t value = get_varint();
    return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
  }

 private:
  [[noreturn]] void fail() const {
    throw CorruptionError(what_ + ": data ends at byte " + std::to_string(bytes_.size()) +
                          " but more was expected");
  }
  void take(void* data, std::size_t size) {
    if (size > left()) fail();
    if (size > 0) std::memcpy(data, bytes_.data() + at_, size);
    at_ += size;
  }

  ByteSpan bytes_;
  std::string what_;
  std::size_t at_ = 0;
};

}  // namespace remaps::store
