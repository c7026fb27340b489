#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "remaps/pipeline/query.h"

namespace remaps::cli {

/// A point that `locate` is asked for.
struct PointQuery {
  enum class Kind { kVertex, kBase, kInput, kSphere };
  Kind kind = Kind::kVertex;
  std::uint64_t index = 0;  ///< of the input vertex, base face or input face
  double u = 0, v = 0;      ///< weights (1 - u - v, u, v) on the face
  pipeline::SpherePlace sphere = {};
};

/// "vertex", "base", "input", "sphere".
const char* name_of(PointQuery::Kind kind);

/// Reads "I" for a vertex, "FACE,U,V" for a point of a face, "X,Y,Z" or "X,Y,Z,COMPONENT"
/// for a direction.
/// @throws UsageError  says what is wrong with it
PointQuery parse_point(PointQuery::Kind kind, std::string_view text);

/// Reads lines `vertex,I`, `base,FACE,U,V`, `input,FACE,U,V` and `sphere,X,Y,Z`. Empty lines,
/// comments from # and a first line of names are passed over. "-" is standard input.
/// @throws InputError  missing, or a bad line: says its number
std::vector<PointQuery> read_points_file(const std::filesystem::path& path);

}  // namespace remaps::cli
