#include "remaps/pipeline/coded_surface.h"

#include <algorithm>
#include <vector>

#include "remaps/formats/mesh_writer.h"
#include "remaps/mesh/attributes.h"
#include "remaps/pipeline/mesh_signals.h"
#include "remaps/resample/dyadic_grid.h"
#include "remaps/resample/resampler.h"

namespace remaps::pipeline {
namespace {

using codec::SemiRegularMesh;
using codec::SubdivisionHierarchy;

constexpr std::size_t kChunk = 8192;
/// What a measurement may take, if the budget has no more left.
constexpr std::uint64_t kLeastMeasuring = std::uint64_t{8} << 20;

}  // namespace

TriangleSource triangles_of_coded(const SubdivisionHierarchy& hierarchy,
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

SurfaceErrorOptions coded_error_options(const CodedSurfaceOptions& options,
                                        const MemoryBudget& budget) {
  SurfaceErrorOptions result;
  result.samples = options.samples;
  result.threads = options.threads;
  result.memory_bytes = std::max(budget.available() / 2, kLeastMeasuring);
  return result;
}

std::unique_ptr<CodedSurface> open_coded_surface(const CodedSurfaceOptions& options,
                                                 MemoryBudget& budget, Progress& progress) {
  std::error_code ignored;
  return std::filesystem::is_directory(options.input, ignored)
             ? make_bundle_surface(options, budget, progress)
             : make_mesh_surface(options, budget, progress);
}

void write_mesh(const SemiRegularMesh& mesh, const std::filesystem::path& path,
                MemoryBudget& budget, Progress& progress) {
  const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
  const resample::DyadicGrid grid(mesh.base_vertices, mesh.base, mesh.levels);
  const Reservation memory = budget.reserve(mesh.position.size() * sizeof(std::uint32_t),
                                            "the order of the mesh that is written");
  std::vector<AttributeSpec> specs;
  std::vector<const codec::Signal*> signals;
  for (const codec::Signal& signal : mesh.signals) {
    const AttributeSpec spec = spec_of(signal.kind);
    if (!held_attributes(path, std::span(&spec, 1))[0]) continue;
    specs.push_back(spec);
    signals.push_back(&signal);
  }
  const auto writer = open_mesh_writer(path, grid.vertices(), grid.faces(), {mesh.levels, specs});
  std::vector<std::uint32_t> order(mesh.position.size());
  std::uint64_t face = 0;
  resample::stream_faces(grid, nullptr, [&](std::span<const Triangle> part) {
    for (const Triangle& to : part) {
      const codec::Face from = hierarchy.finest_face(face++);
      for (std::size_t k = 0; k < 3; ++k) order[to[k]] = from[k];
    }
  });
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
