#include "remaps/pipeline/remesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <thread>

#include "remaps/formats/mesh_writer.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/disk_plan.h"
#include "remaps/pipeline/error_control.h"
#include "remaps/pipeline/input_mesh.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/output.h"
#include "remaps/pipeline/parameterize.h"
#include "remaps/pipeline/resource_monitor.h"
#include "remaps/pipeline/run_plan.h"
#include "remaps/pipeline/staged.h"
#include "remaps/pipeline/vertex_spool.h"

namespace remaps::pipeline {
namespace {

unsigned thread_count(unsigned wanted) {
  return wanted != 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

/// Moves outputs out, whose paths are in the report, and counts their bytes.
void move_outputs(const Staged& staged, Report& report) {
  for (Report::Output& output : report.outputs) {
    const std::filesystem::path from = output.path;
    const std::filesystem::path to = staged.target().parent_path() / from.filename();
    report.bytes_written += std::filesystem::file_size(from);
    std::filesystem::rename(from, to);
    output.path = to.string();
  }
  report.output_path = report.outputs.back().path;
}

/// Where no level meets the goal for the error, the base gets so many times larger, so often.
constexpr std::uint64_t kLargerBase = 4;
constexpr unsigned kBases = 4;

/// --fit holds the output in memory: said before the work starts, not after the sweeps. The true
/// number of faces depends on the topology; about two a base vertex.
void check_fit(const RemeshOptions& options) {
  if (!options.fit || options.output.empty()) return;
  const double faces = 2.0 * double(options.base_vertices) * std::exp2(2.0 * options.level);
  const double bytes = faces * 300;
  if (bytes <= double(options.memory_bytes)) return;
  throw BudgetError(fmt::format(
      "--fit holds the output in memory: about {:.0f} faces need --memory {:.0f}M or more", faces,
      std::ceil(bytes / (1 << 20))));
}

/// A format with a limit refuses what is surely beyond it before the work starts: a base of so many
/// vertices, where the input has so many, has half as many faces at least.
void check_output_size(const RemeshOptions& options) {
  if (options.output.empty()) return;
  const std::uint64_t base = std::min(options.base_vertices, guess_vertices(options.input)) / 2;
  const std::uint64_t faces = base << (2 * options.level);
  if (faces > 0) check_mesh_size(options.output, faces / 2 + 1, faces);
}

}  // namespace

Report remesh(const RemeshOptions& options, Progress& progress) {
  ResourceMonitor monitor;
  Report report;
  const unsigned threads = thread_count(options.threads);
  const MemoryPlan plan =
      plan_memory(options.memory_bytes, threads, options.domain_buffer, options.map_buffer);
  MemoryBudget budget(plan.budget_bytes);
  report.threads = threads;
  report.memory_budget_bytes = plan.budget_bytes;
  report.domain_buffer = plan.domain_buffer;
  report.map_buffer = plan.map_buffer;

  check_fit(options);
  check_output_size(options);
  const bool has_output = !options.output.empty();
  const bool has_bundle = !options.bundle.empty();
  const std::filesystem::path bundle_target = without_slash(options.bundle);
  if (has_bundle) check_bundle_target(bundle_target);
  const std::filesystem::path temp_parent =
      !options.temp_dir.empty() ? options.temp_dir
                                : parent_of(has_output ? options.output : bundle_target);
  report.planned_temp_bytes = temporary_bytes_needed(options.input);
  check_disk_space(report.planned_temp_bytes, temp_parent);
  const store::TempDir temp(temp_parent);
  std::optional<Staged> staged_output;
  std::optional<Staged> staged_bundle;
  if (has_output) staged_output.emplace(options.output);
  if (has_bundle) staged_bundle.emplace(bundle_target);
  const std::filesystem::path bundle_path =
      has_bundle ? staged_bundle->path() : temp.path() / "bundle";

  if (has_output) {
    // About two faces a base vertex, and half a vertex a face.
    const double vertices = double(options.base_vertices) * std::exp2(2.0 * options.level);
    progress.plan(
        expect_output({guess_vertices(options.input), static_cast<std::uint64_t>(vertices),
                       options.fit, options.measure, options.samples}));
  }
  ParameterizeJob job;
  job.input = options.input;
  job.bundle = bundle_path;
  job.temp_dir = temp.path();
  job.base_vertices = options.base_vertices;
  job.threads = threads;
  job.feature_angle_deg = options.feature_angle_deg;
  job.feature_labels = options.feature_labels;
  job.weld_distance = options.weld_distance;
  job.strict = options.strict;
  job.repair = {options.min_component, options.fill_holes};
  job.accept = options.accept;
  job.write_map = has_bundle;
  job.attributes = options.attributes;
  report.goal = options.goal;
  for (unsigned round = 1;; ++round) {
    std::filesystem::create_directory(bundle_path);
    parameterize(job, plan, budget, progress, report);
    if (!has_output) break;
    const Bundle bundle(bundle_path);
    const OutputJob output{staged_output->path(), temp.path(),     options.level,
                           options.coarsest,      threads,         options.fit,
                           options.measure,       options.samples, {}};
    if (!options.goal.any()) {
      write_output(bundle, output, plan, budget, progress, report);
      break;
    }
    if (write_within_error(bundle, output, options.goal, plan, budget, progress, report)) break;
    job.base_vertices *= kLargerBase;
    const bool larger = round < kBases &&
                        2 * job.base_vertices <= most_faces(options.goal, report.input_faces) &&
                        job.base_vertices < report.input_vertices;
    if (!larger) throw GeometryError(describe_miss(options.goal, report));
    std::filesystem::remove_all(bundle_path);
    report.sweeps.clear();
  }
  progress.check();
  if (has_bundle) staged_bundle->directory_to_target();
  if (has_output) move_outputs(*staged_output, report);
  monitor.finish(report);
  return report;
}

Report resample_bundle(const ResampleBundleOptions& options, Progress& progress) {
  ResourceMonitor monitor;
  Report report;
  const unsigned threads = thread_count(options.threads);
  const MemoryPlan plan = plan_memory(options.memory_bytes, threads, 0, 0);
  MemoryBudget budget(plan.budget_bytes);
  report.threads = threads;
  report.memory_budget_bytes = plan.budget_bytes;
  report.map_buffer = plan.map_buffer;

  const Bundle bundle(options.bundle);
  const Manifest& manifest = bundle.manifest();
  report.input_path = manifest.input_name;
  report.input_vertices = manifest.input_vertices;
  report.input_faces = manifest.input_faces;
  report.repairs.nonfinite_vertices = manifest.absent_vertices;
  report.repairs.split_vertices = manifest.copied_vertices;
  report.repairs.filled_faces = manifest.filled_faces;
  report.repairs.unreferenced_vertices = manifest.input_vertices + manifest.copied_vertices -
                                         manifest.absent_vertices - manifest.topology.vertices;
  report.bbox_diagonal = manifest.diagonal;
  report.components = manifest.topology.components;
  report.boundary_loops = manifest.topology.boundary_loops;
  report.euler_characteristic = manifest.topology.euler_characteristic();
  report.base_vertices_requested = manifest.base_vertices_requested;
  report.base_vertices = bundle.base().position.size();
  report.base_faces = bundle.base().triangle.size();

  const store::TempDir temp(!options.temp_dir.empty() ? options.temp_dir
                                                      : parent_of(options.output));
  const Staged staged(options.output);
  write_output(bundle,
               {staged.path(), temp.path(), options.level, options.coarsest, threads, options.fit,
                options.measure, options.samples, options.attributes},
               plan, budget, progress, report);
  move_outputs(staged, report);
  monitor.finish(report);
  return report;
}

SurfaceError measure_files(const MeasureOptions& options, Progress& progress) {
  const unsigned threads = thread_count(options.threads);
  const MemoryPlan plan = plan_memory(options.memory_bytes, threads, 0, 0);
  MemoryBudget budget(plan.budget_bytes);
  const store::TempDir temp(options.temp_dir.empty() ? std::filesystem::temp_directory_path()
                                                     : options.temp_dir);
  const auto open = [&](const std::filesystem::path& path, const char* name) {
    std::filesystem::create_directory(temp.path() / name);
    return open_input_mesh(path, {temp.path() / name, plan.budget_bytes / 2, {}}, budget, progress)
        .reader;
  };
  const auto original = open(options.original, "weld-original");
  const auto remesh = open(options.remesh, "weld-remesh");
  progress.begin("read");
  VertexSpool original_spool(temp.path() / "original", budget);
  VertexSpool remesh_spool(temp.path() / "remesh", budget);
  original_spool.fill(*original, nullptr,
                      [&](double fraction) { progress.advance(0.5 * fraction); });
  remesh_spool.fill(*remesh, nullptr,
                    [&](double fraction) { progress.advance(0.5 + 0.5 * fraction); });
  VertexLookup original_lookup(original_spool, nullptr, plan.cache_bytes / 2, budget);
  VertexLookup remesh_lookup(remesh_spool, nullptr, plan.cache_bytes / 2, budget);
  const PolygonCutting original_cutting(*original, original_spool, plan.cache_bytes / 8, budget);
  const PolygonCutting remesh_cutting(*remesh, remesh_spool, plan.cache_bytes / 8, budget);
  SurfaceErrorOptions measure;
  measure.samples = options.samples;
  measure.threads = threads;
  measure.memory_bytes = plan.budget_bytes / 2;
  measure.progress = &progress;
  measure.original_name = options.original.string();
  measure.remesh_name = options.remesh.string();
  progress.begin("measure");
  return measure_surface_error(
      triangles_of(*original, original_lookup, {}),
      triangles_of(*remesh, remesh_lookup, remesh_spool.origin() - original_spool.origin()),
      measure);
}

}  // namespace remaps::pipeline
