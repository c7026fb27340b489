#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/store/packing.h"

namespace remaps::codec {

/// Quantized coefficients: a magnitude and a sign for each component of each vertex. Component 0
/// lies along the normal.
struct Coefficients {
  std::vector<std::array<std::uint32_t, 3>> magnitude;  ///< (vertices)
  std::vector<std::uint8_t> negative;                   ///< (vertices) bit i: of component i
  std::vector<std::array<std::uint8_t, 3>> plane;       ///< (vertices) the lowest bit that is known

  void resize(std::size_t vertices) {
    magnitude.assign(vertices, {});
    negative.assign(vertices, 0);
    plane.assign(vertices, {});
  }
};

/// Codes coefficients bit plane by bit plane, all of them from the highest plane down, in each
/// plane from coarse to fine; every prefix of the code is a code of coarser coefficients.
///
/// A coefficient is that of a vertex, and the vertices of a level lie on the edges of the coarser
/// one. So they form the zerotrees of Khodakovsky, Schröder, Sweldens (Progressive Geometry
/// Compression, SIGGRAPH 2000): the children of an edge are its halves and the edges parallel to it
/// in its faces. Once a plane a tree without significant coefficients costs one bit, or much less
/// where the neighbourhood tells. The normal components have trees of their own, the two tangential
/// ones have them in common.
///
/// @param planes  bits of the largest magnitude, at most 30
store::Bytes encode_coefficients(const SubdivisionHierarchy& hierarchy,
                                 const Coefficients& coefficients, unsigned planes);

/// The inverse, for as much of the code as is there.
/// @param coefficients  all insignificant where the code does not reach
void decode_coefficients(const SubdivisionHierarchy& hierarchy, store::ByteSpan code,
                         unsigned planes, Coefficients& coefficients);

}  // namespace remaps::codec
