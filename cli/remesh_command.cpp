#include <memory>
#include <optional>

#include "help_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/formats/byte_sink.h"
#include "remaps/pipeline/remesh.h"
#include "remesh_options.h"
#include "report_table.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

constexpr const char* kOutputHelp = "Mesh to write: .ply, .obj, .off, .stl, .glb or .vtp";

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
  std::string error_kind = "l2";
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
  if (!o.bundle.empty()) check_output_bundle(o.bundle);
  check_temp_dir(o.temp_dir);
  a.reporting.check();
  for (const std::filesystem::path& output : output_meshes(o.output, o.coarsest, o.level)) {
    check_output_mesh(output);
    check_distinct(o.input, "input", output, "output");
    check_distinct(output, "output", o.bundle, "bundle");
    check_distinct(output, "output", a.reporting.file, "report");
  }
  check_distinct(o.input, "input", o.bundle, "bundle");
  check_distinct(o.input, "input", a.reporting.file, "report");
  check_distinct(o.bundle, "bundle", a.reporting.file, "report");
}

void remesh(RemeshArguments& a) {
  check(a);
  a.options.measure = !a.no_measure;
  a.options.goal.kind =
      a.error_kind == "max" ? pipeline::ErrorKind::kMax : pipeline::ErrorKind::kL2;
  pipeline::Report report;
  {
    ProgressBar bar(a.reporting.quiet);
    report = pipeline::remesh(a.options, bar.progress());
  }
  a.reporting.deliver(report);
}

void resample(ResampleArguments& a) {
  check_bundle(a.options.bundle);
  check_temp_dir(a.options.temp_dir);
  a.reporting.check();
  for (const std::filesystem::path& output :
       output_meshes(a.options.output, a.options.coarsest, a.options.level)) {
    check_output_mesh(output);
    check_distinct(output, "output", a.reporting.file, "report");
  }
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
  add_feature_labels(verb, o.feature_labels);
}

/// What the output is like: for remesh and resample alike.
void add_output_options(CLI::App& verb, unsigned& level, std::optional<unsigned>& coarsest,
                        bool& fit, bool& no_measure, std::uint64_t& samples) {
  add_levels(verb, level, coarsest);
  verb.add_flag("--fit", fit,
                "Move the output's vertices to the least-squares fit of the input's points");
  verb.add_flag("--no-measure", no_measure, "Do not measure the error of the output");
  add_samples(verb, samples);
}

/// An error to be met instead of a level.
void add_goal_options(CLI::App& verb, RemeshArguments& a) {
  CLI::Option* const goal =
      add_real(verb, "--max-error", a.options.goal.most, 0, 1,
               "Choose the lowest level, and if need be a larger base, whose measured error is at "
               "most this fraction of the diagonal; 0: --level decides");
  for (const char* other : {"--level", "--levels", "--no-measure"})
    goal->excludes(verb.get_option(other));
  verb.add_option("--max-error-kind", a.error_kind, "Error to be met: l2 or max")
      ->check(CLI::IsMember({"l2", "max"}))
      ->capture_default_str()
      ->needs(goal);
  add_count(verb, "--max-faces", a.options.goal.max_faces, 0,
            "Faces of the output at most, for --max-error; 0: 16 times the input's")
      ->type_name("FACES")
      ->needs(goal);
}

void add_remesh(CLI::App& program, Action& action) {
  CLI::App& verb =
      add_verb(program, "remesh", "Make a semi-regular mesh of a triangle mesh of any size",
               "remesh scan.ply remesh.ply --level 6 --memory 1G --bundle scan.remaps");
  auto a = std::make_shared<RemeshArguments>();
  pipeline::RemeshOptions& o = a->options;
  add_input_mesh(verb, "INPUT", o.input)->required();
  add_path(verb, "OUTPUT", o.output, kOutputHelp)->required();
  add_base_options(verb, o);
  add_repair_options(verb, o);
  add_output_options(verb, o.level, o.coarsest, o.fit, a->no_measure, o.samples);
  add_goal_options(verb, *a);
  add_attributes(verb, o.attributes, "from the input to output and bundle");
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
  add_input_mesh(verb, "INPUT", a->options.input)->required();
  add_path(verb, "BUNDLE", a->options.bundle, "Directory to write, by custom NAME.remaps")
      ->required();
  add_base_options(verb, a->options);
  add_attributes(verb, a->options.attributes, "from the input to the bundle");
  add_repair_options(verb, a->options);
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
  add_path(verb, "OUTPUT", o.output, kOutputHelp)->required();
  add_output_options(verb, o.level, o.coarsest, o.fit, a->no_measure, o.samples);
  add_attributes(verb, o.attributes, "from the bundle to the output");
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
