#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "remaps/formats/byte_source.h"

namespace remaps {

enum class PlyEncoding { ascii, little_endian, big_endian };

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// Bytes of a value in a binary file.
constexpr std::size_t size_of(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}
constexpr bool is_integer(PlyType type) {
  return type < PlyType::float32;
}
/// True when every value of the type is a float.
constexpr bool fits_float(PlyType type) {
  return type < PlyType::int32 || type == PlyType::float32;
}

struct PlyProperty {
  std::string name;
  PlyType type;                       // of the value, or of a list's items
  std::optional<PlyType> count_type;  // set for a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count;
  std::vector<PlyProperty> properties;

  /// The property of one of these names, nullptr if there is none.
  const PlyProperty* find(std::string_view name, std::string_view other_name = {}) const;
};

struct PlyHeader {
  PlyEncoding encoding;
  std::vector<PlyElement> elements;
  std::uint64_t data_offset;

  /// nullptr if there is none.
  const PlyElement* find(std::string_view name) const;
};

/// Reads a PLY header and leaves the source behind it. Lines end in LF, CR LF or (old files) CR, as
/// the first one does. The counts are checked: the elements announced, at their least size, fit the
/// file.
///
/// @throws InputError  naming the line of the header
PlyHeader read_ply_header(ByteSource& source);

}  // namespace remaps
