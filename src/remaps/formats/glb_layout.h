#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/formats/attribute_field.h"

namespace remaps {

/// Sets of texture coordinates that are written.
inline constexpr std::size_t kMostGlbTextures = 8;

/// How a vertex lies in the buffer of a GLB: its position and, behind each other, what it has
/// beside. Texture coordinates of corners come last, all floats.
class GlbLayout {
 public:
  explicit GlbLayout(std::span<const AttributeSpec> specs);

  std::size_t stride() const { return stride_; }
  /// Sets of texture coordinates that corners have.
  std::size_t corner_sets() const { return corner_fields_.size(); }
  /// Where they begin in a vertex.
  std::size_t corners_at() const { return stride_ - corner_sets() * 2 * sizeof(float); }

  /// Puts what a row of vertices has into a vertex, behind the position. Normals get length 1, one
  /// without direction becomes (0, 0, 1): glTF has no other.
  void put(std::span<const std::byte> row, std::byte* vertex) const;
  /// Two numbers for each set, from a row of corners.
  void read_corner(std::span<const std::byte> row, std::span<float> values) const;

  /// Room that the JSON has.
  std::size_t json_bytes() const { return 1024 + 256 * fields_.size(); }
  struct Mesh {
    std::uint64_t vertices = 0, faces = 0;
    Box3 box;
    bool faces_first = false;  ///< the indices lie before the vertices in the buffer
  };
  /// One mesh in one node, padded to json_bytes.
  std::string json(const Mesh& mesh) const;

 private:
  struct Field {
    std::string name;
    unsigned component = 0;  ///< componentType
    std::size_t numbers = 0;
    std::size_t at = 0;  ///< in a vertex
  };
  struct Source {
    AttributeField field;
    std::size_t to = 0;  ///< number in fields_
  };

  void add(std::string name, unsigned component, std::size_t numbers);

  std::vector<Field> fields_;
  std::vector<Source> sources_;  // of vertices
  std::vector<AttributeField> corner_fields_;
  std::size_t stride_ = sizeof(Vec3f);
};

}  // namespace remaps
