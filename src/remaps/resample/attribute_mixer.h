#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "remaps/mesh/attributes.h"

namespace remaps::resample {

/// Mixes rows of attributes by weights, each attribute as its kind wants. Values are kept as
/// doubles meanwhile.
class AttributeMixer {
 public:
  /// @param specs  of one kind of element
  explicit AttributeMixer(std::vector<AttributeSpec> specs);

  std::size_t channels() const { return label_.size(); }
  std::size_t row_bytes() const { return row_bytes_; }
  const std::vector<AttributeSpec>& specs() const { return specs_; }

  /// Adds a row to a sum that began with zeros. Rows of weight 0 are not to be added.
  /// @param heaviest  largest weight so far, 0 before the first row
  void add(std::span<const std::byte> row, double weight, std::span<double> sum, double& heaviest);
  /// Makes the normals in a sum, or in a row of values, as long as they should be, and the sum a
  /// row.
  void finish(std::span<double> sum, std::span<std::byte> row) const;

 private:
  std::vector<AttributeSpec> specs_;
  std::size_t row_bytes_;
  std::vector<bool> label_;          // (channels)
  std::vector<std::size_t> normal_;  // first channels of normals
  std::vector<double> values_;       // (channels)
};

}  // namespace remaps::resample
