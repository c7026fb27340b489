#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "exit_codes.h"
#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/pipeline/surface_image.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

struct Arguments {
  pipeline::SurfaceImageOptions options;
  std::string kind = "geometry";
  std::uint64_t size = 0, component = 0, supersampling = 4;
  std::string bits;
  bool no_measure = false, quiet = false, json = false;
};

std::string to_json(const pipeline::SurfaceImageSummary& s, const Arguments& a) {
  nlohmann::ordered_json json;
  json["path"] = a.options.output.string();
  json["kind"] = a.kind;
  json["domain"] = "octahedron";
  json["size"] = s.size;
  json["samples"] = s.samples;
  if (s.error) {
    json["error"] = {{"l2", s.error->l2()},
                     {"l2_forward", s.error->l2_forward},
                     {"l2_backward", s.error->l2_backward},
                     {"max_forward", s.error->max_forward},
                     {"max_backward", s.error->max_backward}};
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string to_table(const pipeline::SurfaceImageSummary& s, const Arguments& a) {
  std::string text =
      fmt::format("{}: {} image, {} x {}, {} samples of the input\n", a.options.output.string(),
                  a.kind, s.size, s.size, with_commas(s.samples));
  if (s.error) {
    text +=
        fmt::format("error     L2 {:.2f}e-4, max {:.1f}e-4 of the diagonal\n", 1e4 * s.error->l2(),
                    1e4 * std::max(s.error->max_forward, s.error->max_backward));
  }
  return text;
}

void make_image(Arguments& a) {
  pipeline::SurfaceImageOptions& o = a.options;
  const bool geometry = a.kind == "geometry";
  o.kind = geometry             ? pipeline::ImageKind::geometry
           : a.kind == "normal" ? pipeline::ImageKind::normal
                                : pipeline::ImageKind::colour;
  // What is too large for these types is far beyond what is refused anyway.
  const auto at_most = [](std::uint64_t value) {
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>(value, std::numeric_limits<std::uint32_t>::max()));
  };
  o.size = at_most(a.size != 0 ? a.size : geometry ? 257 : 512);
  o.component = at_most(a.component);
  o.supersampling = at_most(a.supersampling);
  o.bits = a.bits == "8" || (a.bits.empty() && a.kind == "color") ? 8 : 16;
  o.measure = !a.no_measure;
  if (!pipeline::is_writable_image(o.output, o.kind)) {
    throw UsageError(fmt::format("{}: images are written as one of .exr, .png, .npy{}",
                                 o.output.string(), geometry ? ", or as a mesh" : ""));
  }
  if (geometry && o.size % 2 == 0) {
    throw UsageError(fmt::format(
        "--size {}: a geometry image has an odd size, {} or {}, so that its sides fold at a pixel",
        o.size, o.size - 1, o.size + 1));
  }
  check_output_file(o.output);
  check_temp_dir(o.query.temp_dir);
  pipeline::SurfaceImageSummary summary;
  {
    ProgressBar bar(a.quiet);
    summary = pipeline::make_surface_image(o, bar.progress());
  }
  if (a.json) {
    print(to_json(summary, a));
  } else if (!a.quiet) {
    print(to_table(summary, a));
  }
}

}  // namespace

void add_image_command(CLI::App& program, Action& action) {
  CLI::App& verb = add_verb(
      program, "image",
      "Make a geometry image, normal map or colour map of a surface that is mapped to the sphere",
      "image scan.remaps scan.exr --size 257");
  auto a = std::make_shared<Arguments>();
  pipeline::SurfaceImageOptions& o = a->options;
  add_path(verb, "BUNDLE", o.query.bundle, "Bundle with a map to the sphere, of remaps sphere")
      ->required();
  add_path(verb, "OUTPUT", o.output,
           "Image to write: .exr (floats), .png or .npy; a geometry image also as a mesh: .ply, "
           ".obj, .off, .stl, .glb or .vtp")
      ->required();
  verb.add_option("--kind", a->kind,
                  "geometry: positions; normal: unit normals of the input in model axes; color: "
                  "colours of its vertices")
      ->check(CLI::IsMember({"geometry", "normal", "color"}))
      ->type_name("KIND")
      ->capture_default_str();
  add_count(verb, "--size", a->size, 3,
            "Pixels a side. Default: 257 of geometry, which wants an odd number; 512 of others")
      ->default_str("");
  add_count(verb, "--component", a->component, 0, "Which sphere, the largest component's first");
  add_count(verb, "--supersampling", a->supersampling, 1,
            "Samples along a side of a pixel, of which normals and colours are the mean");
  verb.add_option("--bits", a->bits,
                  "Bits of a number in a PNG: 8 or 16. Default: 8 of colours, else 16")
      ->check(CLI::IsMember({"8", "16"}))
      ->type_name("N");
  verb.add_flag("--no-measure", a->no_measure, "Do not compare a geometry image with the input");
  add_count(verb, "--samples", o.samples, 1,
            "Sample points on each surface when errors are measured");
  add_resources(verb, o.query.memory_bytes, o.query.threads, o.query.temp_dir, "the system's");
  add_json(verb, a->json);
  add_quiet(verb, a->quiet);
  verb.callback([a, &action] { action = [a] { make_image(*a); }; });
}

}  // namespace remaps::cli
