#pragma once

#include "remaps/codec/geometry_code.h"
#include "remaps/codec/semi_regular_mesh.h"
#include "remaps/store/packing.h"

namespace remaps::codec {

/// How a signal is coded.
struct SignalHeader {
  SignalKind kind = SignalKind::kColour;
  Quantization quantization;
  std::uint32_t bytes = 0;  ///< of the code
};

/// Codes a signal with the wavelets and bit planes of the geometry, but without frames: colours as
/// a luminance, component 0, and two differences; normals as vectors.
///
/// @param signal  its values are used up
/// @param planes  1 to 30, of which 8 are what a colour of 8 bits has
store::Bytes encode_signal(const SubdivisionHierarchy& hierarchy, Wavelet wavelet, Signal signal,
                           unsigned planes, SignalHeader& header);

/// The inverse, for as much of the code as is there, up to a level.
Signal decode_signal(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                     const SignalHeader& header, store::ByteSpan code, unsigned level);

}  // namespace remaps::codec
