#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "remaps/base/function_ref.h"

namespace remaps {

/// How one number of an attribute is stored in a file.
enum class ScalarType {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

/// Bytes of a number.
std::size_t size_of(ScalarType type);
/// "uint8" and so on.
std::string_view name_of(ScalarType type);
std::optional<ScalarType> scalar_type_named(std::string_view name);
/// What full colour is: 255 of a uint8, the largest number of any integer, 1 of a float.
double full_colour(ScalarType type);
constexpr bool is_integer(ScalarType type) {
  return type < ScalarType::float32;
}

/// What an attribute means, which decides how it is carried to the middle of a face.
enum class AttributeKind {
  colour,  ///< interpolated; floats from 0 to 1, or integers up to the largest of their type
  normal,  ///< interpolated and brought back to length 1; zero stays zero
  uv,      ///< interpolated; at a corner of a face it may differ from the face beside it
  scalar,  ///< interpolated
  label    ///< never interpolated: the value of the nearest corner
};
std::string_view name_of(AttributeKind kind);
std::optional<AttributeKind> attribute_kind_named(std::string_view name);

/// What has a value of its own.
enum class AttributePer { vertex, face, corner };
std::string_view name_of(AttributePer per);
std::optional<AttributePer> attribute_per_named(std::string_view name);

struct AttributeComponent {
  std::string name;  ///< as PLY would call the property: "red", "nx", "quality"
  ScalarType type = ScalarType::float32;

  friend bool operator==(const AttributeComponent&, const AttributeComponent&) = default;
};

/// One attribute of a mesh.
struct AttributeSpec {
  std::string name;  ///< "colour", "normal", "uv"; a scalar or label has the name of its component
  AttributeKind kind = AttributeKind::scalar;
  AttributePer per = AttributePer::vertex;
  std::vector<AttributeComponent> components;  ///< at least one
  /// The file has a list of its values, and corners of faces have numbers in it. An attribute of
  /// vertices is then the mean of what the corners at a vertex have.
  bool pooled = false;

  friend bool operator==(const AttributeSpec&, const AttributeSpec&) = default;
};

/// Bytes of the numbers of one attribute, and of the attributes of one vertex, face or corner: a
/// row.
std::size_t row_bytes(const AttributeSpec& spec);
std::size_t row_bytes(std::span<const AttributeSpec> specs, AttributePer per);
/// Numbers in a row.
std::size_t channels(std::span<const AttributeSpec> specs, AttributePer per);
/// Those of one kind of element, in order.
std::vector<AttributeSpec> attributes_per(std::span<const AttributeSpec> specs, AttributePer per);

/// A number out of, and into, a row. Rounded to the nearest, ties away from zero, and kept within
/// the type's range; NaN becomes 0 in an integer. Integers beyond 2^53 lose their last digits.
double load_scalar(ScalarType type, const std::byte* from);
void store_scalar(ScalarType type, double value, std::byte* to);

/// A row of doubles as bytes and back. `specs` are all of one kind of element.
void pack_row(std::span<const AttributeSpec> specs, std::span<const double> values,
              std::span<std::byte> row);
void unpack_row(std::span<const AttributeSpec> specs, std::span<const std::byte> row,
                std::span<double> values);

/// Receives a chunk of rows, one after the other: as many doubles each as the attributes of the
/// element have components.
using AttributeSink = FunctionRef<void(std::span<const double> rows)>;

/// Which attributes a user wants: "all", "none", or names separated by commas.
class AttributeChoice {
 public:
  AttributeChoice() = default;  ///< all
  /// @throws InputError  an empty name
  explicit AttributeChoice(std::string_view text);

  bool none() const { return !all_ && names_.empty(); }
  /// Those wanted, in the order of the file.
  /// @throws InputError  a name that is not there; says which are
  std::vector<AttributeSpec> choose(std::span<const AttributeSpec> specs,
                                    std::string_view file) const;

 private:
  bool all_ = true;
  std::vector<std::string> names_;
};

}  // namespace remaps
