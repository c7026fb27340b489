#include "remaps/pipeline/parameterize.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "remaps/map/base_carrier.h"
#include "remaps/pipeline/attribute_store.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/ingest.h"
#include "remaps/pipeline/input_mesh.h"
#include "remaps/pipeline/map_file.h"
#include "remaps/pipeline/repair_input.h"
#include "remaps/pipeline/run_plan.h"
#include "remaps/pipeline/vertex_spool.h"
#include "remaps/simplify/sweep.h"

namespace remaps::pipeline {
namespace {

/// Fraction of a segment's vertices that a sweep keeps at least.
constexpr double kKeep = 0.1;
/// The last sweep runs in core; it does best when this many times the base is left to it
/// (docs/design/sweeps.md).
constexpr double kLeftToLastSweep = 30;

/// Levels with more vertices for each of the base are ranked by estimate
/// (docs/design/removal-order.md).
constexpr std::uint64_t kDraftAbove = 300;

/// The part of the map phase that is over when all vertices are on the base.
constexpr double kMapCarried = 0.95;

constexpr const char* kWithoutStrict = "without --strict that is repaired, and counted";

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Parameterizer {
 public:
  Parameterizer(const ParameterizeJob& job, const MemoryPlan& plan, MemoryBudget& budget,
                Progress& progress, Report& report)
      : job_(job), plan_(plan), budget_(budget), progress_(progress), report_(report) {}

  void run() {
    if (2 * job_.base_vertices > plan_.domain_buffer) {
      throw BudgetError(
          fmt::format("{} base vertices need a domain buffer of at least {} faces; it has {}. Give "
                      "--memory {}M or more, or a larger "
                      "--domain-buffer",
                      job_.base_vertices, 2 * job_.base_vertices, plan_.domain_buffer,
                      (4 * job_.base_vertices * kBytesPerFace >> 20) + 1));
    }
    report_.repairs = {};
    plan_phases(guess_vertices(job_.input));
    read_input();
    if (job_.repair.any()) repair_input();
    try {
      sweep_to_base();
    } catch (const simplify::NotManifold& defect) {
      // Found out here, and not looked for before, since most inputs are sound.
      if (job_.strict) throw GeometryError(fmt::format("{}; {}", defect.what(), kWithoutStrict));
      if (repaired_) throw;
      start_again();
      sweep_to_base();
    }
    if (job_.write_map) {
      const auto start = std::chrono::steady_clock::now();
      map_vertices();
      report_.seconds_map = seconds_since(start);
    }
    seal();
  }

 private:
  void read_input() {
    const auto start = std::chrono::steady_clock::now();
    const InputMesh input = open_input_mesh(
        job_.input,
        {job_.temp_dir, plan_.budget_bytes / 2, job_.weld_distance, job_.feature_labels}, budget_,
        progress_);
    manifest_.feature_labels = input.label_names;
    report_.repairs.welded_vertices = input.welded_vertices;
    ingested_ = ingest(*input.reader, job_.input.string(), plan_, job_.temp_dir, job_.threads,
                       budget_, progress_, input.face_labels.get());
    store_input_attributes(*input.reader);
    ingested_.positions.reset();
    report_.bytes_read += input.reader->bytes_read_total();
    report_.input_path = job_.input.string();
    report_.input_vertices = ingested_.vertices;
    report_.input_faces = ingested_.faces;
    report_.bbox_diagonal = ingested_.diagonal;
    manifest_.input_name = job_.input.filename().string();
    manifest_.input_vertices = ingested_.vertices;
    manifest_.input_faces = ingested_.faces;
    manifest_.absent_vertices = ingested_.nonfinite_vertices;
    note_left_out();
    report_.seconds_ingest += seconds_since(start);
    manifest_.origin = ingested_.origin;
    manifest_.diagonal = ingested_.diagonal;
    manifest_.base_vertices_requested = job_.base_vertices;
    manifest_.feature_angle_deg = job_.feature_angle_deg;
  }

  /// Counts what ingest left out, or refuses it.
  void note_left_out() {
    Repairs& repairs = report_.repairs;
    repairs.nonfinite_vertices = ingested_.nonfinite_vertices;
    repairs.nonfinite_faces = ingested_.nonfinite_faces;
    repairs.degenerate_faces = ingested_.degenerate_faces;
    if (!job_.strict) return;
    if (repairs.nonfinite_vertices > 0) {
      const std::string face = repairs.nonfinite_faces == 0
                                   ? "in no face"
                                   : fmt::format("face {} has one", ingested_.first_nonfinite_face);
      throw GeometryError(
          fmt::format("{}: {} vertices are not finite, vertex {} first, {} (from "
                      "0); {}",
                      job_.input.string(), repairs.nonfinite_vertices,
                      ingested_.first_nonfinite.front(), face, kWithoutStrict));
    }
    if (repairs.degenerate_faces > 0) {
      throw GeometryError(
          fmt::format("{}: {} faces have a vertex twice, face {} has vertex {} so (from 0); {}",
                      job_.input.string(), repairs.degenerate_faces, ingested_.first_degenerate,
                      ingested_.twice, kWithoutStrict));
    }
  }

  /// Reads the input again, since the sweep that found it unsound has used it up, and repairs it.
  void start_again() {
    report_.sweeps.clear();
    manifest_.segments.clear();
    ingested_ = {};
    progress_.plan({expect_ingest(report_.input_vertices), expect_repair(report_.input_vertices)});
    read_input();
    repair_input();
  }

  void repair_input() {
    const auto start = std::chrono::steady_clock::now();
    repaired_ = true;
    const repair::Findings found = pipeline::repair_input(
        ingested_, job_.repair, plan_, job_.temp_dir, budget_, progress_, report_.repairs);
    if (!found.one_sided.empty()) {
      throw GeometryError(fmt::format(
          "{}: the surface cannot be oriented: it has one side only, like a Moebius strip, which "
          "shows at {} (counted from 0). Cut it open there first",
          job_.input.string(), found.one_sided));
    }
    if (ingested_.level->faces() == 0) {
      throw GeometryError(fmt::format("{}: no component has {} faces (--min-component)",
                                      job_.input.string(), job_.repair.min_component));
    }
    manifest_.copied_vertices = ingested_.copied_vertices;
    if (!manifest_.attributes.specs.empty() && ingested_.copied_vertices > 0) {
      store_copies(*ingested_.originals, ingested_.copied_vertices, job_.bundle / kCopiesName);
      manifest_.attributes.copies = ingested_.copied_vertices;
    }
    manifest_.filled_faces = ingested_.filled_faces;
    report_.seconds_ingest += seconds_since(start);
  }

  /// Names that are not there are refused before the sweeps.
  void store_input_attributes(IndexedMeshReader& reader) {
    if (job_.attributes.none() || !manifest_.attributes.specs.empty()) return;
    report_.attributes.clear();
    const std::vector<AttributeSpec> specs = reader.attributes();
    AttributeLayout layout{job_.attributes.choose(specs, job_.input.string()), ingested_.vertices,
                           ingested_.faces};
    if (layout.specs.empty()) return;
    progress_.plan({expect_attributes(ingested_.vertices)});
    progress_.begin("attributes");
    std::optional<PolygonCutting> cutting;  // corners are asked for triangle by triangle
    const bool corners = std::any_of(
        layout.specs.begin(), layout.specs.end(),
        [](const AttributeSpec& s) { return s.per == AttributePer::corner || s.pooled; });
    if (corners) cutting.emplace(reader, *ingested_.positions, plan_.cache_bytes / 4, budget_);
    store_attributes(reader, layout, job_.bundle / kAttributesName, job_.temp_dir, plan_, budget_,
                     progress_);
    for (AttributeSpec& spec : layout.specs) {
      spec.pooled = false;
      report_.attributes.push_back(
          {spec.name, std::string(name_of(spec.kind)), std::string(name_of(spec.per)), true});
    }
    manifest_.attributes = std::move(layout);
  }

  /// The fraction to keep: a tenth, or what leaves enough to the last sweep.
  double keep_fraction(std::uint64_t level_vertices) const {
    const double vertices = double(std::max<std::uint64_t>(level_vertices, 1));
    const double wanted =
        std::min(kLeftToLastSweep * double(job_.base_vertices), 0.4 * double(plan_.domain_buffer));
    return std::clamp(wanted / vertices, kKeep, 0.9);
  }

  void plan_phases(std::uint64_t vertices) {
    plan_sweeps(0, vertices, vertices);
    progress_.plan({expect_ingest(vertices)});
  }
  void plan_sweeps(unsigned level, std::uint64_t level_vertices, std::uint64_t vertices) {
    const auto keep = [this](std::uint64_t v) { return keep_fraction(v); };
    progress_.plan(expect_sweeps(level_vertices, vertices, level, plan_, keep));
  }

  /// The level after this one. Vertices at the borders of segments stay, which counts when segments
  /// are small.
  std::unique_ptr<DomainLevel> make_next(const DomainLevel& level, double keep,
                                         PositionSample& sample) {
    const double vertices = double(level.vertices());
    const double locked = std::min(double(level.mixed_faces()), vertices);
    const double left = locked + keep * (vertices - locked);
    const std::size_t segments = segments_for(static_cast<std::uint64_t>(2 * left), plan_);
    auto next = std::make_unique<DomainLevel>(level.level() + 1,
                                              SpaceCut(sample.kept(), segments, level.level() + 1),
                                              job_.temp_dir, plan_.bucket_bytes, budget_);
    if (keeps_features()) next->carry_features();
    if (!manifest_.feature_labels.empty()) next->carry_labels();
    return next;
  }

  void sweep_to_base() {
    const auto start = std::chrono::steady_clock::now();
    std::unique_ptr<DomainLevel> level = std::move(ingested_.level);
    PositionSample sample = std::move(ingested_.sample);
    std::optional<TopologyCounter> topology;
    topology.emplace(job_.temp_dir, ingested_.vertices, plan_.bucket_bytes / 8, budget_);
    store::SectionFileWriter tiles(job_.bundle / kTilesName, kTileKind);
    while (level != nullptr) {
      const unsigned number = level->level();
      plan_sweeps(number, level->vertices(), ingested_.vertices);
      progress_.begin(level->segments() == 1 ? "last sweep" : fmt::format("sweep {}", number + 1));
      const double keep = keep_fraction(level->vertices());
      std::unique_ptr<DomainLevel> next;
      if (level->segments() > 1) next = make_next(*level, keep, sample);
      PositionSample next_sample(1 << 17);
      store::SectionFileWriter log(job_.bundle / log_name(number), kLogKind);
      simplify::SweepOptions options;
      options.keep = keep;
      options.base_vertices = job_.base_vertices;
      options.draft = level->vertices() > kDraftAbove * job_.base_vertices;
      options.diagonal = ingested_.diagonal;
      options.feature_angle_rad = job_.feature_angle_deg * std::numbers::pi / 180;
      options.feature_labels = !manifest_.feature_labels.empty();
      options.threads = plan_.sweep_threads;
      options.input_name = job_.input.string();
      options.progress = &progress_;
      simplify::SweepOutput output;
      output.log = &log;
      output.next = next.get();
      output.sample = &next_sample;
      output.base = &base_;
      if (number == 0) {
        output.tiles = &tiles;
        output.topology = &*topology;
      }
      const Reservation lanes = reserve_lanes(*level, plan_, budget_);
      const simplify::SweepCounts counts = run_sweep(*level, options, output);
      log.seal();
      record(number, counts);
      if (number == 0) {
        tiles.seal();
        manifest_.topology = topology->finish();
        topology.reset();
        if (job_.accept) job_.accept(manifest_.topology);
      }
      level = std::move(next);
      sample = std::move(next_sample);
    }
    report_.seconds_sweeps = seconds_since(start);
  }

  void record(unsigned level, const simplify::SweepCounts& counts) {
    manifest_.segments.push_back(counts.segments);
    report_.sweeps.push_back({counts.faces_in, counts.faces_out, counts.segments});
    if (level == 0) report_.repairs.unreferenced_vertices = counts.unreferenced_vertices;
    record_features(level, counts);
    if (counts.segments > 1 && double(counts.faces_out) > 0.97 * double(counts.faces_in)) {
      throw BudgetError(fmt::format(
          "with segments of {} faces the sweeps cannot simplify further: {} faces are left. A "
          "--domain-buffer of {} faces "
          "would take them in one piece{}",
          plan_.segment_faces, counts.faces_out, counts.faces_out + counts.faces_out / 10,
          counts.corners == 0
              ? ""
              : fmt::format("; {} corners of features stay in any case, fewer with a larger "
                            "--feature-angle",
                            counts.corners)));
    }
  }

  void record_features(unsigned level, const simplify::SweepCounts& counts) {
    if (!keeps_features()) return;
    if (level == 0) {
      report_.features = Report::Features{};
      report_.features->angle_deg = job_.feature_angle_deg;
      report_.features->labels = manifest_.feature_labels;
      report_.features->edges = counts.feature_edges;
    }
    report_.features->dropped_edges += counts.dropped_features;
    report_.features->corners = counts.corners;
    report_.features->base_edges = counts.base_feature_edges;
    report_.features->least_base_vertices = counts.least_vertices;
  }

  bool keeps_features() const {
    return job_.feature_angle_deg > 0 || !manifest_.feature_labels.empty();
  }

  void map_vertices() {
    progress_.begin("map");
    map::CarryOptions carry;
    carry.threads = job_.threads;
    carry.progress = &progress_;
    MapFileWriter file(job_.temp_dir, ingested_.vertices, plan_.bucket_bytes, budget_);
    std::vector<store::SectionFile> logs;
    for (std::size_t l = 0; l < manifest_.segments.size(); ++l)
      logs.emplace_back(job_.bundle / log_name(l), kLogKind);
    std::vector<const store::SectionFile*> levels;
    for (const store::SectionFile& log : logs) levels.push_back(&log);
    {
      const ProgressPart part(&progress_, 0, kMapCarried);
      map::BaseCarrier(levels, plan_.cache_bytes, budget_)
          .carry_removed(carry, [&](VertexId vertex, const map::FacePoint& on_base) {
            file.add(vertex, on_base);
          });
    }
    add_base_vertices(file);
    manifest_.map_checksum =
        file.write(job_.bundle / kMapName, ingested_.vertices + manifest_.copied_vertices -
                                               ingested_.nonfinite_vertices -
                                               report_.repairs.unreferenced_vertices);
  }

  void add_base_vertices(MapFileWriter& file) const {
    std::vector<bool> done(base_.vertex_id.size(), false);
    for (std::uint32_t f = 0; f < base_.triangle.size(); ++f) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t v = base_.triangle[f][i];
        if (done[v]) continue;
        done[v] = true;
        file.add(base_.vertex_id[v], {f, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0});
      }
    }
  }

  void seal() {
    write_base(base_, ingested_.origin, job_.bundle / kBaseName);
    manifest_.base_checksum = checksum_file(job_.bundle / kBaseName);
    write_manifest(manifest_, job_.bundle);
    report_.components = manifest_.topology.components;
    report_.boundary_loops = manifest_.topology.boundary_loops;
    report_.euler_characteristic = manifest_.topology.euler_characteristic();
    report_.base_vertices_requested = job_.base_vertices;
    report_.base_vertices = base_.position.size();
    report_.base_faces = base_.triangle.size();
  }

  const ParameterizeJob& job_;
  const MemoryPlan& plan_;
  MemoryBudget& budget_;
  Progress& progress_;
  Report& report_;
  Ingested ingested_;
  Manifest manifest_;
  BaseMesh base_;
  bool repaired_ = false;
};

}  // namespace

void parameterize(const ParameterizeJob& job, const MemoryPlan& plan, MemoryBudget& budget,
                  Progress& progress, Report& report) {
  Parameterizer(job, plan, budget, progress, report).run();
}

}  // namespace remaps::pipeline
