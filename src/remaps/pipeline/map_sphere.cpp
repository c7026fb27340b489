#include "remaps/pipeline/map_sphere.h"

#include <algorithm>
#include <thread>

#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/staged.h"

namespace remaps::pipeline {
namespace {

bool is_bundle(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

/// The same files under another name; the sphere's own are left out. Copies where links cannot be.
void link_bundle(const std::filesystem::path& from, const std::filesystem::path& to) {
  read_manifest(from);  // or says that it is none
  std::filesystem::create_directory(to);
  for (const auto& entry : std::filesystem::directory_iterator(from)) {
    const std::filesystem::path name = entry.path().filename();
    if (!entry.is_regular_file() || name.string().starts_with("sphere")) continue;
    std::error_code failed;
    std::filesystem::create_hard_link(entry.path(), to / name, failed);
    if (failed) std::filesystem::copy_file(entry.path(), to / name);
  }
}

/// Of several components it is not known yet which the largest is: those are looked at in the end.
void refuse_early(const Topology& topology) {
  if (topology.components != 1) return;
  check_is_sphere(
      {topology.faces, topology.vertices, topology.boundary_loops, topology.euler_characteristic()},
      0, 1);
}

void parameterize_mesh(const MapSphereOptions& options, const std::filesystem::path& bundle,
                       Progress& progress) {
  RemeshOptions job = options.parameterize;
  job.input = options.input;
  job.output.clear();
  job.bundle = bundle;
  job.base_vertices = std::max<std::uint64_t>(options.intermediate_faces / 2 + 2, 4);
  job.accept = refuse_early;
  remesh(job, progress);
}

}  // namespace

MapSphereSummary map_to_sphere(const MapSphereOptions& options, Progress& progress) {
  const std::filesystem::path target = without_slash(options.output);
  check_bundle_target(target);
  const Staged staged(target);
  if (is_bundle(options.input)) {
    link_bundle(options.input, staged.path());
  } else {
    parameterize_mesh(options, staged.path(), progress);
  }
  MapSphereSummary result;
  {
    const Bundle bundle(staged.path());
    const unsigned threads = options.parameterize.threads != 0
                                 ? options.parameterize.threads
                                 : std::max(1u, std::thread::hardware_concurrency());
    MemoryBudget budget(plan_memory(options.parameterize.memory_bytes, threads, 0, 0).budget_bytes);
    result.sphere = add_sphere(bundle, options.all_components, budget, progress);
    result.input_vertices = bundle.manifest().input_vertices;
    result.base_components = bundle.manifest().topology.components;
  }
  progress.check();
  staged.directory_to_target();
  return result;
}

}  // namespace remaps::pipeline
