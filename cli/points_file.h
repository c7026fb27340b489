#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

namespace remaps::cli {

/// A point that `locate` is asked for.
struct PointQuery {
  enum class Kind { kVertex, kBase, kInput };
  Kind kind = Kind::kVertex;
  std::uint64_t index = 0;  ///< of the input vertex, base face or input face
  double u = 0, v = 0;      ///< weights (1 - u - v, u, v) on the face
};

/// "vertex", "base", "input".
const char* name_of(PointQuery::Kind kind);

/// Reads "I" for a vertex, "FACE,U,V" for a point of a face.
/// @throws UsageError  says what is wrong with it
PointQuery parse_point(PointQuery::Kind kind, std::string_view text);

/// Reads lines `vertex,I`, `base,FACE,U,V` and `input,FACE,U,V`. Empty lines, comments from # and a
/// first line of names are passed over. "-" is standard input.
/// @throws InputError  missing, or a bad line: says its number
std::vector<PointQuery> read_points_file(const std::filesystem::path& path);

}  // namespace remaps::cli
