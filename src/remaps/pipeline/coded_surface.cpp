#include "remaps/pipeline/coded_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/measure/surface_error.h"
#include "remaps/mesh/attributes.h"
#include "remaps/pipeline/attribute_output.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/codec_files.h"
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

constexpr std::size_t kChunk = 8192;
/// What a measurement may take, if the budget has no more left.
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
    const resample::DyadicGrid grid = grid_of(mesh_);
    for (std::uint64_t i = 0; i < hierarchy.faces(); ++i) {
      const codec::Face to = hierarchy.finest_face(i);
      const Triangle from = grid.triangle(i);
      for (std::size_t k = 0; k < 3; ++k) {
        mesh_.position[to[k]] = by_grid.positions[from[k]];
        for (std::size_t s = 0; s < mesh_.signals.size(); ++s) {
          mesh_.signals[s].value[to[k]] = by_grid.signals[s].value[from[k]];
        }
      }
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
    const resample::DyadicGrid grid = grid_of(mesh_);
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

std::unique_ptr<CodedSurface> open_coded_surface(const CodedSurfaceOptions& options,
                                                 MemoryBudget& budget, Progress& progress) {
  return std::make_unique<BundleSurface>(options, budget, progress);
}

void write_mesh(const SemiRegularMesh& mesh, const std::filesystem::path& path,
                MemoryBudget& budget, Progress& progress) {
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  const resample::DyadicGrid grid = grid_of(mesh);
  const Reservation memory = budget.reserve(mesh.position.size() * sizeof(std::uint32_t),
                                            "the order of the mesh that is written");
  std::vector<AttributeSpec> specs;
  std::vector<const codec::Signal*> signals;
  for (const codec::Signal& signal : mesh.signals) {
    const AttributeSpec spec = spec_of(signal.kind);
    if (!holds_attribute(path, spec)) continue;
    specs.push_back(spec);
    signals.push_back(&signal);
  }
  const auto writer = open_mesh_writer(path, grid.vertices(), grid.faces(), {mesh.levels, specs});
  std::vector<std::uint32_t> order(mesh.position.size());
  for (std::uint64_t i = 0; i < hierarchy.faces(); ++i) {
    const codec::Face from = hierarchy.finest_face(i);
    const Triangle to = grid.triangle(i);
    for (std::size_t k = 0; k < 3; ++k) order[to[k]] = from[k];
  }
  std::vector<Vec3> positions;
  std::vector<std::byte> rows;
  for (std::size_t at = 0; at < order.size(); at += kChunk) {
    progress.advance(0.5 * double(at) / double(order.size()));
    const auto part = std::span(order).subspan(at, std::min(kChunk, order.size() - at));
    positions.clear();
    for (const std::uint32_t v : part) positions.push_back(mesh.position[v]);
    writer->write_positions(positions);
    if (specs.empty()) continue;
    pack_signals(part, signals, specs, rows);
    writer->write_attributes(AttributePer::vertex, rows);
  }
  resample::stream_faces(grid, nullptr,
                         [&](std::span<const Triangle> faces) { writer->write_triangles(faces); });
  writer->close();
}

}  // namespace remaps::pipeline
