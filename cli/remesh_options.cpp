#include "remesh_options.h"

namespace remaps::cli {

void add_repair_options(CLI::App& verb, pipeline::RemeshOptions& o) {
  add_weld(verb, o.weld_distance);
  verb.add_flag("--strict", o.strict, "Refuse a mesh that needs repair; see the verb check");
  add_count(verb, "--min-component", o.min_component, 0,
            "Drop components of fewer faces; 0: keep all")
      ->type_name("FACES");
  add_count(verb, "--fill-holes", o.fill_holes, 0, "Fill holes of at most so many edges; 0: none")
      ->type_name("EDGES");
}

void add_buffer_options(CLI::App& verb, pipeline::RemeshOptions& o) {
  add_resources(verb, o.memory_bytes, o.threads, o.temp_dir, "beside the result");
  add_count(verb, "--domain-buffer", o.domain_buffer, 0,
            "Faces in memory at a time; 0: as many as --memory allows")
      ->type_name("FACES");
  add_count(verb, "--map-buffer", o.map_buffer, 0,
            "Points in memory at a time; 0: as many as --memory allows")
      ->type_name("VERTICES");
}

}  // namespace remaps::cli
