#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "remaps/formats/gltf_buffers.h"

namespace remaps {

enum class GltfComponent { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };

std::size_t size_of(GltfComponent component);

/// Elements at equal distances in a buffer, which has them all.
struct GltfArray {
  std::size_t buffer = 0;
  std::uint64_t begin = 0, stride = 0;
};

/// A typed array of a glTF file, checked against its buffers. Some elements may be replaced.
struct GltfAccessor {
  /// Elements that are replaced: their numbers, in order, and what they become.
  struct Sparse {
    std::uint64_t count = 0;
    GltfComponent index_type = GltfComponent::u32;
    GltfArray indices, values;
  };

  std::string place;  ///< "accessors[3]", for messages
  GltfComponent component = GltfComponent::f32;
  bool normalized = false;
  std::size_t components = 1;  ///< of an element
  std::uint64_t count = 0;
  GltfArray base;
  std::optional<Sparse> sparse;

  std::size_t element_bytes() const { return components * size_of(component); }
};

/// Reads accessors, checks them, and opens the buffers that they use.
class GltfAccessorReader {
 public:
  explicit GltfAccessorReader(GltfFile& file) : file_(file) {}

  /// @param type  "SCALAR" or "VEC2" to "VEC4": others are refused
  /// @throws InputError  names the offending value and what was expected
  GltfAccessor read(const GltfValue& accessor, std::string_view type);

  /// The buffers that were used so far.
  std::vector<GltfBuffer>& buffers() { return buffers_; }

 private:
  struct View {
    std::size_t buffer;
    std::uint64_t begin, bytes, stride;
  };

  std::size_t open(const GltfValue& buffer);
  View read_view(const GltfValue& view);
  GltfArray read_array(const GltfValue& holder, std::uint64_t count, std::size_t element_bytes);
  GltfAccessor::Sparse read_sparse(const GltfValue& sparse, const GltfAccessor& accessor);

  GltfFile& file_;
  std::vector<GltfBuffer> buffers_;
  std::vector<std::string> places_;  // of buffers_
};

/// One pass over an accessor.
class GltfElements {
 public:
  static constexpr std::size_t kPieceBytes = std::size_t{1} << 18;

  /// @param file         for messages
  /// @param piece_bytes  read at a time, gaps counted
  GltfElements(const std::vector<GltfBuffer>& buffers, const GltfAccessor& accessor,
               const std::filesystem::path& file, std::size_t piece_bytes = kPieceBytes);

  /// The next elements without gaps, some thousand; none at the end. Valid until the next call.
  /// @throws InputError  as GltfBuffer::read; replaced elements out of order or range
  std::span<const char> next();
  /// Number of the first element that next will give.
  std::uint64_t position() const { return next_; }

 private:
  void replace(std::span<char> elements, std::uint64_t first);
  void load_replacements();

  const std::vector<GltfBuffer>& buffers_;
  const GltfAccessor& accessor_;
  const std::filesystem::path& file_;
  std::size_t piece_bytes_;
  std::uint64_t next_ = 0;
  std::vector<char> raw_, packed_;
  // Replacements in memory, and how many were loaded.
  std::uint64_t loaded_ = 0;
  std::size_t at_ = 0;
  std::vector<std::uint64_t> numbers_;
  std::vector<char> values_;
};

/// Reads one unsigned number, as it lies in memory.
std::uint64_t load_index(const char* from, GltfComponent component);

}  // namespace remaps
