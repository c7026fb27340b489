#include "remaps/formats/ply_cursor.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <string>
#include <utility>

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are read as little-endian");

/// A value as it lies in the file, its bytes reversed if asked.
template <class T>
T load(const char* from, bool swap) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, from, sizeof(T));
  if (swap) {
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  }
  return std::bit_cast<T>(bytes);
}

std::string describe(const PlyPlace& place, std::string_view what) {
  return fmt::format("{} {} of {}: {}", place.element->name, place.record, place.element->count,
                     what);
}

}  // namespace

double PlyBinaryCursor::real(PlyType type) {
  switch (type) {
    case PlyType::float32:
      return static_cast<double>(load<float>(take(sizeof(float)), swap_));
    case PlyType::float64:
      return load<double>(take(sizeof(double)), swap_);
    case PlyType::uint64:
      return static_cast<double>(integer(type));
    default:
      return static_cast<double>(static_cast<std::int64_t>(integer(type)));
  }
}

std::uint64_t PlyBinaryCursor::integer(PlyType type) {
  const char* const at = take(size_of(type));
  switch (type) {
    case PlyType::int8:
      return static_cast<std::uint64_t>(std::int64_t{load<std::int8_t>(at, swap_)});
    case PlyType::uint8:
      return load<std::uint8_t>(at, swap_);
    case PlyType::int16:
      return static_cast<std::uint64_t>(std::int64_t{load<std::int16_t>(at, swap_)});
    case PlyType::uint16:
      return load<std::uint16_t>(at, swap_);
    case PlyType::int32:
      return static_cast<std::uint64_t>(std::int64_t{load<std::int32_t>(at, swap_)});
    case PlyType::uint32:
      return load<std::uint32_t>(at, swap_);
    default:
      return load<std::uint64_t>(at, swap_);
  }
}

void PlyBinaryCursor::skip(std::uint64_t bytes) {
  const std::uint64_t target = source_.offset() + bytes;
  if (bytes > source_.remaining()) fail_at_end();
  source_.skip(bytes);
  if (source_.offset() != target) fail_at_end();
}

void PlyBinaryCursor::expect_list(std::uint64_t n, PlyType type) {
  if (n <= source_.remaining() / size_of(type)) return;
  source_.fail_at_byte(source_.offset(),
                       describe(place, fmt::format("a list of {} values of {} bytes, but {}",
                                                   static_cast<std::int64_t>(n), size_of(type),
                                                   source_.room_text())));
}

void PlyBinaryCursor::fail(PlyType type, std::string_view what) const {
  source_.fail_at_byte(source_.offset() - size_of(type), describe(place, what));
}

void PlyBinaryCursor::fail_at_end() const {
  source_.fail_at_byte(source_.size(), describe(place, "the file ends within this record"));
}

double PlyTextCursor::real(PlyType type) {
  go_to_value(type);
  return type == PlyType::float32 ? static_cast<double>(scanner_.real_float()) : scanner_.real();
}

double PlyTextCursor::coordinate(PlyType type) {
  go_to_value(type);
  return type == PlyType::float32 ? scanner_.float_coordinate() : scanner_.coordinate();
}

std::uint64_t PlyTextCursor::integer(PlyType type) {
  go_to_value(type);
  return static_cast<std::uint64_t>(scanner_.integer());
}

void PlyTextCursor::go_to_value(PlyType type) {
  scanner_.skip_space();
  if (scanner_.at_end()) fail(type, "the file ends within this record");
}

void PlyTextCursor::skip(std::uint64_t values) {
  for (; values > 0; --values) scanner_.skip_word();
}

void PlyTextCursor::expect_list(std::uint64_t n, PlyType type) {
  // A value takes a byte and a separator; the last one of the file only its byte.
  if (n <= (scanner_.source().remaining() + 1) / 2) return;
  fail(type, fmt::format("a list of {} values, but {}", static_cast<std::int64_t>(n),
                         scanner_.source().room_text()));
}

void PlyTextCursor::fail(PlyType, std::string_view what) const {
  scanner_.fail(describe(place, what));
}

}  // namespace remaps
