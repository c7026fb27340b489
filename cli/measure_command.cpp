#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/pipeline/remesh.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

struct Arguments {
  pipeline::MeasureOptions options;
  bool quiet = false, json = false;
};

std::string to_json(const SurfaceError& error) {
  nlohmann::ordered_json json;
  json["diagonal"] = error.diagonal;
  json["l2_forward"] = error.l2_forward;
  json["l2_backward"] = error.l2_backward;
  json["l2"] = error.l2();
  json["mean_forward"] = error.mean_forward;
  json["mean_backward"] = error.mean_backward;
  json["max_forward"] = error.max_forward;
  json["max_backward"] = error.max_backward;
  const auto decibels = psnr(error.l2());
  json["psnr"] = decibels ? nlohmann::ordered_json(*decibels) : nullptr;
  json["samples_forward"] = error.samples_forward;
  json["samples_backward"] = error.samples_backward;
  return json.dump(2) + "\n";
}

std::string to_table(const SurfaceError& error) {
  constexpr const char* kRow = "{:<20} {:>10} {:>10} {:>10} {:>12}\n";
  std::string text = fmt::format("errors as fractions of the diagonal of the original, {:.6g}\n\n",
                                 error.diagonal);
  text += fmt::format(kRow, "", "L2", "mean", "max", "samples");
  text += fmt::format(kRow, "original to remesh", error_text(error.l2_forward),
                      error_text(error.mean_forward), error_text(error.max_forward),
                      with_commas(error.samples_forward));
  text += fmt::format(kRow, "remesh to original", error_text(error.l2_backward),
                      error_text(error.mean_backward), error_text(error.max_backward),
                      with_commas(error.samples_backward));
  text += fmt::format("\nL2 {}, PSNR {}\n", error_text(error.l2()), psnr_text(error.l2()));
  return text;
}

void measure(const Arguments& a) {
  check_input_file(a.options.original);
  check_input_file(a.options.remesh);
  check_temp_dir(a.options.temp_dir);
  SurfaceError error;
  {
    ProgressBar bar(a.quiet);
    error = pipeline::measure_files(a.options, bar.progress());
  }
  print(a.json ? to_json(error) : to_table(error));
}

}  // namespace

void add_measure_command(CLI::App& program, Action& action) {
  CLI::App& verb =
      add_verb(program, "measure",
               "Measure how far two surfaces lie apart: L2 and largest distance, both ways",
               "measure scan.ply remesh.ply --samples 5M");
  auto a = std::make_shared<Arguments>();
  add_path(verb, "ORIGINAL", a->options.original, "The first mesh; its diagonal is the unit")
      ->required();
  add_path(verb, "REMESH", a->options.remesh, "The second mesh")->required();
  add_samples(verb, a->options.samples);
  add_resources(verb, a->options.memory_bytes, a->options.threads, a->options.temp_dir,
                "the system's");
  add_json(verb, a->json);
  add_quiet(verb, a->quiet);
  verb.callback([a, &action] { action = [a] { measure(*a); }; });
}

}  // namespace remaps::cli
