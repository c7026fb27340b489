#include "remaps/pipeline/coded_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/measure/surface_error.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/codec_files.h"
#include "remaps/pipeline/memory_plan.h"
#include "remaps/pipeline/tile_surface.h"
#include "remaps/resample/dyadic_grid.h"
#include "remaps/resample/resampler.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {
namespace {

using codec::SemiRegularMesh;
using codec::SubdivisionHierarchy;

constexpr std::size_t kChunk = 8192;
/// Of the budget, what a measurement may take beside the mesh.
constexpr std::uint64_t kLeastMeasuring = std::uint64_t{8} << 20;

resample::DyadicGrid grid_of(const SemiRegularMesh& mesh) {
  return {mesh.base_vertices, mesh.base, mesh.levels};
}

/// The triangles of a mesh, moved by an offset.
TriangleSource triangles_of_mesh(const SubdivisionHierarchy& hierarchy,
                                 const std::vector<Vec3>& position, const Vec3& offset) {
  return [&hierarchy, &position, offset](TriangleSink sink) {
    std::vector<TrianglePositions> chunk;
    for (std::uint64_t i = 0; i < hierarchy.faces(); ++i) {
      const auto [a, b, c] = hierarchy.finest_face(i);
      chunk.push_back({position[a] + offset, position[b] + offset, position[c] + offset});
      if (chunk.size() == kChunk || i + 1 == hierarchy.faces()) {
        sink(chunk);
        chunk.clear();
      }
    }
  };
}

SurfaceErrorOptions error_options(const CodedSurfaceOptions& options, const MemoryBudget& budget) {
  SurfaceErrorOptions result;
  result.samples = options.samples;
  result.threads = options.threads;
  result.memory_bytes = std::max(budget.available() / 2, kLeastMeasuring);
  return result;
}

class BundleSurface final : public CodedSurface {
 public:
  BundleSurface(const CodedSurfaceOptions& options, MemoryBudget& budget, Progress& progress)
      : options_(options), bundle_(options.input) {
    const BaseMesh& base = bundle_.base();
    const std::uint64_t base_faces = base.triangle.size();
    mesh_.base_vertices = narrow<std::uint32_t>(base.position.size());
    mesh_.base = base.triangle;
    mesh_.levels = options.level.value_or(
        choose_level(bundle_.manifest().input_faces, base_faces, options.memory_bytes));
    const SubdivisionHierarchy hierarchy(mesh_.base_vertices, mesh_.base, mesh_.levels, budget);
    const std::vector<Vec3> by_grid = resample_mesh(hierarchy, budget, progress);
    mesh_.position.resize(hierarchy.vertices());
    const resample::DyadicGrid grid = grid_of(mesh_);
    for (std::uint64_t i = 0; i < hierarchy.faces(); ++i) {
      const codec::Face to = hierarchy.finest_face(i);
      const Triangle from = grid.triangle(i);
      for (std::size_t k = 0; k < 3; ++k) mesh_.position[to[k]] = by_grid[from[k]];
    }
  }

  SemiRegularMesh release_mesh() override { return std::move(mesh_); }

  double l2_error(const SemiRegularMesh& mesh, MemoryBudget& budget) const override {
    const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
    const SurfaceErrorOptions options = error_options(options_, budget);
    const TriangleSource coded =
        triangles_of_mesh(hierarchy, mesh.position, -1.0 * bundle_.manifest().origin);
    return measure_surface_error(TilePieces(bundle_.tiles()),
                                 StreamedPieces(coded, options.memory_bytes), options)
        .l2();
  }

 private:
  std::vector<Vec3> resample_mesh(const SubdivisionHierarchy& hierarchy, MemoryBudget& budget,
                                  Progress& progress) {
    const Reservation memory = budget.reserve(
        hierarchy.vertices() * 2 * std::uint64_t{sizeof(Vec3)}, "the mesh that is to be coded");
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
    std::vector<Vec3> positions;
    positions.reserve(hierarchy.vertices());
    progress.begin("resample");
    resample::resample_positions(bundle_.files(), grid_of(mesh_), resampling, budget,
                                 [&](std::span<const Vec3> part) {
                                   positions.insert(positions.end(), part.begin(), part.end());
                                 });
    return positions;
  }

  const CodedSurfaceOptions options_;
  const Bundle bundle_;
  SemiRegularMesh mesh_;
};

}  // namespace

std::unique_ptr<CodedSurface> open_coded_surface(const CodedSurfaceOptions& options,
                                                 MemoryBudget& budget, Progress& progress) {
  return std::make_unique<BundleSurface>(options, budget, progress);
}

void write_mesh(const SemiRegularMesh& mesh, const std::filesystem::path& path,
                MemoryBudget& budget, Progress& progress) {
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  const resample::DyadicGrid grid = grid_of(mesh);
  const Reservation memory =
      budget.reserve(mesh.position.size() * sizeof(Vec3), "the order of the mesh that is written");
  const auto writer = open_mesh_writer(path, grid.vertices(), grid.faces(), {.level = mesh.levels});
  {
    std::vector<Vec3> by_grid(mesh.position.size());
    for (std::uint64_t i = 0; i < hierarchy.faces(); ++i) {
      const codec::Face from = hierarchy.finest_face(i);
      const Triangle to = grid.triangle(i);
      for (std::size_t k = 0; k < 3; ++k) by_grid[to[k]] = mesh.position[from[k]];
    }
    for (std::size_t at = 0; at < by_grid.size(); at += kChunk) {
      progress.advance(0.5 * double(at) / double(by_grid.size()));
      writer->write_positions(
          std::span(by_grid).subspan(at, std::min(kChunk, by_grid.size() - at)));
    }
  }
  resample::stream_faces(grid, nullptr,
                         [&](std::span<const Triangle> faces) { writer->write_triangles(faces); });
  writer->close();
}

}  // namespace remaps::pipeline
