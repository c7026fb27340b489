#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "remaps/base/geometry.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {

/// True when storing the value as a float loses nothing.
inline bool is_float(double value) {
  return std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max()) &&
         static_cast<double>(static_cast<float>(value)) == value;
}

/// Reads the positions of OBJ and OFF, three numbers of one line, and notes whether all are floats.
class PositionText {
 public:
  /// @param next_value  goes to the next word of the line; false at its end
  /// @throws InputError  fewer than three numbers, or one that is not finite
  template <class NextValue>
  Vec3 read(TextScanner& scanner, NextValue next_value) {
    std::array<double, 3> at{};
    for (double& value : at) {
      if (!next_value()) scanner.fail("expected three coordinates, found fewer");
      value = scanner.real();
      if (!std::isfinite(value))
        scanner.fail("expected a finite coordinate, found NaN or infinity");
      all_float_ = all_float_ && is_float(value);
    }
    return {at[0], at[1], at[2]};
  }

  bool all_float() const { return all_float_; }

 private:
  bool all_float_ = true;
};

}  // namespace remaps
