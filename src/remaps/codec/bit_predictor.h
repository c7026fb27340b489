#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace remaps::codec {

/// Logistic function and its inverse between probabilities of 12 bits and their logits, which have
/// 8 bits after the point and lie in [-2047, 2047].
class Logistic {
 public:
  static const Logistic& tables();
  int stretch(std::uint32_t probability16) const { return stretch_[probability16 >> 4]; }
  /// @return  1 to 2^16 - 1
  std::uint32_t squash16(std::int64_t logit) const {
    return squash_[static_cast<std::size_t>(std::clamp<std::int64_t>(logit, -2047, 2047) + 2047)];
  }

 private:
  Logistic();
  std::array<std::int16_t, 4096> stretch_;
  std::array<std::uint16_t, 4095> squash_;
};

/// Probability of a 1 in one context, learned from what came: fast at first, then slower.
class AdaptiveBit {
 public:
  std::uint32_t probability16() const { return state_ >> 16; }
  void learn(bool bit) {
    const std::uint32_t count = state_ & 0xFF, p = state_ >> 8;
    const std::uint32_t step = kStep[count];
    const std::uint32_t next =
        bit ? p + static_cast<std::uint32_t>((std::uint64_t{0xFFFFFF - p} * step) >> 16)
            : p - static_cast<std::uint32_t>((std::uint64_t{p} * step) >> 16);
    state_ = next << 8 | std::min(count + 1, kSlowest);
  }

 private:
  static constexpr std::uint32_t kSlowest = 120;
  static const std::array<std::uint32_t, kSlowest + 1> kStep;  // 2^16 / (count + 1.5)

  std::uint32_t state_ = 0x80000000u;  // 24 bits of probability, 8 of count
};

/// Several contexts' opinions on one bit, mixed in the logistic domain with weights that learn
/// (Mahoney, Adaptive Weighing of Context Models for Lossless Data Compression, 2005).
template <std::size_t Inputs>
class MixedBit {
 public:
  /// @param contexts  (Inputs) number of contexts of each
  /// @param sets      number of sets of weights
  MixedBit(const std::array<std::size_t, Inputs>& contexts, std::size_t sets) : weights_(sets) {
    for (std::size_t i = 0; i < Inputs; ++i) bits_[i].resize(contexts[i]);
    for (auto& w : weights_) w.fill(kFirst);
  }

  template <class Coder>
  bool code(Coder& coder, bool bit, const std::array<std::size_t, Inputs>& context,
            std::size_t set) {
    const Logistic& logistic = Logistic::tables();
    auto& weight = weights_[set];
    std::array<int, Inputs> logit;
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < Inputs; ++i) {
      logit[i] = logistic.stretch(bits_[i][context[i]].probability16());
      sum += weight[i] * logit[i];
    }
    const std::uint32_t p = logistic.squash16(sum >> 16);
    bit = coder.code(bit, p);
    if (Coder::kDecodes && coder.ended()) return false;
    const int error = (bit ? 65535 : 0) - static_cast<int>(p);
    for (std::size_t i = 0; i < Inputs; ++i) {
      weight[i] += (logit[i] * error + (1 << (kRate - 1))) >> kRate;
      bits_[i][context[i]].learn(bit);
    }
    return bit;
  }

 private:
  static constexpr std::int32_t kOne = 1 << 16;
  /// A little more than an average: contexts that agree make each other surer.
  static constexpr std::int32_t kFirst = Inputs == 1 ? kOne : kOne * 5 / (4 * std::int32_t{Inputs});
  static constexpr int kRate = 15;

  std::array<std::vector<AdaptiveBit>, Inputs> bits_;
  std::vector<std::array<std::int64_t, Inputs>>
      weights_;  // that no code is long enough to overflow
};

}  // namespace remaps::codec
