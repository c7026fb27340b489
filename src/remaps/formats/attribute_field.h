#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "remaps/mesh/attributes.h"

namespace remaps {

/// One attribute in the rows that a writer is given.
class AttributeField {
 public:
  /// @param at  its first byte in a row
  AttributeField(const AttributeSpec& spec, std::size_t at) : spec_(spec), at_(at) {}

  const AttributeSpec& spec() const { return spec_; }
  std::size_t at() const { return at_; }
  std::size_t size() const { return spec_.components.size(); }

  /// The first values as floats: colours as fractions of 1, what is not finite as 0.
  void read(std::span<const std::byte> row, std::span<float> values) const {
    std::size_t at = at_;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const ScalarType type = spec_.components[i].type;
      double value = load_scalar(type, row.data() + at);
      if (spec_.kind == AttributeKind::colour) value *= 1 / full_colour(type);
      values[i] = std::isfinite(value) ? static_cast<float>(value) : 0.0F;
      at += size_of(type);
    }
  }

 private:
  AttributeSpec spec_;
  std::size_t at_;
};

/// Those of one kind of element that `wanted` takes, in order.
template <class Wanted>
std::vector<AttributeField> find_fields(std::span<const AttributeSpec> specs, AttributePer per,
                                        Wanted wanted) {
  std::vector<AttributeField> fields;
  std::size_t at = 0;
  for (const AttributeSpec& spec : specs) {
    if (spec.per != per) continue;
    if (wanted(spec)) fields.emplace_back(spec, at);
    at += row_bytes(spec);
  }
  return fields;
}

/// The first of a kind with so many components.
inline std::optional<AttributeField> find_field(std::span<const AttributeSpec> specs,
                                                AttributePer per, AttributeKind kind,
                                                std::size_t least, std::size_t most) {
  auto found = find_fields(specs, per, [&](const AttributeSpec& spec) {
    return spec.kind == kind && spec.components.size() >= least && spec.components.size() <= most;
  });
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

}  // namespace remaps
