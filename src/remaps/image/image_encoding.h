#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace remaps::image {

/// Pixels of three numbers, rows from top to bottom.
struct Image {
  std::uint32_t width = 0, height = 0;
  std::vector<float> value;  ///< (height, width, 3)
  /// Channels by name, as EXR calls them: R, G, B, or X, Y, Z of vectors.
  std::string_view channels = "XYZ";
};

/// How numbers become integers: value = low + n / (2^bits - 1) * range.
struct IntegerRange {
  unsigned bits = 16;  ///< 8 or 16
  float low[3] = {0, 0, 0};
  float range = 1;
};

/// A PNG. Numbers outside the range become its ends. The range is in the file, as text chunks
/// `remaps:low` (three numbers) and `remaps:range`.
std::string encode_png(const Image& image, const IntegerRange& range);
/// A scan-line OpenEXR of three float channels, ZIP compressed.
std::string encode_exr(const Image& image);
/// A NumPy array of little-endian floats, shape (height, width, 3).
std::string encode_npy(const Image& image);

}  // namespace remaps::image
