#include "remaps/codec/signal_code.h"

#include <algorithm>
#include <cmath>

namespace remaps::codec {
namespace {

/// Eyes see differences of colour less sharply than of luminance.
constexpr std::uint8_t kChromaWeight = 128;
constexpr std::uint8_t kSameWeight = 255;

/// Luminance and two differences (Malvar, Sullivan, YCoCg-R, 2003), about the middle grey.
Vec3 to_luminance(const Vec3& rgb) {
  const double orange = rgb.x - rgb.z;
  const double middle = rgb.z + 0.5 * orange;
  const double green = rgb.y - middle;
  return {middle + 0.5 * green - 0.5, orange, green};
}

Vec3 to_rgb(const Vec3& v) {
  const double middle = v.x + 0.5 - 0.5 * v.z;
  const double blue = middle - 0.5 * v.y;
  const auto within = [](double x) { return std::clamp(x, 0.0, 1.0); };
  return {within(blue + v.y), within(v.z + middle), within(blue)};
}

Vec3 unit(const Vec3& v) {
  const double length = norm(v);
  return length > 0 ? 1 / length * v : v;
}

}  // namespace

store::Bytes encode_signal(const SubdivisionHierarchy& hierarchy, Wavelet wavelet, Signal signal,
                           unsigned planes, SignalHeader& header) {
  header.kind = signal.kind;
  Quantization& q = header.quantization;
  q.planes = static_cast<std::uint8_t>(planes);
  q.tangential = signal.kind == SignalKind::kColour ? kChromaWeight : kSameWeight;
  // Of values from -1 to 1. Details may be larger, by the sum of a stencil's weights.
  q.step = std::ldexp(1.0, 1 - static_cast<int>(planes));
  std::vector<Vec3>& values = signal.value;
  if (signal.kind == SignalKind::kColour) {
    for (Vec3& v : values) v = to_luminance(v);
  }
  const WaveletTransform transform(hierarchy, wavelet);
  for (unsigned j = hierarchy.levels(); j-- > 0;) transform.analyse(j, values);
  Coefficients coefficients;
  quantize(hierarchy, q, values, coefficients);
  values = {};
  store::Bytes code = encode_coefficients(hierarchy, coefficients, planes);
  header.bytes = narrow<std::uint32_t>(code.size());
  return code;
}

Signal decode_signal(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                     const SignalHeader& header, store::ByteSpan code, unsigned level) {
  Signal signal;
  signal.kind = header.kind;
  Coefficients coefficients;
  decode_coefficients(hierarchy, code, header.quantization.planes, coefficients);
  signal.value = dequantize(hierarchy, header.quantization, level, coefficients);
  coefficients = {};
  const WaveletTransform transform(hierarchy, wavelet);
  for (unsigned j = 0; j < level; ++j) transform.synthesise(j, signal.value);
  for (Vec3& v : signal.value) v = signal.kind == SignalKind::kColour ? to_rgb(v) : unit(v);
  return signal;
}

}  // namespace remaps::codec
