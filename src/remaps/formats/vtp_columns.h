#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "remaps/mesh/attributes.h"

namespace remaps {

/// An array of a VTP file with what elements have.
struct VtpColumn {
  std::string name;  ///< as it stands in the XML
  std::string_view type;
  unsigned components = 1;
  std::size_t bytes = 0;  ///< of an element
  AttributeKind kind = AttributeKind::scalar;
};

/// Arrays for the attributes of one kind of element, which make up a row: one each, or, where the
/// types of its numbers differ, one for each number. Names that XML or VTK would stumble over are
/// changed, and those that are taken get `input_` before them.
/// @param taken  grows by the new names
std::vector<VtpColumn> find_vtp_columns(std::span<const AttributeSpec> specs, AttributePer per,
                                        std::vector<std::string>& taken);

/// What tells VTK which arrays are colours, normals and texture coordinates: attributes of the
/// element around the arrays, each after a blank.
std::string vtp_roles(std::span<const VtpColumn> columns);

}  // namespace remaps
