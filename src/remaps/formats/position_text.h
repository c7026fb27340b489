#pragma once

#include <array>

#include "remaps/base/geometry.h"
#include "remaps/formats/position_value.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {

/// Reads the positions of OBJ, OFF and STL, three numbers of one line, and notes whether all are
/// floats.
class PositionText {
 public:
  /// @param next_value  goes to the next word of the line; false at its end
  /// @return  kNotFinite if a coordinate is not finite
  /// @throws InputError  fewer than three numbers
  template <class NextValue>
  Vec3 read(TextScanner& scanner, NextValue next_value) {
    std::array<double, 3> at{};
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (!next_value()) fail(scanner, i);
      at[i] = scanner.coordinate();
    }
    const Vec3 p{at[0], at[1], at[2]};
    if (!has_position(p)) return kNotFinite;
    all_float_ = all_float_ && is_float(p);
    return p;
  }

  bool all_float() const { return all_float_; }

 private:
  [[noreturn]] static void fail(const TextScanner& scanner, std::size_t found) {
    constexpr std::array<const char*, 3> kMessages = {
        "expected three coordinates x, y and z of a vertex, found none",
        "expected three coordinates x, y and z of a vertex, found one",
        "expected three coordinates x, y and z of a vertex, found two: flat meshes need a z, 0 for "
        "instance"};
    scanner.fail(kMessages[found]);
  }

  bool all_float_ = true;
};

}  // namespace remaps
