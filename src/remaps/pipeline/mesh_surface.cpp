#include <algorithm>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/codec/subdivision_recovery.h"
#include "remaps/measure/surface_error.h"
#include "remaps/pipeline/coded_surface.h"
#include "remaps/pipeline/input_mesh.h"
#include "remaps/pipeline/mesh_signals.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {
namespace {

using codec::SemiRegularMesh;
using codec::SubdivisionHierarchy;

/// A mesh file of any program whose faces are those of a subdivided base.
class MeshSurface final : public CodedSurface {
 public:
  MeshSurface(const CodedSurfaceOptions& options, MemoryBudget& budget, Progress& progress)
      : options_(options) {
    const store::TempDir temp(options.temp_dir.empty() ? std::filesystem::temp_directory_path()
                                                       : options.temp_dir);
    const InputMesh input = open_input_mesh(
        options.input, {temp.path(), options.memory_bytes / 2, {}}, budget, progress);
    progress.begin("read");
    std::vector<codec::Face> faces;
    const MeshCollector mesh = read(*input.reader, faces, budget);
    progress.begin("find levels");
    codec::SemiRegularConnectivity found = recover(mesh, faces, budget);
    faces = {};
    mesh_.base_vertices = found.base_vertices;
    mesh_.base = std::move(found.base);
    mesh_.levels = found.levels;
    if (options.level) mesh_.levels = std::min(*options.level, found.levels);
    // Coarser levels have the first of the vertices.
    const SubdivisionHierarchy hierarchy(mesh_.base_vertices, mesh_.base, mesh_.levels, budget);
    found.vertex.resize(hierarchy.vertices());
    mesh_.position = in_order(mesh.positions, found.vertex);
    for (const codec::Signal& signal : mesh.signals) {
      mesh_.signals.push_back({signal.kind, in_order(signal.value, found.vertex)});
    }
    reference_base_ = mesh_.base;
    reference_ = mesh_.position;
  }

  SemiRegularMesh release_mesh() override { return std::move(mesh_); }

  double l2_error(const SemiRegularMesh& mesh, MemoryBudget& budget) const override {
    const SubdivisionHierarchy original(mesh.base_vertices, reference_base_, mesh.levels, budget);
    const SubdivisionHierarchy hierarchy(mesh.base_vertices, mesh.base, mesh.levels, budget);
    const SurfaceErrorOptions options = coded_error_options(options_, budget);
    const TriangleSource here = triangles_of_coded(original, reference_, {});
    const TriangleSource there = triangles_of_coded(hierarchy, mesh.position, {});
    return measure_surface_error(StreamedPieces(here, options.memory_bytes),
                                 StreamedPieces(there, options.memory_bytes), options)
        .l2();
  }

 private:
  /// Counts, reserves, reads.
  MeshCollector read(IndexedMeshReader& reader, std::vector<codec::Face>& faces,
                     MemoryBudget& budget) {
    std::uint64_t vertices = 0, triangles = 0;
    reader.read_positions([&](std::span<const Vec3> part) { vertices += part.size(); });
    reader.read_triangles([&](std::span<const Triangle> part) { triangles += part.size(); });
    if (vertices > kNoIndex) {
      throw GeometryError(options_.input.string() + ": too many vertices for one archive");
    }
    std::vector<AttributeSpec> specs =
        choose_signals(options_.attributes, reader.attributes(), options_.input.string());
    // Values as they are read, in the order of the archive, and for comparison.
    memory_ = budget.reserve(
        vertices * (2 * specs.size() + 3) * sizeof(Vec3) + triangles * sizeof(codec::Face),
        "the mesh that is to be coded");
    faces.reserve(triangles);
    MeshCollector mesh(specs, vertices);
    reader.read_positions([&](std::span<const Vec3> part) { mesh.write_positions(part); });
    reader.read_triangles([&](std::span<const Triangle> part) {
      for (const Triangle& t : part) {
        faces.push_back({narrow<std::uint32_t>(t[0]), narrow<std::uint32_t>(t[1]),
                         narrow<std::uint32_t>(t[2])});
      }
    });
    if (!specs.empty()) read_signals(reader, specs, mesh);
    return mesh;
  }

  /// The reader sends the values of all attributes; the chosen ones are some of them.
  static void read_signals(IndexedMeshReader& reader, std::span<const AttributeSpec> specs,
                           MeshCollector& mesh) {
    const std::vector<AttributeSpec> all =
        attributes_per(reader.attributes(), AttributePer::vertex);
    std::vector<double> chosen;
    const std::size_t width = channels(all, AttributePer::vertex);
    reader.read_attributes(AttributePer::vertex, [&](std::span<const double> rows) {
      for (; !rows.empty(); rows = rows.subspan(width)) {
        chosen.clear();
        std::span<const double> left = rows.first(width);
        for (const AttributeSpec& spec : all) {
          const auto values = left.first(spec.components.size());
          left = left.subspan(values.size());
          if (std::find(specs.begin(), specs.end(), spec) != specs.end()) {
            chosen.insert(chosen.end(), values.begin(), values.end());
          }
        }
        mesh.take(chosen);
      }
    });
  }

  codec::SemiRegularConnectivity recover(const MeshCollector& mesh,
                                         std::span<const codec::Face> faces,
                                         MemoryBudget& budget) const {
    try {
      return codec::recover_subdivision(static_cast<std::uint32_t>(mesh.positions.size()), faces, 1,
                                        SubdivisionHierarchy::kMostLevels, budget);
    } catch (const GeometryError& error) {
      throw GeometryError(options_.input.string() + ": " + error.what() +
                          "; remesh it first (remaps remesh --bundle), and encode the bundle");
    }
  }

  static std::vector<Vec3> in_order(const std::vector<Vec3>& values,
                                    std::span<const std::uint32_t> order) {
    std::vector<Vec3> result;
    result.reserve(order.size());
    for (const std::uint32_t v : order) result.push_back(values[v]);
    return result;
  }

  const CodedSurfaceOptions options_;
  Reservation memory_;
  SemiRegularMesh mesh_;
  std::vector<codec::Face> reference_base_;
  std::vector<Vec3> reference_;
};

}  // namespace

std::unique_ptr<CodedSurface> make_mesh_surface(const CodedSurfaceOptions& options,
                                                MemoryBudget& budget, Progress& progress) {
  return std::make_unique<MeshSurface>(options, budget, progress);
}

}  // namespace remaps::pipeline
