#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/store/packing.h"

namespace remaps::codec {

/// A base mesh with positions on an integer grid.
struct GridBase {
  std::vector<std::array<std::int32_t, 3>> position;  ///< (v)
  std::vector<Face> face;                             ///< (f)
};

/// What finding the order, encoding and decoding take on the way, each. Most are hash tables.
inline constexpr std::uint64_t kBaseCodeBytesPerFace = 288;

/// The order in which a base is coded and decoded.
struct BaseOrder {
  std::vector<std::uint32_t> vertex;   ///< (v) new numbers
  std::vector<std::uint32_t> face;     ///< (f) new numbers
  std::vector<std::uint8_t> rotation;  ///< (f) corner k becomes corner (k + rotation) mod 3
};

/// Finds the order: faces grow from one to the next across their edges, vertices are numbered as
/// they are met.
/// @throws GeometryError  the base is not an oriented manifold
BaseOrder order_base(std::uint32_t vertices, std::span<const Face> faces);

/// Codes a base that is in its order: for each face that is next whether its third vertex is new,
/// and for each new vertex the difference from what the face beside it predicts. Faces and edges
/// themselves need no number. Any orientable manifold, with or without boundary, of any genus and
/// number of components.
/// Source: the gates of Touma, Gotsman, Triangle Mesh Compression (Graphics Interface 98), and
/// their parallelogram; differs: adaptive contexts instead of runs of valences, a vertex that
/// closes a handle by its number.
store::Bytes encode_base(const GridBase& base);

/// The inverse.
/// @param vertices, faces  as many as were coded
/// @throws GeometryError  the code is no base of so many vertices and faces
GridBase decode_base(store::ByteSpan code, std::uint32_t vertices, std::uint32_t faces);

}  // namespace remaps::codec
