#include "points_file.h"

#include <fmt/format.h>

#include <fstream>
#include <iostream>
#include <string>

#include "exit_codes.h"
#include "number_text.h"
#include "options.h"
#include "remaps/base/errors.h"

namespace remaps::cli {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = text.find(',');
    fields.push_back(trimmed(text.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    text.remove_prefix(comma + 1);
  }
}

PointQuery parse_line(std::string_view line) {
  const std::size_t comma = line.find(',');
  const std::string_view name = trimmed(line.substr(0, comma));
  const std::string_view rest =
      comma == std::string_view::npos ? std::string_view() : line.substr(comma + 1);
  for (const auto kind : {PointQuery::Kind::kVertex, PointQuery::Kind::kBase,
                          PointQuery::Kind::kInput, PointQuery::Kind::kSphere}) {
    if (name == name_of(kind)) return parse_point(kind, rest);
  }
  throw UsageError(fmt::format("expected vertex, base, input or sphere, found \"{}\"", name));
}

/// A line of names has no number in any field.
bool is_header(std::string_view line) {
  for (const std::string_view field : split(line)) {
    if (parse_real(field)) return false;
  }
  return true;
}

std::vector<PointQuery> read_points(std::istream& stream, const std::string& name) {
  std::vector<PointQuery> points;
  std::string line;
  bool is_first = true;
  for (std::uint64_t number = 1; std::getline(stream, line); ++number) {
    const std::string_view text = trimmed(std::string_view(line).substr(0, line.find('#')));
    if (text.empty()) continue;
    if (std::exchange(is_first, false) && is_header(text)) continue;
    try {
      points.push_back(parse_line(text));
    } catch (const UsageError& error) {
      throw InputError(fmt::format("{}: line {}: {}", name, number, error.what()));
    }
  }
  if (stream.bad()) throw IoError(name + ": reading failed");
  return points;
}

PointQuery parse_direction(std::string_view text) {
  const std::vector<std::string_view> fields = split(text);
  PointQuery point{.kind = PointQuery::Kind::kSphere};
  double* const coordinates[] = {&point.sphere.direction.x, &point.sphere.direction.y,
                                 &point.sphere.direction.z};
  bool good = fields.size() == 3 || fields.size() == 4;
  for (std::size_t i = 0; good && i < 3; ++i) {
    const auto number = parse_real(fields[i]);
    good = number.has_value();
    if (good) *coordinates[i] = *number;
  }
  if (good && fields.size() == 4) {
    const auto component = parse_integer(fields[3]);
    good = component && std::in_range<std::uint32_t>(*component);
    if (good) point.sphere.component = static_cast<std::uint32_t>(*component);
  }
  if (!good) throw UsageError(fmt::format("expected X,Y,Z or X,Y,Z,COMPONENT, found \"{}\"", text));
  return point;
}

}  // namespace

const char* name_of(PointQuery::Kind kind) {
  switch (kind) {
    case PointQuery::Kind::kVertex:
      return "vertex";
    case PointQuery::Kind::kBase:
      return "base";
    case PointQuery::Kind::kInput:
      return "input";
    case PointQuery::Kind::kSphere:
      return "sphere";
  }
  return "";
}

PointQuery parse_point(PointQuery::Kind kind, std::string_view text) {
  if (kind == PointQuery::Kind::kSphere) return parse_direction(text);
  PointQuery point{.kind = kind};
  const std::vector<std::string_view> fields = split(text);
  const bool is_vertex = kind == PointQuery::Kind::kVertex;
  const auto index = parse_integer(fields[0]);
  if (fields.size() != (is_vertex ? 1 : 3) || !index) {
    throw UsageError(fmt::format("expected {}, found \"{}\"",
                                 is_vertex ? "the number of a vertex" : "FACE,U,V", text));
  }
  point.index = *index;
  if (is_vertex) return point;

  const auto u = parse_real(fields[1]), v = parse_real(fields[2]);
  if (!u || !v) throw UsageError(fmt::format("expected FACE,U,V, found \"{}\"", text));
  constexpr double kRounding = 1e-9;
  if (*u < -kRounding || *v < -kRounding || *u + *v > 1 + kRounding) {
    throw UsageError(fmt::format("weights U = {}, V = {} lie outside the face", *u, *v));
  }
  point.u = *u;
  point.v = *v;
  return point;
}

std::vector<PointQuery> read_points_file(const std::filesystem::path& path) {
  if (path == "-") return read_points(std::cin, "standard input");
  check_input_file(path);
  std::ifstream stream(path);
  if (!stream) throw InputError(path.string() + ": cannot be read");
  return read_points(stream, path.string());
}

}  // namespace remaps::cli
