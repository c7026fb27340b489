#include <algorithm>
#include <utility>
#include <vector>

#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/measure/surface_error.h"
#include "remaps/mesh/attributes.h"
#include "remaps/pipeline/attribute_output.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/codec_files.h"
#include "remaps/pipeline/coded_surface.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/mesh_signals.h"
#include "remaps/pipeline/tile_surface.h"
#include "remaps/resample/dyadic_grid.h"
#include "remaps/resample/resampler.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {
namespace {

using codec::SemiRegularMesh;
using codec::SubdivisionHierarchy;

/// The mesh that a bundle's map gives, beside the input itself.
class BundleSurface final : public CodedSurface {
 public:
  BundleSurface(const CodedSurfaceOptions& options, MemoryBudget& budget, Progress& progress)
      : options_(options), bundle_(options.input) {
    const BaseMesh& base = bundle_.base();
    mesh_.base_vertices = narrow<std::uint32_t>(base.position.size());
    mesh_.base = base.triangle;
    mesh_.levels = options.level.value_or(
        choose_level(bundle_.manifest().input_faces, base.triangle.size(), options.memory_bytes));
    const SubdivisionHierarchy hierarchy(mesh_.base_vertices, mesh_.base, mesh_.levels, budget);
    const MeshCollector by_grid = resample_mesh(hierarchy, budget, progress);
    mesh_.position.resize(hierarchy.vertices());
    for (const codec::Signal& signal : by_grid.signals) {
      mesh_.signals.push_back({signal.kind, std::vector<Vec3>(hierarchy.vertices())});
    }
    const resample::DyadicGrid grid(mesh_.base_vertices, mesh_.base, mesh_.levels);
    std::uint64_t face = 0;
    resample::stream_faces(grid, nullptr, [&](std::span<const Triangle> part) {
      for (const Triangle& from : part) {
        const codec::Face to = hierarchy.finest_face(face++);
        for (std::size_t k = 0; k < 3; ++k) {
          mesh_.position[to[k]] = by_grid.positions[from[k]];
          for (std::size_t s = 0; s < mesh_.signals.size(); ++s) {
            mesh_.signals[s].value[to[k]] = by_grid.signals[s].value[from[k]];
          }
        }
      }
    });
  }

  SemiRegularMesh release_mesh() override { return std::move(mesh_); }

  double l2_error(const SemiRegularMesh& mesh, MemoryBudget& budget) const override {
    const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
    const SurfaceErrorOptions options = coded_error_options(options_, budget);
    const TriangleSource coded =
        triangles_of_coded(hierarchy, mesh.position, -1.0 * bundle_.manifest().origin);
    return measure_surface_error(TilePieces(bundle_.tiles()),
                                 StreamedPieces(coded, options.memory_bytes), options)
        .l2();
  }

 private:
  MeshCollector resample_mesh(const SubdivisionHierarchy& hierarchy, MemoryBudget& budget,
                              Progress& progress) {
    std::vector<AttributeSpec> specs = choose_signals(
        options_.attributes, bundle_.manifest().attributes.specs, bundle_.manifest().input_name);
    // Twice: in the order of the grid, and in that of the hierarchy.
    const Reservation memory =
        budget.reserve(hierarchy.vertices() * 2 * (1 + specs.size()) * std::uint64_t{sizeof(Vec3)},
                       "the mesh that is to be coded");
    const MemoryPlan plan = plan_memory(budget.available(), options_.threads, 0, 0);
    const store::TempDir temp(options_.temp_dir.empty() ? std::filesystem::temp_directory_path()
                                                        : options_.temp_dir);
    resample::ResampleOptions resampling;
    resampling.carry.threads = options_.threads;
    resampling.carry.map_buffer = plan.map_buffer;
    resampling.carry.progress = &progress;
    resampling.buffer_bytes = 2 * plan.bucket_bytes;
    resampling.temp_dir = temp.path();
    resampling.origin = bundle_.manifest().origin;
    const resample::DyadicGrid grid(mesh_.base_vertices, mesh_.base, mesh_.levels);
    MeshCollector collector(specs, hierarchy.vertices());
    AttributeOutput attributes(bundle_, std::move(specs), grid, resampling, budget);
    progress.begin("resample");
    resample::resample_positions(
        bundle_.files(), grid, resampling, budget,
        [&](std::span<const Vec3> part) { attributes.write_positions(collector, part); },
        &attributes);
    return collector;
  }

  const CodedSurfaceOptions options_;
  const Bundle bundle_;
  SemiRegularMesh mesh_;
};

}  // namespace

std::unique_ptr<CodedSurface> make_bundle_surface(const CodedSurfaceOptions& options,
                                                  MemoryBudget& budget, Progress& progress) {
  return std::make_unique<BundleSurface>(options, budget, progress);
}

}  // namespace remaps::pipeline
