#include "remaps/pipeline/remesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <thread>

#include "remaps/formats/mesh_reader.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/disk_plan.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/output.h"
#include "remaps/pipeline/parameterize.h"
#include "remaps/pipeline/resource_monitor.h"
#include "remaps/pipeline/run_plan.h"
#include "remaps/pipeline/vertex_spool.h"

namespace remaps::pipeline {
namespace {

unsigned thread_count(unsigned wanted) {
  return wanted != 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

std::filesystem::path parent_of(const std::filesystem::path& path) {
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  return whole.has_filename() ? whole.parent_path() : whole.parent_path().parent_path();
}

/// A place beside the final one, on the same file system, so that a rename finishes the job.
class Staged {
 public:
  explicit Staged(const std::filesystem::path& target)
      : target_(target), directory_(parent_of(target)) {}

  std::filesystem::path path() const { return directory_.path() / target_.filename(); }
  void file_to_target() const { std::filesystem::rename(path(), target_); }
  /// Replaces what is there; only ever called for an earlier bundle.
  void directory_to_target() const {
    const std::filesystem::path old = directory_.path() / "replaced";
    if (std::filesystem::exists(target_)) std::filesystem::rename(target_, old);
    std::filesystem::rename(path(), target_);
  }

 private:
  std::filesystem::path target_;
  store::TempDir directory_;
};

std::filesystem::path without_slash(const std::filesystem::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

void check_bundle_target(const std::filesystem::path& bundle) {
  if (!std::filesystem::exists(bundle)) return;
  const bool replaceable =
      std::filesystem::is_directory(bundle) &&
      (std::filesystem::exists(bundle / kManifestName) || std::filesystem::is_empty(bundle));
  if (!replaceable)
    throw IoError(bundle.string() + ": exists and is not a bundle; it is left alone");
}

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
  std::filesystem::create_directory(bundle_path);

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
  job.write_map = has_bundle;
  parameterize(job, plan, budget, progress, report);
  if (has_output) {
    const Bundle bundle(bundle_path);
    write_output(bundle,
                 {staged_output->path(), temp.path(), options.level, threads, options.fit,
                  options.measure, options.samples},
                 plan, budget, progress, report);
  }
  progress.check();
  if (has_bundle) staged_bundle->directory_to_target();
  if (has_output) {
    report.bytes_written += std::filesystem::file_size(staged_output->path());
    staged_output->file_to_target();
    report.output_path = options.output.string();
  }
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
  report.input_faces = manifest.topology.faces;
  report.unreferenced_vertices = manifest.input_vertices - manifest.topology.vertices;
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
               {staged.path(), temp.path(), options.level, threads, options.fit, options.measure,
                options.samples},
               plan, budget, progress, report);
  report.bytes_written += std::filesystem::file_size(staged.path());
  staged.file_to_target();
  report.output_path = options.output.string();
  monitor.finish(report);
  return report;
}

SurfaceError measure_files(const MeasureOptions& options, Progress& progress) {
  const unsigned threads = thread_count(options.threads);
  const MemoryPlan plan = plan_memory(options.memory_bytes, threads, 0, 0);
  MemoryBudget budget(plan.budget_bytes);
  const store::TempDir temp(options.temp_dir.empty() ? std::filesystem::temp_directory_path()
                                                     : options.temp_dir);
  progress.begin("read");
  const auto original = open_mesh_reader(options.original);
  const auto remesh = open_mesh_reader(options.remesh);
  VertexSpool original_spool(temp.path() / "original");
  VertexSpool remesh_spool(temp.path() / "remesh");
  original_spool.fill(*original, nullptr,
                      [&](double fraction) { progress.advance(0.5 * fraction); });
  remesh_spool.fill(*remesh, nullptr,
                    [&](double fraction) { progress.advance(0.5 + 0.5 * fraction); });
  VertexLookup original_lookup(original_spool, nullptr, plan.cache_bytes / 2, budget);
  VertexLookup remesh_lookup(remesh_spool, nullptr, plan.cache_bytes / 2, budget);
  SurfaceErrorOptions measure;
  measure.samples = options.samples;
  measure.threads = threads;
  measure.memory_bytes = plan.budget_bytes / 2;
  measure.progress = &progress;
  progress.begin("measure");
  return measure_surface_error(
      triangles_of(*original, original_lookup, {}),
      triangles_of(*remesh, remesh_lookup, remesh_spool.origin() - original_spool.origin()),
      measure);
}

}  // namespace remaps::pipeline
