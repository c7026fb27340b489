#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace remaps {

/// A binary STL: 80 bytes of anything, the number of triangles (u4), then of each a normal and
/// three corners (f4 each) and two bytes of anything. Little-endian.
inline constexpr std::size_t kStlCount = 80;
inline constexpr std::size_t kStlHeader = 84;
inline constexpr std::size_t kStlNormal = 12;
inline constexpr std::size_t kStlTriangle = 50;

inline std::uint64_t stl_triangle_count(const char* header) {
  std::uint32_t count = 0;
  std::memcpy(&count, header + kStlCount, sizeof count);
  return count;
}

}  // namespace remaps
