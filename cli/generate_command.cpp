#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "exit_codes.h"
#include "help_text.h"
#include "number_text.h"
#include "options.h"
#include "progress_bar.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/generate/scan_generator.h"
#include "standard_output.h"

namespace remaps::cli {
namespace {

struct Arguments {
  GeneratorOptions options;
  std::string base = "icosahedron";
  std::filesystem::path output;
  unsigned threads = 0;
  bool quiet = false, json = false;
};

ScanGenerator make_generator(const Arguments& a) {
  GeneratorOptions options = a.options;
  const auto shape = base_shape_named(a.base);
  if (!shape) {
    throw UsageError(
        fmt::format("--base: \"{}\" is not one of icosahedron, torus, double-torus, disk", a.base));
  }
  options.base = *shape;
  try {
    return ScanGenerator(std::move(options));
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

void write_mesh(const ScanGenerator& scan, const Arguments& a) {
  ProgressBar bar(a.quiet);
  Progress& progress = bar.progress();
  const auto writer = open_mesh_writer(a.output, scan.vertices(), scan.faces());
  const unsigned threads = a.threads != 0 ? a.threads : std::thread::hardware_concurrency();

  const auto share = [](std::uint64_t done, std::uint64_t all) {
    return static_cast<double>(done) / static_cast<double>(all);
  };
  std::uint64_t vertices = 0, faces = 0;
  progress.begin("vertices");
  scan.positions(
      [&](std::span<const Vec3> positions) {
        writer->write_positions(positions);
        progress.advance(share(vertices += positions.size(), scan.vertices()));
      },
      threads);
  progress.begin("faces");
  scan.triangles(
      [&](std::span<const Triangle> triangles) {
        writer->write_triangles(triangles);
        progress.advance(share(faces += triangles.size(), scan.faces()));
      },
      threads);
  writer->close();
}

void generate(const Arguments& a) {
  check_output_mesh(a.output);
  const ScanGenerator scan = make_generator(a);
  write_mesh(scan, a);
  if (a.json) {
    nlohmann::ordered_json json;
    json["path"] = a.output.string();
    json["vertices"] = scan.vertices();
    json["faces"] = scan.faces();
    print(json.dump(2) + "\n");
  } else if (!a.quiet) {
    print(fmt::format("{}: {}, {}\n", a.output.string(), counted(scan.vertices(), "vertex"),
                      counted(scan.faces(), "face")));
  }
}

}  // namespace

void add_generate_command(CLI::App& program, Action& action) {
  CLI::App& verb =
      add_verb(program, "generate", "Make a scan-like irregular mesh of any size, to try things on",
               "generate scan.ply --vertices 20M --base torus --seed 7");
  auto a = std::make_shared<Arguments>();
  GeneratorOptions& o = a->options;
  add_path(verb, "OUTPUT", a->output, "Mesh to write: .ply, .obj, .off, .stl, .glb or .vtp")
      ->required();
  add_count(verb, "--vertices", o.vertices, 1,
            "Wanted number of vertices, met as nearly as the base allows; k, M, G of 1000");
  verb.add_option("--base", a->base, "Shape: icosahedron (sphere), torus, double-torus or disk")
      ->type_name("SHAPE")
      ->capture_default_str();
  add_count(verb, "--seed", o.seed, 0, "The same options and seed give the same mesh");
  add_real(verb, "--amplitude", o.amplitude, 0, 1,
           "Height of the relief, as a fraction of the diagonal");
  add_real(verb, "--wavelength", o.wavelength, 1e-6, 10,
           "Size of the largest features, as a fraction of the diagonal");
  add_real(verb, "--roughness", o.roughness, 0, 1,
           "Height of features of half the size, relative to the next larger ones");
  add_real(verb, "--jitter", o.jitter, 0, 1, "How far vertices stray from a regular grid");
  add_real(verb, "--flips", o.flip_fraction, 0, 1,
           "Fraction of the triangle pairs that take their other diagonal");
  verb.add_flag("--shuffled", o.shuffled, "Vertices and faces in random order: the hardest input");
  add_small(verb, "--threads", a->threads, 256, "Worker threads, 1 to 256; 0: one a processor");
  add_json(verb, a->json);
  add_quiet(verb, a->quiet);
  verb.callback([a, &action] { action = [a] { generate(*a); }; });
}

}  // namespace remaps::cli
