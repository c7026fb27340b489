#include <memory>

#include "help_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/formats/byte_sink.h"
#include "remaps/pipeline/remesh.h"
#include "report_table.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

/// How a run tells what it did.
struct Reporting {
  std::filesystem::path file;
  bool quiet = false, json = false;

  void add_to(CLI::App& verb) {
    add_path(verb, "--report", file,
             "Write what the run did, with errors, times and memory, as JSON")
        ->type_name("FILE");
    add_json(verb, json);
    add_quiet(verb, quiet);
  }

  void check() const {
    if (!file.empty()) check_output_file(file);
  }

  void deliver(const pipeline::Report& report) const {
    const std::string text = pipeline::to_json(report);
    if (!file.empty()) {
      ByteSink sink(file);
      sink.write(text.data(), text.size());
      sink.commit();
    }
    if (json) {
      print(text);
    } else if (!quiet) {
      print(report_table(report));
    }
  }
};

struct RemeshArguments {
  pipeline::RemeshOptions options;
  Reporting reporting;
  bool no_measure = false;
};

struct ResampleArguments {
  pipeline::ResampleBundleOptions options;
  Reporting reporting;
  bool no_measure = false;
};

/// Everything that can be known to be wrong before hours of work.
void check(const RemeshArguments& a) {
  const pipeline::RemeshOptions& o = a.options;
  check_input_file(o.input);
  if (!o.output.empty()) check_output_mesh(o.output);
  if (!o.bundle.empty()) check_output_bundle(o.bundle);
  check_temp_dir(o.temp_dir);
  a.reporting.check();
  check_distinct(o.input, "input", o.output, "output");
  check_distinct(o.input, "input", o.bundle, "bundle");
  check_distinct(o.output, "output", o.bundle, "bundle");
  check_distinct(o.input, "input", a.reporting.file, "report");
  check_distinct(o.output, "output", a.reporting.file, "report");
  check_distinct(o.bundle, "bundle", a.reporting.file, "report");
}

void remesh(RemeshArguments& a) {
  check(a);
  a.options.measure = !a.no_measure;
  pipeline::Report report;
  {
    ProgressBar bar(a.reporting.quiet);
    report = pipeline::remesh(a.options, bar.progress());
  }
  a.reporting.deliver(report);
}

void resample(ResampleArguments& a) {
  check_bundle(a.options.bundle);
  check_output_mesh(a.options.output);
  check_temp_dir(a.options.temp_dir);
  a.reporting.check();
  check_distinct(a.options.output, "output", a.reporting.file, "report");
  a.options.measure = !a.no_measure;
  pipeline::Report report;
  {
    ProgressBar bar(a.reporting.quiet);
    report = pipeline::resample_bundle(a.options, bar.progress());
  }
  a.reporting.deliver(report);
}

void add_base_options(CLI::App& verb, pipeline::RemeshOptions& o) {
  add_count(verb, "--base-vertices", o.base_vertices, 4,
            "Vertices of the base mesh, at least 4; more remain if topology and shape ask for it");
  add_angle(verb, "--feature-angle", o.feature_angle_deg,
            "Keep edges whose faces' normals differ by more than this as edges of the base. "
            "Default: none are kept");
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

/// What the output is like: for remesh and resample alike.
void add_output_options(CLI::App& verb, unsigned& level, bool& fit, bool& no_measure,
                        std::uint64_t& samples) {
  add_small(verb, "--level", level, 14,
            "Subdivisions of the base, 0 to 14; each makes four faces of one");
  verb.add_flag("--fit", fit,
                "Move the output's vertices to the least-squares fit of the input's points");
  verb.add_flag("--no-measure", no_measure, "Do not measure the error of the output");
  add_samples(verb, samples);
}

void add_remesh(CLI::App& program, Action& action) {
  CLI::App& verb =
      add_verb(program, "remesh", "Make a semi-regular mesh of a triangle mesh of any size",
               "remesh scan.ply remesh.ply --level 6 --memory 1G --bundle scan.remaps");
  auto a = std::make_shared<RemeshArguments>();
  pipeline::RemeshOptions& o = a->options;
  add_path(verb, "INPUT", o.input, "Mesh to read: .ply, .obj or .off")->required();
  add_path(verb, "OUTPUT", o.output, "Mesh to write: .ply or .obj")->required();
  add_base_options(verb, o);
  add_output_options(verb, o.level, o.fit, a->no_measure, o.samples);
  add_path(verb, "--bundle", o.bundle,
           "Keep base and exact map in this directory, for resample, verify and locate")
      ->type_name("DIR");
  add_buffer_options(verb, o);
  a->reporting.add_to(verb);
  verb.callback([a, &action] { action = [a] { remesh(*a); }; });
}

void add_parameterize(CLI::App& program, Action& action) {
  CLI::App& verb =
      add_verb(program, "parameterize", "Make the base and the exact map only, as a bundle",
               "parameterize scan.ply scan.remaps --base-vertices 500");
  auto a = std::make_shared<RemeshArguments>();
  add_path(verb, "INPUT", a->options.input, "Mesh to read: .ply, .obj or .off")->required();
  add_path(verb, "BUNDLE", a->options.bundle, "Directory to write, by custom NAME.remaps")
      ->required();
  add_base_options(verb, a->options);
  add_buffer_options(verb, a->options);
  a->reporting.add_to(verb);
  a->no_measure = true;
  verb.callback([a, &action] { action = [a] { remesh(*a); }; });
}

void add_resample(CLI::App& program, Action& action) {
  CLI::App& verb =
      add_verb(program, "resample", "Make the semi-regular mesh of a bundle, at any level",
               "resample scan.remaps coarse.ply --level 3");
  auto a = std::make_shared<ResampleArguments>();
  pipeline::ResampleBundleOptions& o = a->options;
  add_path(verb, "BUNDLE", o.bundle, "Bundle to read")->required();
  add_path(verb, "OUTPUT", o.output, "Mesh to write: .ply or .obj")->required();
  add_output_options(verb, o.level, o.fit, a->no_measure, o.samples);
  add_resources(verb, o.memory_bytes, o.threads, o.temp_dir, "beside the result");
  a->reporting.add_to(verb);
  verb.callback([a, &action] { action = [a] { resample(*a); }; });
}

}  // namespace

void add_remesh_commands(CLI::App& program, Action& action) {
  add_remesh(program, action);
  add_parameterize(program, action);
  add_resample(program, action);
}

}  // namespace remaps::cli
