#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "exit_codes.h"
#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/pipeline/map_sphere.h"
#include "remesh_options.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

struct Arguments {
  const CLI::App* verb = nullptr;
  pipeline::MapSphereOptions options;
  std::string component = "largest";
  bool quiet = false, json = false;
};

std::string to_json(const pipeline::MapSphereSummary& s, const std::filesystem::path& bundle) {
  nlohmann::ordered_json json;
  json["path"] = bundle.string();
  json["input_vertices"] = s.input_vertices;
  json["mapped_vertices"] = s.sphere.vertices;
  json["round_trip_max"] = s.sphere.round_trip_max;
  json["base_components"] = s.base_components;
  json["components"] = nlohmann::ordered_json::array();
  for (const pipeline::SphereComponent& c : s.sphere.components) {
    json["components"].push_back({{"base_vertices", c.base.vertices},
                                  {"base_faces", c.base.faces},
                                  {"turned_faces", 0},
                                  {"stretch_efficiency", c.quality.stretch_efficiency},
                                  {"area_distortion", c.quality.area_distortion},
                                  {"angle_distortion", c.quality.angle_distortion}});
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string to_table(const pipeline::MapSphereSummary& s, const std::filesystem::path& bundle) {
  std::string text = fmt::format("{}: bundle with a map to the sphere\n", bundle.string());
  constexpr std::size_t kMost = 8;
  for (std::size_t i = 0; i < s.sphere.components.size() && i < kMost; ++i) {
    const pipeline::SphereComponent& c = s.sphere.components[i];
    text += fmt::format("sphere      {}, {} of the base, none turned over\n",
                        counted(c.base.vertices, "vertex"), counted(c.base.faces, "face"));
    text += fmt::format(
        "            stretch efficiency {:.3f}, area distortion {:.3f}, angle distortion {:.3f}\n",
        c.quality.stretch_efficiency, c.quality.area_distortion, c.quality.angle_distortion);
  }
  if (s.sphere.components.size() > kMost) {
    text += fmt::format("            and {} more\n", s.sphere.components.size() - kMost);
  }
  if (s.base_components > s.sphere.components.size()) {
    text += fmt::format("left out    {}, smaller; --component all maps each\n",
                        counted(s.base_components - s.sphere.components.size(), "component"));
  }
  text += fmt::format(
      "vertices    {} of {} mapped; base to sphere and back: off by {:.1e} of the "
      "diagonal at most\n",
      with_commas(s.sphere.vertices), with_commas(s.input_vertices), s.sphere.round_trip_max);
  return text;
}

/// A bundle has been parameterized already.
void refuse_options_of_meshes(const Arguments& a) {
  for (const char* const name :
       {"--intermediate-faces", "--weld", "--strict", "--min-component", "--fill-holes",
        "--attributes", "--domain-buffer", "--map-buffer"}) {
    if (a.verb->count(name) == 0) continue;
    throw UsageError(
        fmt::format("{} is for a mesh, but {} is a bundle", name, a.options.input.string()));
  }
}

void map_to_sphere(Arguments& a) {
  pipeline::MapSphereOptions& o = a.options;
  std::error_code ignored;
  if (std::filesystem::is_directory(o.input, ignored)) {
    refuse_options_of_meshes(a);
  } else {
    check_input_file(o.input);
  }
  check_output_bundle(o.output);
  check_temp_dir(o.parameterize.temp_dir);
  o.all_components = a.component == "all";
  pipeline::MapSphereSummary summary;
  {
    ProgressBar bar(a.quiet);
    summary = pipeline::map_to_sphere(o, bar.progress());
  }
  if (a.json) {
    print(to_json(summary, o.output));
  } else if (!a.quiet) {
    print(to_table(summary, o.output));
  }
}

}  // namespace

void add_sphere_command(CLI::App& program, Action& action) {
  CLI::App& verb = add_verb(program, "sphere",
                            "Map a closed surface of genus 0 to the sphere, every vertex of it",
                            "sphere scan.ply scan.remaps --memory 1G");
  auto a = std::make_shared<Arguments>();
  a->verb = &verb;
  pipeline::MapSphereOptions& o = a->options;
  add_path(verb, "INPUT", o.input, "Mesh, or a bundle whose base is to be mapped")->required();
  add_path(verb, "OUTPUT", o.output,
           "Bundle to write: that of the input, with sphere.bin, a unit vector for each vertex")
      ->required();
  add_count(verb, "--intermediate-faces", o.intermediate_faces, 4,
            "Faces of the base that a mesh gets, between it and the sphere")
      ->type_name("FACES");
  verb.add_option("--component", a->component,
                  "largest: only the component with most faces; all: each to a sphere of its own")
      ->check(CLI::IsMember({"largest", "all"}))
      ->type_name("WHICH")
      ->capture_default_str();
  add_repair_options(verb, o.parameterize);
  add_attributes(verb, o.parameterize.attributes, "from a mesh to the bundle");
  add_buffer_options(verb, o.parameterize);
  add_json(verb, a->json);
  add_quiet(verb, a->quiet);
  verb.callback([a, &action] { action = [a] { map_to_sphere(*a); }; });
}

}  // namespace remaps::cli
