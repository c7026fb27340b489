#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/pipeline/check.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

using Json = nlohmann::ordered_json;
using pipeline::MeshCheck;

struct Arguments {
  pipeline::CheckOptions options;
  bool quiet = false, json = false;
};

Json list_of(const std::vector<std::pair<VertexId, VertexId>>& edges) {
  Json list = Json::array();
  for (const auto& [a, b] : edges) list.push_back({a, b});
  return list;
}

/// Genus of all components together.
std::int64_t handles(const Topology& t) {
  return (2 * static_cast<std::int64_t>(t.components) - t.euler_characteristic() -
          static_cast<std::int64_t>(t.boundary_loops)) /
         2;
}

std::string to_json(const MeshCheck& c, const std::filesystem::path& path) {
  Json json;
  json["path"] = path.string();
  json["vertices"] = c.vertices;
  json["faces"] = c.faces;
  json["bbox_diagonal"] = c.diagonal;
  json["sound"] = c.sound();
  json["orientable"] = c.one_sided.empty();
  json["defects"] = {
      {"nonfinite_vertices", c.repairs.nonfinite_vertices},
      {"degenerate_faces", c.repairs.degenerate_faces},
      {"duplicate_faces", c.defects.duplicate_faces},
      {"nonmanifold_edges", c.defects.nonmanifold_edges},
      {"misoriented_edges", c.defects.misoriented_edges},
      {"nonmanifold_vertices", c.defects.nonmanifold_vertices},
  };
  json["places"] = {
      {"nonfinite_vertices", c.nonfinite},
      {"duplicate_faces", c.places.duplicate_faces},
      {"nonmanifold_edges", list_of(c.places.nonmanifold_edges)},
      {"misoriented_edges", list_of(c.places.misoriented_edges)},
      {"nonmanifold_vertices", c.places.nonmanifold_vertices},
  };
  if (!c.one_sided.empty()) {
    json["one_sided_at"] = c.one_sided;
    return json.dump(2) + "\n";
  }
  json["repairs"] = {{"welded_vertices", c.repairs.welded_vertices},
                     {"unreferenced_vertices", c.repairs.unreferenced_vertices},
                     {"nonfinite_faces", c.repairs.nonfinite_faces},
                     {"flipped_faces", c.repairs.flipped_faces},
                     {"split_vertices", c.repairs.split_vertices}};
  json["topology"] = {{"vertices", c.topology.vertices},
                      {"faces", c.topology.faces},
                      {"components", c.topology.components},
                      {"boundary_edges", c.topology.boundary_edges},
                      {"boundary_loops", c.topology.boundary_loops},
                      {"euler_characteristic", c.topology.euler_characteristic()},
                      {"genus", handles(c.topology)}};
  return json.dump(2) + "\n";
}

std::string places_text(const std::vector<std::pair<VertexId, VertexId>>& edges) {
  std::string text;
  for (const auto& [a, b] : edges) text += fmt::format("{}{}-{}", text.empty() ? "" : ", ", a, b);
  return text;
}
std::string places_text(const std::vector<std::uint64_t>& numbers) {
  return fmt::format("{}", fmt::join(numbers, ", "));
}

template <class Places>
std::string defect_line(std::uint64_t count, const char* noun, const char* what,
                        const Places& places) {
  if (count == 0) return {};
  const char* const more = count > places.size() ? ", …" : "";
  return fmt::format("          {} {}: {}{}\n", counted(count, noun), what, places_text(places),
                     more);
}

std::string defect_lines(const MeshCheck& c) {
  std::string text;
  const std::string what =
      fmt::format("not finite, in {}", counted(c.repairs.nonfinite_faces, "face"));
  text += defect_line(c.repairs.nonfinite_vertices, "vertex", what.c_str(), c.nonfinite);
  if (c.repairs.degenerate_faces > 0)
    text += fmt::format("          {} with a vertex twice\n",
                        counted(c.repairs.degenerate_faces, "face"));
  text += defect_line(c.defects.duplicate_faces, "face", "with the corners of another",
                      c.places.duplicate_faces);
  text += defect_line(c.defects.nonmanifold_edges, "edge", "of more than two faces",
                      c.places.nonmanifold_edges);
  text += defect_line(c.defects.misoriented_edges, "edge", "of faces oriented against each other",
                      c.places.misoriented_edges);
  text += defect_line(c.defects.nonmanifold_vertices, "vertex", "with several fans of faces",
                      c.places.nonmanifold_vertices);
  if (!text.empty()) text.replace(0, 7, "defects");
  return text;
}

std::string to_table(const MeshCheck& c, const std::filesystem::path& path) {
  std::string text = fmt::format("{}\n", path.string());
  text += fmt::format("input     {}, {} as triangles, diagonal {:.7g}\n",
                      counted(c.vertices, "vertex"), counted(c.faces, "face"), c.diagonal);
  text += defect_lines(c);
  if (!c.one_sided.empty()) {
    return text + fmt::format("refused   it has one side only, which shows at {}\n", c.one_sided);
  }
  const Topology& t = c.topology;
  text += fmt::format(
      "surface   {}, {}, Euler characteristic {}, genus {}\n", counted(t.components, "component"),
      counted(t.boundary_loops, "boundary loop"), t.euler_characteristic(), handles(t));
  if (c.sound()) {
    text += "          a manifold as it is";
  } else {
    text += fmt::format("repair    turns {}, adds {}", counted(c.repairs.flipped_faces, "face"),
                        counted(c.repairs.split_vertices, "copied vertex"));
    if (c.repairs.nonfinite_vertices > 0) {
      text += fmt::format(", drops {} and {} with them",
                          counted(c.repairs.nonfinite_vertices, "vertex"),
                          counted(c.repairs.nonfinite_faces, "face"));
    }
  }
  if (c.repairs.welded_vertices > 0)
    text += fmt::format("; {} welded", counted(c.repairs.welded_vertices, "vertex"));
  if (c.repairs.unreferenced_vertices > 0)
    text += fmt::format("; {} without a face", counted(c.repairs.unreferenced_vertices, "vertex"));
  return text + "\n";
}

void check(const Arguments& a) {
  check_input_file(a.options.input);
  check_temp_dir(a.options.temp_dir);
  MeshCheck found;
  {
    ProgressBar bar(a.quiet);
    found = pipeline::check_mesh(a.options, bar.progress());
  }
  print(a.json ? to_json(found, a.options.input) : to_table(found, a.options.input));
}

}  // namespace

void add_check_command(CLI::App& program, Action& action) {
  CLI::App& verb =
      add_verb(program, "check", "Say what is wrong with a mesh, and what a remesh would repair",
               "check scan.ply --json");
  auto a = std::make_shared<Arguments>();
  add_input_mesh(verb, "FILE", a->options.input)->required();
  add_weld(verb, a->options.weld_distance);
  add_resources(verb, a->options.memory_bytes, a->options.threads, a->options.temp_dir,
                "the system's");
  add_json(verb, a->json);
  add_quiet(verb, a->quiet);
  verb.callback([a, &action] { action = [a] { check(*a); }; });
}

}  // namespace remaps::cli
