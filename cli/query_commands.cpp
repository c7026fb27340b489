#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "exit_codes.h"
#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "points_file.h"
#include "progress_bar.h"
#include "remaps/base/errors.h"
#include "remaps/pipeline/query.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

using Json = nlohmann::ordered_json;
using Kind = PointQuery::Kind;

struct Arguments {
  pipeline::QueryOptions options;
  std::vector<PointQuery> points;  // in the order asked
  bool from_file = false;
  bool quiet = false, json = false, csv = false;
};

std::string to_json(const pipeline::Verification& v) {
  Json json;
  json["vertices"] = v.vertices;
  json["records"] = v.records;
  json["segments"] = v.segments;
  json["base"] = {{"vertices", v.base_vertices}, {"faces", v.base_faces}};
  json["components"] = v.components;
  json["boundary_loops"] = v.boundary_loops;
  json["euler_characteristic"] = v.euler_characteristic;
  json["round_trip_max"] = v.round_trip_max;
  json["round_trip_mean"] = v.round_trip_mean;
  json["map_file_max"] = v.map_file_max;
  if (v.sphere_vertices > 0) json["sphere_vertices"] = v.sphere_vertices;
  return json.dump(2) + "\n";
}

std::string to_table(const pipeline::Verification& v, const std::filesystem::path& bundle) {
  std::string text = fmt::format("{}: sound\n", bundle.string());
  text += fmt::format("records     {} in {}, each re-checked\n", with_commas(v.records),
                      counted(v.segments, "segment"));
  text += fmt::format("base        {}, {}; {}, {}, Euler characteristic {}, as the input\n",
                      counted(v.base_vertices, "vertex"), counted(v.base_faces, "face"),
                      counted(v.components, "component"),
                      counted(v.boundary_loops, "boundary loop"), v.euler_characteristic);
  text +=
      fmt::format("round trip  {} to the base and back: off by {:.1e} on average, {:.1e} at most\n",
                  counted(v.vertices, "vertex"), v.round_trip_mean, v.round_trip_max);
  text += fmt::format("map.bin     at most {:.1e} from the exact map\n", v.map_file_max);
  if (v.sphere_vertices > 0) {
    text +=
        fmt::format("sphere      no face turned over, covered once; {} went over it on the way\n",
                    counted(v.sphere_vertices, "vertex"));
  }
  return text + "distances are fractions of the diagonal\n";
}

void verify(const Arguments& a) {
  check_bundle(a.options.bundle);
  check_temp_dir(a.options.temp_dir);
  pipeline::Verification verification;
  {
    ProgressBar bar(a.quiet);
    verification = pipeline::verify_bundle(a.options, bar.progress());
  }
  if (a.json) {
    print(to_json(verification));
  } else if (!a.quiet) {
    print(to_table(verification, a.options.bundle));
  }
}

/// Asks the library once a kind of point and puts the answers into the order asked.
std::vector<pipeline::Location> locate_points(const Arguments& a, Progress& progress) {
  std::vector<VertexId> vertices;
  std::vector<pipeline::BasePoint> base;
  std::vector<pipeline::InputPoint> input;
  std::vector<pipeline::SpherePlace> sphere;
  for (const PointQuery& p : a.points) {
    if (p.kind == Kind::kVertex) vertices.push_back(p.index);
    if (p.kind == Kind::kSphere) sphere.push_back(p.sphere);
    if (p.kind == Kind::kInput) input.push_back({.face = p.index, .u = p.u, .v = p.v});
    if (p.kind == Kind::kBase) {
      if (!std::in_range<std::uint32_t>(p.index)) {
        throw InputError(fmt::format("there is no base face {}", p.index));
      }
      base.push_back({.face = static_cast<std::uint32_t>(p.index), .u = p.u, .v = p.v});
    }
  }
  std::vector<pipeline::Location> found[4];
  if (!vertices.empty()) found[0] = pipeline::locate_vertices(a.options, vertices, progress);
  if (!base.empty()) found[1] = pipeline::locate_base_points(a.options, base, progress);
  if (!input.empty()) found[2] = pipeline::locate_input_points(a.options, input, progress);
  if (!sphere.empty()) found[3] = pipeline::locate_directions(a.options, sphere, progress);

  std::vector<pipeline::Location> in_order;
  in_order.reserve(a.points.size());
  std::size_t next[4] = {};
  for (const PointQuery& p : a.points) {
    const auto kind = static_cast<std::size_t>(p.kind);
    in_order.push_back(found[kind].at(next[kind]++));
  }
  return in_order;
}

std::string question_text(const PointQuery& p) {
  if (p.kind == Kind::kVertex) return fmt::format("vertex {}", p.index);
  if (p.kind == Kind::kSphere) {
    const Vec3& d = p.sphere.direction;
    return fmt::format("sphere {},{},{}", d.x, d.y, d.z) +
           (p.sphere.component == 0 ? "" : fmt::format(",{}", p.sphere.component));
  }
  return fmt::format("{} {},{},{}", name_of(p.kind), p.index, p.u, p.v);
}

std::string to_text(const PointQuery& p, const pipeline::Location& at) {
  const auto& corners = at.input.vertex;
  std::string text = question_text(p) + "\n";
  text +=
      fmt::format("  base   face {}, u {:.9g}, v {:.9g}   at {:.9g} {:.9g} {:.9g}\n", at.base.face,
                  at.base.u, at.base.v, at.base_position.x, at.base_position.y, at.base_position.z);
  text +=
      fmt::format("  input  face {}, u {:.9g}, v {:.9g}   at {:.9g} {:.9g} {:.9g}\n", at.input.face,
                  at.input.u, at.input.v, at.position.x, at.position.y, at.position.z);
  text += fmt::format("         its corners are vertices {}, {}, {}\n", corners[0], corners[1],
                      corners[2]);
  if (!at.sphere) return text;
  const Vec3& d = at.sphere->direction;
  text += fmt::format("  sphere {:.12g} {:.12g} {:.12g}", d.x, d.y, d.z);
  if (at.sphere->component > 0) text += fmt::format("   component {}", at.sphere->component);
  return text + "\n";
}

constexpr const char* kCsvHeader =
    "asked,base_face,base_u,base_v,base_x,base_y,base_z,"
    "input_face,input_u,input_v,input_x,input_y,input_z,vertex_a,vertex_b,vertex_c";
/// Where the bundle has a sphere; empty for points that are not on it.
constexpr const char* kCsvSphere = ",sphere_x,sphere_y,sphere_z,sphere_component";

std::string to_csv(const PointQuery& p, const pipeline::Location& at, bool has_sphere) {
  const auto& [base, input, position, base_position, sphere] = at;
  const std::string row = fmt::format(
      "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}", name_of(p.kind), base.face, base.u, base.v,
      base_position.x, base_position.y, base_position.z, input.face, input.u, input.v, position.x,
      position.y, position.z, input.vertex[0], input.vertex[1], input.vertex[2]);
  if (!has_sphere) return row + "\n";
  if (!sphere) return row + ",,,,\n";
  const Vec3& d = sphere->direction;
  return row + fmt::format(",{},{},{},{}\n", d.x, d.y, d.z, sphere->component);
}

Json to_json(const PointQuery& p, const pipeline::Location& at) {
  const auto xyz = [](const Vec3& q) { return Json{q.x, q.y, q.z}; };
  Json json;
  if (p.kind == Kind::kVertex) {
    json["asked"] = {{"vertex", p.index}};
  } else if (p.kind == Kind::kSphere) {
    json["asked"] = {{"sphere", xyz(p.sphere.direction)}, {"component", p.sphere.component}};
  } else {
    json["asked"] = {{name_of(p.kind), {{"face", p.index}, {"u", p.u}, {"v", p.v}}}};
  }
  json["base"] = {{"face", at.base.face},
                  {"u", at.base.u},
                  {"v", at.base.v},
                  {"position", xyz(at.base_position)}};
  json["input"] = {{"face", at.input.face},
                   {"u", at.input.u},
                   {"v", at.input.v},
                   {"vertices", at.input.vertex},
                   {"position", xyz(at.position)}};
  if (at.sphere) {
    json["sphere"] = {{"direction", xyz(at.sphere->direction)},
                      {"component", at.sphere->component}};
  }
  return json;
}

void locate(const Arguments& a) {
  check_bundle(a.options.bundle);
  check_temp_dir(a.options.temp_dir);
  if (a.points.empty() && !a.from_file) {
    throw UsageError("no point is asked for: give --vertex, --base, --input, --sphere or --in");
  }
  std::vector<pipeline::Location> found;
  {
    ProgressBar bar(a.quiet);
    found = locate_points(a, bar.progress());
  }
  if (a.json) {
    print("[");
    for (std::size_t i = 0; i < found.size(); ++i) {
      print((i == 0 ? "\n  " : ",\n  ") + to_json(a.points[i], found[i]).dump());
    }
    print("\n]\n");
    return;
  }
  const bool csv = a.csv || a.from_file;
  const bool has_sphere =
      std::any_of(found.begin(), found.end(), [](const auto& at) { return at.sphere.has_value(); });
  if (csv) print(std::string(kCsvHeader) + (has_sphere ? kCsvSphere : "") + "\n");
  for (std::size_t i = 0; i < found.size(); ++i) {
    print(csv ? to_csv(a.points[i], found[i], has_sphere) : to_text(a.points[i], found[i]));
  }
}

/// An option that appends points, in the order of the command line across all such options.
template <class Append>
void add_repeatable(CLI::App& verb, const std::string& name, const char* type,
                    const std::string& description, Append append) {
  verb.add_option_function<std::string>(
          name,
          [name, append](const std::string& text) {
            try {
              append(text);
            } catch (const UsageError& error) {
              throw CLI::ValidationError(name, error.what());
            }
          },
          description)
      ->type_name(type)
      ->trigger_on_parse();
}

void add_points(CLI::App& verb, Arguments& a) {
  const auto add_kind = [&](Kind kind, const char* type, const char* description) {
    add_repeatable(
        verb, fmt::format("--{}", name_of(kind)), type, description,
        [&a, kind](const std::string& text) { a.points.push_back(parse_point(kind, text)); });
  };
  add_kind(Kind::kVertex, "I", "An input vertex, counted from 0. Repeatable");
  add_kind(Kind::kBase, "FACE,U,V",
           "A point of a base face, weights 1-U-V, U, V on its corners. Repeatable");
  add_kind(Kind::kInput, "FACE,U,V", "A point of an input face, likewise. Repeatable");
  add_kind(Kind::kSphere, "X,Y,Z",
           "A direction on the sphere of a bundle that has one; X,Y,Z,C on that of component C. "
           "Repeatable");
  add_repeatable(
      verb, "--in", "FILE",
      "A file of lines `vertex,I`, `base,FACE,U,V`, `input,FACE,U,V` or `sphere,X,Y,Z`; - is "
      "standard input. The answer is CSV. Repeatable",
      [&a](const std::string& text) {
        const auto points = read_points_file(text);
        a.points.insert(a.points.end(), points.begin(), points.end());
        a.from_file = true;
      });
}

void add_common(CLI::App& verb, Arguments& a) {
  add_path(verb, "BUNDLE", a.options.bundle, "Bundle to read")->required();
  add_resources(verb, a.options.memory_bytes, a.options.threads, a.options.temp_dir,
                "the system's");
  add_json(verb, a.json);
  add_quiet(verb, a.quiet);
}

}  // namespace

void add_query_commands(CLI::App& program, Action& action) {
  CLI::App& verify_verb =
      add_verb(program, "verify",
               "Check a bundle: checksums, every record, topology, round trip of every vertex",
               "verify scan.remaps");
  auto v = std::make_shared<Arguments>();
  add_common(verify_verb, *v);
  verify_verb.callback([v, &action] { action = [v] { verify(*v); }; });

  CLI::App& locate_verb =
      add_verb(program, "locate",
               "Say where points of the input lie on the base, and points of the base on the input",
               "locate scan.remaps --vertex 17 --base 3,0.25,0.5");
  auto l = std::make_shared<Arguments>();
  add_points(locate_verb, *l);
  add_common(locate_verb, *l);
  locate_verb.add_flag("--csv", l->csv, "Write the result to standard output as CSV");
  locate_verb.callback([l, &action] { action = [l] { locate(*l); }; });
}

}  // namespace remaps::cli
