#include "remaps/codec/bit_predictor.h"

namespace remaps::codec {

// The tables are made with the four rules of arithmetic only, which are the same everywhere, since
// decoders must agree on every entry. The C library's exponentials are not.
Logistic::Logistic() {
  constexpr double kStepUp = 1.0039138893383475;  // e^(1/256)
  double power = 1;                               // e^(x/256)
  for (int x = 0; x <= 2047; ++x, power *= kStepUp) {
    const auto of = [](double share) {
      return static_cast<std::uint16_t>(std::clamp(share * 65536, 1.0, 65535.0));
    };
    squash_[static_cast<std::size_t>(2047 + x)] = of(power / (1 + power));
    squash_[static_cast<std::size_t>(2047 - x)] = of(1 / (1 + power));
  }
  int x = -2047;
  for (std::uint32_t i = 0; i < 4096; ++i) {
    while (x < 2047 && squash16(x) < 16 * i + 8) ++x;
    stretch_[i] = static_cast<std::int16_t>(x);
  }
}

const Logistic& Logistic::tables() {
  static const Logistic logistic;
  return logistic;
}

const std::array<std::uint32_t, AdaptiveBit::kSlowest + 1> AdaptiveBit::kStep = [] {
  std::array<std::uint32_t, kSlowest + 1> step{};
  for (std::uint32_t n = 0; n <= kSlowest; ++n) step[n] = (2 << 16) / (2 * n + 3);
  return step;
}();

}  // namespace remaps::codec
