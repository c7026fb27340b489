#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "remaps/base/function_ref.h"

namespace remaps {

/// What a face belongs to, such as its material or a number of a part: equal numbers for equal
/// labels. 64 bits of a hash, so that readers need no table of names: two labels that meet have the
/// same number once in 2^64.
using FaceLabel = std::uint64_t;

/// Of a face that no label is known of: no edge of it lies between labels.
inline constexpr FaceLabel kNoLabel = 0;

/// Receives a chunk of labels, in the order of the faces.
using FaceLabelSink = FunctionRef<void(std::span<const FaceLabel>)>;

/// Adds a value to what is known of a label; begin with kNoLabel. Never gives kNoLabel.
FaceLabel mix_label(FaceLabel label, std::string_view value);
FaceLabel mix_label(FaceLabel label, std::uint64_t value);

/// Which labels a user wants: "all", "none", or names separated by commas.
class FaceLabelChoice {
 public:
  FaceLabelChoice() = default;  ///< none
  /// @throws InputError  an empty name
  explicit FaceLabelChoice(std::string_view text);

  bool none() const { return !all_ && names_.empty(); }
  /// Those wanted, in the order of the file.
  /// @throws InputError  a name that is not there; says which are
  std::vector<std::string> choose(std::span<const std::string> there, std::string_view file) const;

 private:
  bool all_ = false;
  std::vector<std::string> names_;
};

}  // namespace remaps
