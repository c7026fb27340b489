#pragma once

#include <cstdint>
#include <span>

#include "codec/codec_shapes.h"
#include "remaps/codec/archive.h"

namespace remaps::test {

/// What tests of the codec may use.
inline constexpr std::uint64_t kCodecMemory = 64u << 20;

/// A base subdivided smoothly, with details that become smaller with the level.
/// @param roughness  details of the first level as a part of the diagonal
codec::SemiRegularMesh rough_mesh(const CodecBase& base, unsigned levels, double roughness,
                                  std::uint64_t seed);
/// Colours that vary over the mesh, and unit vectors.
void add_signals(codec::SemiRegularMesh& mesh);

store::Bytes encode(const codec::SemiRegularMesh& mesh, const codec::EncodeOptions& options = {});
/// Decodes a prefix at the finest level.
codec::SemiRegularMesh decode(store::ByteSpan bytes, std::uint64_t prefix);
inline codec::SemiRegularMesh decode(store::ByteSpan bytes) {
  return decode(bytes, bytes.size());
}

double diagonal_of(const codec::SemiRegularMesh& mesh);
/// The largest distance of two positions with the same number.
double largest_distance(const codec::SemiRegularMesh& a, const codec::SemiRegularMesh& b);
bool is_finite(std::span<const Vec3> values);

}  // namespace remaps::test
