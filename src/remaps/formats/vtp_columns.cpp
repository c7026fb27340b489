#include "remaps/formats/vtp_columns.h"

#include <fmt/format.h>

#include <algorithm>

namespace remaps {
namespace {

std::string_view type_name(ScalarType type) {
  constexpr std::string_view kNames[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                         "UInt32", "Int64", "UInt64", "Float32", "Float64"};
  return kNames[static_cast<std::size_t>(type)];
}

/// Letters, digits and signs that mean nothing in XML; others become '_'.
std::string clean(std::string_view name) {
  std::string text(name);
  for (char& c : text) {
    if (c < ' ' || c > '~' || c == '<' || c == '>' || c == '&' || c == '"' || c == '\'') c = '_';
  }
  return text;
}

std::string free_name(std::string name, std::vector<std::string>& taken) {
  const auto is_taken = [&] { return std::find(taken.begin(), taken.end(), name) != taken.end(); };
  while (is_taken()) name = "input_" + name;
  taken.push_back(name);
  return name;
}

}  // namespace

std::vector<VtpColumn> find_vtp_columns(std::span<const AttributeSpec> specs, AttributePer per,
                                        std::vector<std::string>& taken) {
  std::vector<VtpColumn> columns;
  for (const AttributeSpec& spec : specs) {
    if (spec.per != per) continue;
    const ScalarType first = spec.components[0].type;
    const bool alike =
        std::all_of(spec.components.begin(), spec.components.end(),
                    [first](const AttributeComponent& c) { return c.type == first; });
    if (alike) {
      columns.push_back({free_name(clean(spec.name), taken), type_name(first),
                         static_cast<unsigned>(spec.components.size()), row_bytes(spec),
                         spec.kind});
      continue;
    }
    for (const AttributeComponent& c : spec.components) {
      columns.push_back({free_name(clean(spec.name + "_" + c.name), taken), type_name(c.type), 1,
                         size_of(c.type), AttributeKind::scalar});
    }
  }
  return columns;
}

std::string vtp_roles(std::span<const VtpColumn> columns) {
  std::string text;
  const auto add = [&](const char* role, AttributeKind kind, unsigned least, unsigned most) {
    const auto found = std::find_if(columns.begin(), columns.end(), [&](const VtpColumn& c) {
      return c.kind == kind && c.components >= least && c.components <= most;
    });
    if (found != columns.end()) text += fmt::format(" {}=\"{}\"", role, found->name);
  };
  add("Scalars", AttributeKind::colour, 3, 4);
  add("Normals", AttributeKind::normal, 3, 3);
  add("TCoords", AttributeKind::uv, 2, 2);
  return text;
}

}  // namespace remaps
