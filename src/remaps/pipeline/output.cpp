#include "remaps/pipeline/output.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "remaps/formats/file_extension.h"
#include "remaps/formats/mesh_reader.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/measure/surface_error.h"
#include "remaps/measure/surface_pieces.h"
#include "remaps/pipeline/attribute_output.h"
#include "remaps/pipeline/output_levels.h"
#include "remaps/pipeline/run_plan.h"
#include "remaps/pipeline/tile_surface.h"
#include "remaps/pipeline/vertex_spool.h"
#include "remaps/resample/dyadic_grid.h"
#include "remaps/resample/fit.h"
#include "remaps/resample/resampler.h"

namespace remaps::pipeline {
namespace {

/// The part of resampling that is over when the positions are written; the faces are arithmetic.
constexpr double kPositionsPart = 0.97;
/// The part that is over when the finest mesh is written, where there are others.
constexpr double kFacesPart = 0.98;
/// The part of the fit that is over when it is made.
constexpr double kFitPart = 0.98;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

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

void measure_output(const Bundle& bundle, const OutputJob& job, IndexedMeshReader& reader,
                    const MemoryPlan& plan, MemoryBudget& budget, Progress& progress,
                    Report& report) {
  VertexSpool spool(job.temp_dir / "output-vertices", budget);
  spool.fill(reader, nullptr, [](double) {});
  VertexLookup lookup(spool, nullptr, plan.cache_bytes, budget);
  const TriangleSource output =
      triangles_of(reader, lookup, spool.origin() - bundle.manifest().origin);

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
  options.original_name = bundle.manifest().input_name;
  report.error = measure_surface_error(
      TilePieces(bundle.tiles()), StreamedPieces(metered_output, options.memory_bytes), options);
  report.quality = meter.result();
}

using Face = std::array<std::uint32_t, 3>;

std::vector<Face> hold_faces(const resample::DyadicGrid& grid) {
  std::vector<Face> faces;
  faces.reserve(static_cast<std::size_t>(grid.faces()));
  resample::stream_faces(grid, nullptr, [&](std::span<const Triangle> chunk) {
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

bool is_ply(const std::filesystem::path& path) {
  return lower_extension(path) == ".ply";
}

/// Writes the meshes of a job. Without --fit the output streams; with it, it is held in memory.
class OutputWriter {
 public:
  OutputWriter(const Bundle& bundle, const OutputJob& job, const resample::DyadicGrid& finest,
               const resample::ResampleOptions& options, const std::vector<AttributeSpec>& specs,
               MemoryBudget& budget)
      : bundle_(bundle),
        job_(job),
        finest_(finest),
        options_(options),
        specs_(specs),
        attributes_(bundle, specs, finest, options, budget),
        budget_(budget),
        progress_(*options.carry.progress),
        coarsest_(std::min(job.coarsest.value_or(job.level), job.level)) {
    const bool coarse_from_disk = coarsest_ < job.level && !job.fit;
    if (coarse_from_disk || (job.measure && !is_ply(path_of(job.level)))) {
      spool_.emplace(job.temp_dir / "output-positions");
    }
  }

  void write() {
    // A format that cannot hold the finest mesh refuses it now.
    const std::unique_ptr<IndexedMeshWriter> writer = open(finest_);
    if (job_.fit) {
      write_fitted(*writer);
    } else {
      write_streamed(*writer);
    }
  }

  /// The finest mesh as it was written.
  std::unique_ptr<IndexedMeshReader> read_back() const {
    return spool_ ? make_grid_reader(finest_, spool_->array())
                  : open_mesh_reader(path_of(job_.level));
  }

  /// One a level, the coarsest first.
  std::vector<Report::Output> outputs() const {
    std::vector<Report::Output> list;
    for (unsigned level = coarsest_; level <= job_.level; ++level) {
      const resample::DyadicGrid grid = grid_of(level);
      list.push_back({path_of(level).string(), level, grid.vertices(), grid.faces()});
    }
    return list;
  }

 private:
  std::filesystem::path path_of(unsigned level) const {
    return job_.coarsest ? level_path(job_.output, level) : job_.output;
  }

  resample::DyadicGrid grid_of(unsigned level) const {
    const BaseMesh& base = bundle_.base();
    return {narrow<std::uint32_t>(base.position.size()), base.triangle, level};
  }

  std::unique_ptr<IndexedMeshWriter> open(const resample::DyadicGrid& grid) const {
    return open_mesh_writer(path_of(grid.level()), grid.vertices(), grid.faces(),
                            {grid.level(), specs_});
  }

  static void write_faces(const resample::DyadicGrid& grid, Progress* progress,
                          AttributeOutput& attributes, IndexedMeshWriter& writer) {
    resample::stream_faces(grid, progress, [&](std::span<const Triangle> faces) {
      attributes.write_triangles(writer, faces);
    });
    writer.close();
  }

  /// What a coarser mesh carries: its vertices have what they have in the finest one.
  std::unique_ptr<AttributeOutput> coarse_attributes(const resample::DyadicGrid& grid) {
    auto attributes = std::make_unique<AttributeOutput>(bundle_, specs_, grid, options_, budget_);
    attributes->take_vertices(attributes_);
    const ProgressPart part(&progress_, 0, 0);
    attributes->sample_faces();
    return attributes;
  }

  void write_finest_positions(std::span<const Vec3> positions, IndexedMeshWriter& writer) {
    attributes_.write_positions(writer, positions);
    if (spool_) spool_->append(positions);
  }

  void write_streamed(IndexedMeshWriter& writer) {
    {
      const ProgressPart part(&progress_, 0, kPositionsPart);
      resample::resample_positions(
          bundle_.files(), finest_, options_, budget_,
          [&](std::span<const Vec3> positions) { write_finest_positions(positions, writer); },
          &attributes_);
      attributes_.sample_faces();
    }
    const double faces_part = coarsest_ < job_.level ? kFacesPart : 1;
    {
      const ProgressPart part(&progress_, kPositionsPart, faces_part);
      write_faces(finest_, &progress_, attributes_, writer);
    }
    for (unsigned level = coarsest_; level < job_.level; ++level) {
      // Each is four times the one before.
      const double scale = (1 - faces_part) / std::exp2(2.0 * (job_.level - 1 - level));
      const ProgressPart part(&progress_, faces_part + scale / 4, faces_part + scale);
      const resample::DyadicGrid grid = grid_of(level);
      const auto coarse = open(grid);
      const auto attributes = coarse_attributes(grid);
      send_coarse_positions(finest_, level, spool_->array(), [&](std::span<const Vec3> positions) {
        attributes->write_positions(*coarse, positions);
      });
      write_faces(grid, &progress_, *attributes, *coarse);
    }
  }

  void write_fitted(IndexedMeshWriter& writer) {
    const Reservation reservation = hold(finest_);
    std::vector<Vec3> positions;
    positions.reserve(static_cast<std::size_t>(finest_.vertices()));
    resample::ResampleOptions relative = options_;
    relative.origin = {};
    relative.as_floats = false;
    resample::resample_positions(
        bundle_.files(), finest_, relative, budget_,
        [&](std::span<const Vec3> part) {
          positions.insert(positions.end(), part.begin(), part.end());
        },
        &attributes_);
    attributes_.sample_faces();
    progress_.begin("fit");
    // The coarser ones first, while their vertices are where they lie on the surface.
    for (unsigned level = coarsest_; level < job_.level; ++level) {
      const resample::DyadicGrid grid = grid_of(level);
      const Reservation coarse_reservation = hold(grid);
      std::vector<Vec3> coarse;
      coarse.reserve(static_cast<std::size_t>(grid.vertices()));
      finest_.coarse_vertices(level, [&](std::uint64_t first, std::uint64_t count) {
        const auto run = positions.begin() + static_cast<std::ptrdiff_t>(first);
        coarse.insert(coarse.end(), run, run + static_cast<std::ptrdiff_t>(count));
      });
      fit(grid, coarse);
      const auto coarse_writer = open(grid);
      const auto attributes = coarse_attributes(grid);
      attributes->write_positions(*coarse_writer, coarse);
      write_faces(grid, nullptr, *attributes, *coarse_writer);
    }
    fit(finest_, positions);
    write_finest_positions(positions, writer);
    write_faces(finest_, nullptr, attributes_, writer);
  }

  Reservation hold(const resample::DyadicGrid& grid) const {
    return budget_.reserve(grid.vertices() * sizeof(Vec3) + grid.faces() * sizeof(Face),
                           "holding the output for --fit");
  }

  /// Moves positions relative to the origin to where the file has them.
  void fit(const resample::DyadicGrid& grid, std::vector<Vec3>& positions) {
    const unsigned below = job_.level - grid.level();
    const double end = kFitPart / std::exp2(2.0 * below);
    const ProgressPart part(&progress_, grid.level() == coarsest_ ? 0 : end / 4, end);
    resample::FitOptions options;
    options.threads = job_.threads;
    options.progress = &progress_;
    resample::fit_vertices(hold_faces(grid), triangles_of_tiles(bundle_.tiles()), options, budget_,
                           positions);
    for (Vec3& p : positions) p = options_.origin + p;
  }

  const Bundle& bundle_;
  const OutputJob& job_;
  const resample::DyadicGrid& finest_;
  const resample::ResampleOptions& options_;
  const std::vector<AttributeSpec> specs_;
  AttributeOutput attributes_;
  MemoryBudget& budget_;
  Progress& progress_;
  unsigned coarsest_;
  std::optional<OutputPositions> spool_;
};

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
  OutputWriter writer(bundle, job, grid, options, choose_attributes(bundle, job, report), budget);
  writer.write();
  report.outputs = writer.outputs();
  report.seconds_resample = seconds_since(start);
  if (!job.measure) return;
  start = std::chrono::steady_clock::now();
  progress.begin("measure");
  measure_output(bundle, job, *writer.read_back(), plan, budget, progress, report);
  report.seconds_measure = seconds_since(start);
}

}  // namespace remaps::pipeline
