#include "remaps/formats/ply_runs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

#include "remaps/formats/position_value.h"

namespace remaps {
namespace {

template <std::size_t kBytes>
using Word = std::conditional_t<kBytes == 4, std::uint32_t, std::uint64_t>;

/// Loads as raw words, so that a NaN's bits and byte order are dealt with before it is a number.
template <class T, bool kSwap>
std::array<Word<sizeof(T)>, 3> load_words(const char* from) {
  std::array<Word<sizeof(T)>, 3> words;
  std::memcpy(words.data(), from, sizeof words);
  if constexpr (kSwap) {
    for (auto& word : words) {
      if constexpr (sizeof(T) == 4) {
        word = __builtin_bswap32(word);
      } else {
        word = __builtin_bswap64(word);
      }
    }
  }
  return words;
}

/// 1 for NaN, the infinities and what is beyond the floats, else 0. But for the sign, words are in
/// the order of their numbers, and those of NaN above all.
template <class Real>
unsigned is_not_finite(Word<sizeof(Real)> word) {
  using W = Word<sizeof(Real)>;
  constexpr Real kLeast =
      sizeof(Real) == 4 ? std::numeric_limits<Real>::infinity() : static_cast<Real>(kBeyondFloat);
  constexpr W kSign = W{1} << (8 * sizeof(Real) - 1);
  return unsigned{(word & static_cast<W>(~kSign)) >= std::bit_cast<W>(kLeast)};
}

template <class Real, bool kSwap>
PlyPointRuns::Decoded decode_points(const char* at, std::size_t stride, std::span<Vec3> out) {
  PlyPointRuns::Decoded done{0, true};
  for (Vec3& point : out) {
    const auto words = load_words<Real, kSwap>(at);
    const unsigned bad = is_not_finite<Real>(words[0]) | is_not_finite<Real>(words[1]) |
                         is_not_finite<Real>(words[2]);
    if (bad != 0) break;
    point = {static_cast<double>(std::bit_cast<Real>(words[0])),
             static_cast<double>(std::bit_cast<Real>(words[1])),
             static_cast<double>(std::bit_cast<Real>(words[2]))};
    if constexpr (std::is_same_v<Real, double>) {
      done.all_float &= is_float(point.x) && is_float(point.y) && is_float(point.z);
    }
    at += stride;
    ++done.records;
  }
  return done;
}

/// A negative index is sign-extended: it is above any valid one.
template <class Index>
std::uint64_t to_index(Word<sizeof(Index)> word) {
  return static_cast<std::uint64_t>(
      static_cast<std::conditional_t<std::is_signed_v<Index>, std::int64_t, std::uint64_t>>(
          static_cast<Index>(word)));
}

template <class Index, bool kSwap>
std::size_t decode_triangles(const char* at, std::size_t stride, std::uint64_t vertices,
                             std::span<Triangle> out) {
  std::size_t done = 0;
  for (Triangle& triangle : out) {
    const auto words = load_words<Index, kSwap>(at + 1);
    const std::uint64_t a = to_index<Index>(words[0]);
    const std::uint64_t b = to_index<Index>(words[1]);
    const std::uint64_t c = to_index<Index>(words[2]);
    if (*at != 3 || std::max({a, b, c}) >= vertices) break;
    triangle = {a, b, c};
    at += stride;
    ++done;
  }
  return done;
}

/// Whole records in `bytes`, at most `room`.
std::size_t whole_records(std::string_view bytes, std::size_t stride, std::size_t room) {
  return std::min(bytes.size() / stride, room);
}

}  // namespace

std::optional<PlyPointRuns> PlyPointRuns::of(const PlyElement& element, bool big_endian) {
  std::size_t stride = 0;
  std::optional<std::size_t> offset;
  PlyType type = PlyType::float32;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty* const property = &element.properties[i];
    if (property->count_type) return std::nullopt;
    if (property == element.find("x")) {
      const bool follow = i + 2 < element.properties.size() && property + 1 == element.find("y") &&
                          property + 2 == element.find("z");
      if (!follow || property[1].type != property->type || property[2].type != property->type) {
        return std::nullopt;
      }
      offset = stride;
      type = property->type;
    }
    stride += size_of(property->type);
  }
  if (!offset || is_integer(type)) return std::nullopt;
  if (type == PlyType::float32) {
    return PlyPointRuns(stride, *offset,
                        big_endian ? decode_points<float, true> : decode_points<float, false>);
  }
  return PlyPointRuns(stride, *offset,
                      big_endian ? decode_points<double, true> : decode_points<double, false>);
}

PlyPointRuns::Decoded PlyPointRuns::decode(std::string_view bytes, std::span<Vec3> out) const {
  return decode_(bytes.data() + offset_, stride_,
                 out.first(whole_records(bytes, stride_, out.size())));
}

std::optional<PlyTriangleRuns> PlyTriangleRuns::of(const PlyElement& element,
                                                   const PlyProperty& corners, bool big_endian) {
  std::size_t stride = 1;
  std::size_t offset = 0;
  for (const PlyProperty& property : element.properties) {
    if (&property == &corners) {
      offset = stride - 1;
      stride += 3 * size_of(property.type);
    } else {
      if (property.count_type) return std::nullopt;
      stride += size_of(property.type);
    }
  }
  if (!corners.count_type || size_of(*corners.count_type) != 1) return std::nullopt;
  const auto runs = [&](Decode decode, Decode decode_swapped) {
    return PlyTriangleRuns(stride, offset, big_endian ? decode_swapped : decode);
  };
  switch (corners.type) {
    case PlyType::int32:
      return runs(decode_triangles<std::int32_t, false>, decode_triangles<std::int32_t, true>);
    case PlyType::uint32:
      return runs(decode_triangles<std::uint32_t, false>, decode_triangles<std::uint32_t, true>);
    case PlyType::int64:
      return runs(decode_triangles<std::int64_t, false>, decode_triangles<std::int64_t, true>);
    case PlyType::uint64:
      return runs(decode_triangles<std::uint64_t, false>, decode_triangles<std::uint64_t, true>);
    default:
      return std::nullopt;
  }
}

std::size_t PlyTriangleRuns::decode(std::string_view bytes, std::uint64_t vertices,
                                    std::span<Triangle> out) const {
  return decode_(bytes.data() + offset_, stride_, vertices,
                 out.first(whole_records(bytes, stride_, out.size())));
}

}  // namespace remaps
