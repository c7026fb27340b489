#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/formats/gltf_accessor.h"

namespace remaps {

/// An affine map: three columns and a shift.
struct Affine {
  std::array<Vec3, 3> column{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 shift;

  friend bool operator==(const Affine&, const Affine&) = default;

  Vec3 direction(const Vec3& v) const {
    return v.x * column[0] + v.y * column[1] + v.z * column[2];
  }
  Vec3 point(const Vec3& p) const { return direction(p) + shift; }
  bool is_identity() const { return *this == Affine{}; }
  bool mirrors() const { return dot(cross(column[0], column[1]), column[2]) < 0; }
};

/// First `b`, then `a`.
inline Affine operator*(const Affine& a, const Affine& b) {
  return {{a.direction(b.column[0]), a.direction(b.column[1]), a.direction(b.column[2])},
          a.point(b.shift)};
}

enum class GltfMode { triangles = 4, strip = 5, fan = 6 };

/// What the vertices of a primitive have beside positions: numbers of accessors.
struct GltfAttributes {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// Sets of texture coordinates that are read: TEXCOORD_0 to TEXCOORD_7.
  static constexpr std::size_t kTextures = 8;

  std::uint32_t normal = kNone, colour = kNone;
  std::array<std::uint32_t, kTextures> texture{kNone, kNone, kNone, kNone,
                                               kNone, kNone, kNone, kNone};

  friend auto operator<=>(const GltfAttributes&, const GltfAttributes&) = default;
};

struct GltfPrimitive {
  std::string place;          ///< "meshes[0].primitives[1]", for messages
  std::size_t positions = 0;  ///< number of the accessor
  GltfAttributes attributes;
  std::optional<std::size_t> indices;
  GltfMode mode = GltfMode::triangles;
  std::optional<std::uint64_t> material;
};

/// The triangles of the default scene: what is where in which buffer. Instances of a mesh are
/// listed, not copied.
struct GltfScene {
  struct Part {
    std::uint32_t accessor = 0, transform = 0;
    std::uint32_t primitive = 0;  ///< one whose vertices these are: it has their attributes
    VertexId first = 0;           ///< number of its first vertex in the mesh as a whole
  };
  struct Draw {
    std::uint32_t primitive = 0, transform = 0;
    VertexId first = 0;  ///< number of the vertex that its index 0 means
  };

  std::vector<GltfBuffer> buffers;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfPrimitive> primitives;
  std::vector<Affine> transforms;
  std::vector<Part> parts;
  std::vector<Draw> draws;
  std::uint64_t vertices = 0;
  std::uint64_t corners = 0;  ///< indices that are read, of all draws
  std::vector<std::shared_ptr<const RandomSource>> sources;
};

/// More draws, instances counted, are refused.
inline constexpr std::size_t kMostGltfDraws = std::size_t{1} << 20;

/// Reads the JSON of a .glb or .gltf and checks all that is needed of it against the buffers.
/// @throws InputError  malformed, of a version or with an extension that is not read, no triangles
GltfScene read_gltf_scene(const std::filesystem::path& path);

}  // namespace remaps
