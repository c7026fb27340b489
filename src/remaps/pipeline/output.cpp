#include "remaps/pipeline/output.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "remaps/base/workers.h"
#include "remaps/formats/mesh_reader.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/measure/surface_error.h"
#include "remaps/measure/surface_pieces.h"
#include "remaps/pipeline/attribute_output.h"
#include "remaps/pipeline/run_plan.h"
#include "remaps/pipeline/vertex_spool.h"
#include "remaps/resample/dyadic_grid.h"
#include "remaps/resample/fit.h"
#include "remaps/resample/resampler.h"

namespace remaps::pipeline {
namespace {

/// The part of resampling that is over when the positions are written; the faces are arithmetic.
constexpr double kPositionsPart = 0.97;
/// The part of the fit that is over when it is made.
constexpr double kFitPart = 0.98;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The input surface from the tiles, in order of place.
TriangleSource triangles_of_tiles(const store::SectionFile& tiles) {
  return [&tiles](TriangleSink sink) {
    store::Bytes bytes;
    Tile tile;
    std::vector<TrianglePositions> triangles;
    for (std::size_t i = 0; i < tiles.sections(); ++i) {
      tiles.read(i, bytes);
      decode_tile(bytes, tiles.path().string() + ": tile " + std::to_string(i), tile);
      triangles.clear();
      for (const auto& t : tile.triangle) {
        triangles.push_back(
            {widen(tile.position[t[0]]), widen(tile.position[t[1]]), widen(tile.position[t[2]])});
      }
      sink(triangles);
    }
  };
}

/// The input surface, a tile a piece.
class TilePieces final : public SurfacePieces {
 public:
  explicit TilePieces(const store::SectionFile& tiles) : tiles_(tiles) {}

  void stream(unsigned threads, FunctionRef<bool(std::size_t piece)> wanted,
              const Work& work) const override {
    std::vector<Lane> lanes(std::max(threads, 1u));
    run_ordered(tiles_.sections(), threads, [&](std::size_t i, unsigned number) -> Commit {
      if (!wanted(i)) return [] {};
      Lane& lane = lanes[number];
      tiles_.read(i, lane.bytes);
      decode_tile_surface(lane.bytes, tiles_.path().string() + ": tile " + std::to_string(i),
                          lane.tile);
      lane.piece.clear();
      for (const Vec3f& p : lane.tile.position) lane.piece.position.push_back(widen(p));
      lane.piece.triangle.swap(lane.tile.triangle);
      return work(i, lane.piece, number);
    });
  }

 private:
  struct Lane {
    store::Bytes bytes;
    Tile tile;
    SurfacePiece piece;
  };

  const store::SectionFile& tiles_;
};

/// Sums up the quality of the map from the faces of the semi-regular mesh, which come base face by
/// base face.
class QualityMeter {
 public:
  explicit QualityMeter(unsigned level) : shift_(2 * level) {}

  void add(std::span<const TrianglePositions> triangles) {
    for (const TrianglePositions& t : triangles) {
      const double area = 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
      const double squared_edges = norm2(t[1] - t[0]) + norm2(t[2] - t[1]) + norm2(t[0] - t[2]);
      const auto face = static_cast<std::size_t>(count_++ >> shift_);
      if (face == area_.size()) area_.push_back(0);
      area_[face] += area;
      total_ += area;
      stretch_ += area * squared_edges /
                  3;  // [Sander et al. 2001], reference: equilateral with edges of length 1
    }
  }

  Report::Quality result() {
    Report::Quality quality;
    if (area_.empty() || !(total_ > 0)) return quality;
    const double reference = double(count_) * std::sqrt(3.0) / 4;
    quality.l2_stretch = std::sqrt(stretch_ / total_) * std::sqrt(reference / total_);
    const auto middle = area_.begin() + std::ptrdiff_t(area_.size() / 2);
    std::nth_element(area_.begin(), middle, area_.end());
    const double median = *middle;
    quality.area_ratio = median > 0 ? *std::max_element(area_.begin(), area_.end()) / median : 0;
    return quality;
  }

 private:
  unsigned shift_;
  std::uint64_t count_ = 0;
  double total_ = 0;
  double stretch_ = 0;
  std::vector<double> area_;
};

void measure_output(const Bundle& bundle, const OutputJob& job, const MemoryPlan& plan,
                    MemoryBudget& budget, Progress& progress, Report& report) {
  const auto reader = open_mesh_reader(job.output);
  VertexSpool spool(job.temp_dir / "output-vertices");
  spool.fill(*reader, nullptr, [](double) {});
  VertexLookup lookup(spool, nullptr, plan.cache_bytes, budget);
  const TriangleSource output =
      triangles_of(*reader, lookup, spool.origin() - bundle.manifest().origin);

  // The first pass over the output is also that of the meter.
  QualityMeter meter(job.level);
  bool metered = false;
  const TriangleSource metered_output = [&](TriangleSink sink) {
    output([&](std::span<const TrianglePositions> triangles) {
      if (!metered) meter.add(triangles);
      sink(triangles);
    });
    metered = true;
  };

  SurfaceErrorOptions options;
  options.samples = job.samples;
  options.threads = job.threads;
  options.memory_bytes = std::max<std::uint64_t>(plan.budget_bytes / 2, 8 << 20);
  options.progress = &progress;
  report.error = measure_surface_error(
      TilePieces(bundle.tiles()), StreamedPieces(metered_output, options.memory_bytes), options);
  report.quality = meter.result();
}

std::vector<std::array<std::uint32_t, 3>> hold_faces(const resample::DyadicGrid& grid,
                                                     Progress* progress) {
  const ProgressPart part(progress, kPositionsPart, 1);
  std::vector<std::array<std::uint32_t, 3>> faces;
  faces.reserve(static_cast<std::size_t>(grid.faces()));
  resample::stream_faces(grid, progress, [&](std::span<const Triangle> chunk) {
    for (const Triangle& t : chunk) {
      faces.push_back(
          {narrow<std::uint32_t>(t[0]), narrow<std::uint32_t>(t[1]), narrow<std::uint32_t>(t[2])});
    }
  });
  return faces;
}

/// The attributes that are wanted and that the format of the output holds. The report tells of the
/// others too.
std::vector<AttributeSpec> choose_attributes(const Bundle& bundle, const OutputJob& job,
                                             Report& report) {
  std::vector<AttributeSpec> held;
  const std::vector<AttributeSpec> chosen =
      job.attributes.choose(bundle.manifest().attributes.specs, bundle.manifest().input_name);
  report.attributes.clear();
  for (const AttributeSpec& spec : chosen) {
    const bool holds = holds_attribute(job.output, spec);
    report.attributes.push_back(
        {spec.name, std::string(name_of(spec.kind)), std::string(name_of(spec.per)), holds});
    if (holds) held.push_back(spec);
  }
  return held;
}

/// Resamples, fits and writes: with --fit the output is held in memory, otherwise it streams.
void write_mesh(const Bundle& bundle, const OutputJob& job, const resample::DyadicGrid& grid,
                const resample::ResampleOptions& options, MemoryBudget& budget,
                AttributeOutput& attributes, IndexedMeshWriter& writer) {
  Progress* const progress = options.carry.progress;
  const auto write_faces = [&](std::span<const Triangle> faces) {
    attributes.write_triangles(writer, faces);
  };
  std::optional<ProgressPart> positions_part(std::in_place, progress, 0, kPositionsPart);
  if (!job.fit) {
    resample::resample_positions(
        bundle.files(), grid, options, budget,
        [&](std::span<const Vec3> positions) { attributes.write_positions(writer, positions); },
        &attributes);
    attributes.sample_faces();
    positions_part.reset();
    const ProgressPart part(progress, kPositionsPart, 1);
    resample::stream_faces(grid, progress, write_faces);
    return;
  }
  using Face = std::array<std::uint32_t, 3>;
  const Reservation reservation = budget.reserve(
      grid.vertices() * sizeof(Vec3) + grid.faces() * sizeof(Face), "holding the output for --fit");
  std::vector<Vec3> positions;
  positions.reserve(static_cast<std::size_t>(grid.vertices()));
  resample::ResampleOptions relative = options;
  relative.origin = {};
  relative.as_floats = false;
  resample::resample_positions(
      bundle.files(), grid, relative, budget,
      [&](std::span<const Vec3> part) {
        positions.insert(positions.end(), part.begin(), part.end());
      },
      &attributes);
  attributes.sample_faces();
  positions_part.reset();
  const std::vector<Face> faces = hold_faces(grid, progress);
  resample::FitOptions fit;
  fit.threads = job.threads;
  fit.progress = progress;
  if (progress != nullptr) progress->begin("fit");
  {
    const ProgressPart part(progress, 0, kFitPart);
    resample::fit_vertices(faces, triangles_of_tiles(bundle.tiles()), fit, budget, positions);
  }
  const ProgressPart part(progress, kFitPart, 1);
  for (Vec3& p : positions) p = options.origin + p;
  attributes.write_positions(writer, positions);
  resample::stream_faces(grid, progress, write_faces);
}

}  // namespace

void write_output(const Bundle& bundle, const OutputJob& job, const MemoryPlan& plan,
                  MemoryBudget& budget, Progress& progress, Report& report) {
  auto start = std::chrono::steady_clock::now();
  const BaseMesh& base = bundle.base();
  const resample::DyadicGrid grid(narrow<std::uint32_t>(base.position.size()), base.triangle,
                                  job.level);
  progress.plan(expect_output(
      {bundle.manifest().input_vertices, grid.vertices(), job.fit, job.measure, job.samples}));
  progress.begin("resample");
  report.level = job.level;
  report.output_vertices = grid.vertices();
  report.output_faces = grid.faces();
  resample::ResampleOptions options;
  options.carry.threads = job.threads;
  options.carry.map_buffer = plan.map_buffer;
  options.carry.progress = &progress;
  options.buffer_bytes = 2 * plan.bucket_bytes;  // nothing else is in memory meanwhile
  options.as_floats = true;                      // as the file has them
  options.temp_dir = job.temp_dir;
  options.origin = bundle.manifest().origin;
  AttributeOutput attributes(bundle, choose_attributes(bundle, job, report), grid, options, budget);
  const auto writer =
      open_mesh_writer(job.output, grid.vertices(), grid.faces(), attributes.specs());
  write_mesh(bundle, job, grid, options, budget, attributes, *writer);
  writer->close();
  report.seconds_resample = seconds_since(start);
  if (!job.measure) return;
  start = std::chrono::steady_clock::now();
  progress.begin("measure");
  measure_output(bundle, job, plan, budget, progress, report);
  report.seconds_measure = seconds_since(start);
}

}  // namespace remaps::pipeline
