#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "remaps/pipeline/base_check.h"
#include "remaps/pipeline/level_replay.h"
#include "remaps/pipeline/map_file.h"
#include "remaps/pipeline/push_forward.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/query_run.h"
#include "remaps/pipeline/sphere_files.h"
#include "remaps/pipeline/vertex_ledger.h"

namespace remaps::pipeline {
namespace {

/// Memory of a segment or tile that points are carried through, over the bytes of its sections.
constexpr std::uint64_t kCarryFactor = 3;

/// A face of a tile: three corners and an id, a byte each.
constexpr std::uint64_t kLeastBytesPerFace = 4;

void check_file(const Bundle& bundle, const char* name, std::uint64_t checksum) {
  const std::filesystem::path path = bundle.directory() / name;
  std::uint64_t found = 0;
  try {
    found = checksum_file(path);
  } catch (const IoError& error) {
    throw CorruptionError(error.what());
  }
  if (found != checksum) {
    throw CorruptionError(fmt::format("{}: its checksum is {:016x}, the manifest says {:016x}",
                                      path.string(), found, checksum));
  }
}

class Verifier {
 public:
  Verifier(const QueryOptions& options, Progress& progress)
      : run_(options), bundle_(run_.bundle), manifest_(bundle_.manifest()), progress_(progress) {}

  Verification run() {
    check_files();
    ledger_.emplace(run_.temp.path(), bundle_, run_.plan.bucket_bytes, run_.budget);
    replay();
    check_base();
    round_trip();
    return compare();
  }

 private:
  void check_files() {
    progress_.begin("checksums");
    check_file(bundle_, kMapName, manifest_.map_checksum);
    progress_.advance(0.9);
    check_file(bundle_, kBaseName, manifest_.base_checksum);
    const std::filesystem::path map = bundle_.directory() / kMapName;
    const std::uint64_t size = store::File::open_read(map).size();
    if (size % sizeof(MapRecord) != 0 || size / sizeof(MapRecord) != manifest_.input_vertices) {
      throw CorruptionError(fmt::format("{}: {} bytes, but {} input vertices take {} each",
                                        map.string(), size, manifest_.input_vertices,
                                        sizeof(MapRecord)));
    }
    if (bundle_.attributes() != nullptr) check_attributes();
    if (has_sphere(bundle_)) {
      sphere_.emplace(bundle_, run_.budget);
      sphere_->check_vertices(bundle_, progress_);
    }
    progress_.advance(1);
  }

  /// Each block has its checksum; that there are as many as the input has vertices and faces was
  /// checked when the bundle was opened.
  void check_attributes() {
    if (manifest_.attributes.vertices != manifest_.input_vertices) {
      throw CorruptionError(fmt::format("{}: attributes of {} vertices, but there are {}",
                                        bundle_.directory().string(), manifest_.attributes.vertices,
                                        manifest_.input_vertices));
    }
    const store::SectionFile& sections = bundle_.attributes()->sections();
    store::Bytes bytes;
    for (std::size_t i = 0; i < sections.sections(); ++i) sections.read(i, bytes);
  }

  /// Records and connectivity. On the way each tile gives its vertices to the ledger, and for the
  /// round trip a corner of a face for each that it has a face of.
  void replay() {
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < bundle_.tiles().sections(); ++i)
      bytes += bundle_.tiles().raw_bytes(i);
    if (manifest_.topology.faces > bytes / kLeastBytesPerFace) {
      throw CorruptionError(fmt::format("{}: too small for the {} faces of the manifest",
                                        bundle_.tiles().path().string(), manifest_.topology.faces));
    }
    if (manifest_.topology.faces > manifest_.input_faces + manifest_.filled_faces) {
      throw CorruptionError(
          fmt::format("{}: its manifest has more faces in the tiles than in the "
                      "file",
                      bundle_.directory().string()));
    }
    NumberCensus census(run_.temp.path() / "input-faces",
                        manifest_.input_faces + manifest_.filled_faces, run_.plan.bucket_bytes / 4,
                        run_.budget);
    PushOptions push;
    push.buffer_bytes = run_.plan.bucket_bytes;
    push.temp_dir = run_.temp.path();
    start_ = make_points(bundle_, 0, push, run_.budget);
    ReplaySinks sinks;
    sinks.tile = [&](std::uint32_t segment, const Tile& tile) {
      for (const FaceId face : tile.face_id) census.add(face, "face");
      ledger_->add_tile(tile);
      start_points(segment, tile);
    };
    sinks.removed = [&](const std::vector<VertexId>& removed) {
      for (const VertexId v : removed) ledger_->add_removed(v);
    };
    replayed_ = replay_bundle(bundle_, {run_.threads, run_.plan.bucket_bytes, run_.temp.path()},
                              run_.budget, progress_, sinks);
    census.finish("input face",
                  manifest_.input_faces + manifest_.filled_faces - manifest_.topology.faces);
  }

  void start_points(std::uint32_t segment, const Tile& tile) {
    std::vector<bool> done(tile.vertex_id.size(), false);
    for (LocalIndex f = 0; f < tile.triangle.size(); ++f) {
      for (std::size_t i = 0; i < 3; ++i) {
        const LocalIndex v = tile.triangle[f][i];
        if (done[v]) continue;
        done[v] = true;
        start_->add(segment, {tile.vertex_id[v], {f, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}});
      }
    }
  }

  void check_base() {
    topology_ = count_base(bundle_.base());
    const Topology& input = manifest_.topology;
    const auto compare = [&](const char* what, auto base, auto expected) {
      if (base == expected) return;
      throw CorruptionError(fmt::format("{}: the base has {} {}, the manifest's input {}",
                                        bundle_.directory().string(), base, what, expected));
    };
    compare("components", topology_.components, input.components);
    compare("boundary loops", topology_.boundary_loops, input.boundary_loops);
    compare("as Euler characteristic", topology_.euler_characteristic(),
            input.euler_characteristic());
    const std::vector<VertexId> id = match_base(bundle_.base(), replayed_.base);
    for (std::size_t v = 0; v < id.size(); ++v) {
      ledger_->add_base(id[v], narrow<std::uint32_t>(v));
    }
  }

  /// Threads for which segments and tiles fit beside the buffers.
  map::CarryOptions carry_options() {
    std::uint64_t largest = 0;
    const auto look_at = [&](const store::SectionFile& file) {
      for (std::size_t i = 0; i < file.sections(); ++i) {
        largest = std::max(largest, file.raw_bytes(i));
      }
    };
    for (std::size_t level = 0; level < manifest_.levels; ++level) look_at(bundle_.log(level));
    look_at(bundle_.tiles());
    const std::uint64_t buffers = 2 * run_.plan.bucket_bytes;
    const std::uint64_t available = run_.budget.available();
    map::CarryOptions carry;
    carry.threads = affordable_threads(run_.threads, kCarryFactor * largest,
                                       available > buffers ? available - buffers : 0);
    carry.map_buffer = run_.plan.map_buffer;
    carry.progress = &progress_;
    return carry;
  }

  /// Input -> base -> input, all through the logs; the ledger hears of both ends.
  void round_trip() {
    const map::CarryOptions carry = carry_options();
    PushOptions push{carry, run_.plan.bucket_bytes, run_.temp.path()};
    map::PointBuckets on_base(run_.temp.path() / "on-base", 1, run_.plan.bucket_bytes / 8,
                              run_.budget);
    progress_.begin("points to the base");
    push_forward(bundle_, std::move(start_), push, run_.budget, [&](const map::TaggedPoint& point) {
      ledger_->add_on_base(point.tag, point.at);
      on_base.add(0, {point.tag, over_sphere(point.at)});
    });
    progress_.begin("points back to the input");
    resample::ResampleOptions pull;
    pull.carry = carry;
    pull.buffer_bytes = run_.plan.bucket_bytes;
    pull.temp_dir = run_.temp.path();
    const auto points = [&](const std::function<void(const map::TaggedPoint&)>& add) {
      std::vector<map::TaggedPoint> batch;
      for (std::uint64_t first = 0; first < on_base.count(0); first += batch.size()) {
        on_base.read(0, first, std::min<std::uint64_t>(on_base.count(0) - first, carry.map_buffer),
                     batch);
        for (const map::TaggedPoint& point : batch) add(point);
      }
      on_base.release(0);
    };
    resample::pull_back(
        bundle_.files(), points, pull, run_.budget,
        [&](std::uint32_t, const Tile& tile, std::span<const map::TaggedPoint> got) {
          for (const map::TaggedPoint& point : got) {
            ledger_->add_returned(point.tag, resample::position_on_tile(tile, point.at));
          }
        });
  }

  /// To the sphere and back, if there is one for this point.
  map::FacePoint over_sphere(const map::FacePoint& at) {
    if (!sphere_ || sphere_->map().component_of(at.face) == kNoIndex) return at;
    ++sphere_vertices_;
    const sphere::FaceWeights back =
        sphere_->map().locate(sphere_->map().direction({at.face, at.u, at.v}), at.face);
    return {back.face, back.u, back.v};
  }

  Verification compare() {
    progress_.begin("compare");
    const LedgerResult found = ledger_->compare(run_.threads, progress_);
    if (found.vertices != manifest_.topology.vertices) {
      throw CorruptionError(fmt::format("{}: {} vertices have a face, the manifest says {}",
                                        bundle_.tiles().path().string(), found.vertices,
                                        manifest_.topology.vertices));
    }
    if (found.absent != manifest_.absent_vertices) {
      throw CorruptionError(fmt::format("{}: {} vertices are in no tile, the manifest says {}",
                                        bundle_.tiles().path().string(), found.absent,
                                        manifest_.absent_vertices));
    }
    const double diagonal = found.box.diagonal();
    if (!(std::abs(diagonal - manifest_.diagonal) <= 1e-12 * diagonal)) {
      throw CorruptionError(
          fmt::format("{}: the diagonal of its vertices is {}, the manifest says {}",
                      bundle_.tiles().path().string(), diagonal, manifest_.diagonal));
    }
    Verification result;
    result.vertices = found.vertices;
    result.records = replayed_.records;
    result.segments = replayed_.segments;
    result.base_vertices = topology_.vertices;
    result.base_faces = topology_.faces;
    result.components = topology_.components;
    result.boundary_loops = topology_.boundary_loops;
    result.euler_characteristic = topology_.euler_characteristic();
    result.round_trip_max = found.round_trip_max;
    result.round_trip_mean =
        found.round_trip_sum / double(std::max<std::uint64_t>(found.vertices, 1));
    result.map_file_max = found.map_file_max;
    result.sphere_vertices = sphere_vertices_;
    if (sphere_ && sphere_vertices_ < sphere_->manifest().vertices) {
      throw CorruptionError(fmt::format("{}: {} vertices are on spheres, but {} says {}",
                                        bundle_.directory().string(), sphere_vertices_,
                                        kSphereManifestName, sphere_->manifest().vertices));
    }
    return result;
  }

  QueryRun run_;
  const Bundle& bundle_;
  const Manifest& manifest_;
  Progress& progress_;
  std::optional<VertexLedger> ledger_;
  std::unique_ptr<map::PointBuckets> start_;
  ReplayedBundle replayed_;
  Topology topology_;
  std::optional<SphereFiles> sphere_;
  std::uint64_t sphere_vertices_ = 0;
};

}  // namespace

Verification verify_bundle(const QueryOptions& options, Progress& progress) {
  return Verifier(options, progress).run();
}

}  // namespace remaps::pipeline
