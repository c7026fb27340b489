#include "remaps/simplify/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "remaps/base/workers.h"
#include "remaps/simplify/draft_simplifier.h"
#include "remaps/simplify/feature_edges.h"
#include "remaps/simplify/sampling_load.h"
#include "remaps/simplify/simplifier.h"

namespace remaps::simplify {
namespace {

/// The last sweep takes more care when this many times the base is left.
constexpr std::size_t kThorough = 10;

/// Chains of features with a loose end that are shorter than so many diagonals go, and connected
/// features with less of length a corner: noise (docs/design/features.md).
constexpr double kLeastLoose = 0.02;
constexpr double kLeastPerCorner = 0.03;

/// Where features do not let the base come down to what is asked for, so many times the least is
/// kept: the last removals have no choice left and do most harm (docs/design/features.md).
constexpr double kAboveLeast = 1.5;

/// Buffers of one worker thread, kept from segment to segment.
struct Lane {
  VertexIndex index;
  Segment segment;
  Patch patch;
  Simplifier simplifier;
  DraftSimplifier draft_simplifier;
  SegmentLog log;
  std::vector<LocalIndex> removed;
};

/// What one segment hands to its commit.
struct SegmentResult {
  store::PackedSection records;
  store::PackedSection tile;
  SegmentTopology topology;
  std::vector<RoutedVertex> vertex;               // survivors among the own vertices
  std::vector<Quadric> quadric;                   // of those
  std::vector<std::array<RoutedVertex, 3>> face;  // surviving home faces
  std::vector<float> load;                        // of those
  std::vector<std::uint8_t> feature;              // of those; empty without features
  std::vector<FaceLabel> label;                   // of those; empty without labels
  SegmentLog log;                                 // survivor; next is filled at commit
  std::uint64_t faces_in = 0;
  std::uint64_t record_count = 0;
  std::uint64_t unreferenced = 0;
  FeatureCounts features;
  std::uint64_t features_left = 0;
  std::uint64_t least_vertices = 0;
};

[[noreturn]] void refuse(const ManifoldDefect& defect, const Segment& s, const std::string& input) {
  const VertexId a = s.vertex_id[defect.vertex_a];
  const VertexId b = s.vertex_id[defect.vertex_b];
  using Kind = ManifoldDefect::Kind;
  std::string what;
  switch (defect.kind) {
    case Kind::kDegenerateFace:
      what = fmt::format("a face uses vertex {} twice (its other vertex is {})", a, b);
      break;
    case Kind::kEdgeFaces:
      what =
          fmt::format("the edge between vertices {} and {} belongs to more than two faces", a, b);
      break;
    case Kind::kOrientation:
      what = fmt::format(
          "the two faces at the edge between vertices {} and {} are oriented against each other", a,
          b);
      break;
    case Kind::kSameCorners:
      what = fmt::format("two faces at vertex {} have the same corners", a);
      break;
    default:
      what = fmt::format("the faces at vertex {} form more than one fan", a);
  }
  throw NotManifold(
      fmt::format("{}: not a manifold surface: {} (vertices count from 0)", input, what));
}

Tile make_tile(const Segment& s) {
  // Foreign vertices that only ghosts use stay out.
  Tile tile;
  std::vector<LocalIndex> local(s.vertex_id.size(), kNoIndex);
  std::vector<std::uint8_t> used(s.vertex_id.size(), 0);
  for (LocalIndex f = 0; f < s.home_faces; ++f) {
    for (const LocalIndex v : s.triangle[f]) used[v] = 1;
  }
  std::fill_n(used.begin(), s.own_vertices, std::uint8_t{1});
  for (LocalIndex v = 0; v < s.vertex_id.size(); ++v) {
    if (!used[v]) continue;
    local[v] = static_cast<LocalIndex>(tile.vertex_id.size());
    tile.vertex_id.push_back(s.vertex_id[v]);
    tile.position.push_back(s.position[v]);
  }
  tile.own_vertices = s.own_vertices;
  tile.triangle.reserve(s.home_faces);
  for (LocalIndex f = 0; f < s.home_faces; ++f) {
    const LocalTriangle& t = s.triangle[f];
    tile.triangle.push_back({local[t[0]], local[t[1]], local[t[2]]});
  }
  tile.face_id.assign(s.face_id.begin(), s.face_id.begin() + s.home_faces);
  return tile;
}

class Sweep {
 public:
  Sweep(DomainLevel& level, const SweepOptions& options, const SweepOutput& output)
      : level_(level), options_(options), output_(output), lanes_(std::max(1u, options.threads)) {
    counts_.segments = level.segments();
  }

  SweepCounts run() {
    run_ordered(level_.segments(), options_.threads,
                [this](std::size_t i, unsigned lane) -> Commit {
                  if (options_.progress != nullptr) options_.progress->check();
                  std::shared_ptr<SegmentResult> result = process(i, lanes_[lane]);
                  return [this, i, result] { commit(i, *result); };
                });
    return counts_;
  }

 private:
  std::shared_ptr<SegmentResult> process(std::size_t i, Lane& lane) {
    auto result = std::make_shared<SegmentResult>();
    Segment& s = lane.segment;
    lane.log.clear();
    lane.log.level = level_.level();
    level_.load(i, lane.index, s, lane.log.origin);
    result->faces_in = s.home_faces;
    const ManifoldDefect defect = lane.patch.build(s.vertex_id.size(), s.own_vertices, s.triangle);
    if (defect.kind != ManifoldDefect::Kind::kNone) refuse(defect, s, options_.input_name);
    if (options_.feature_angle_rad > 0 || options_.feature_labels) {
      result->features = find_features(feature_options(), lane.patch, s);
    }
    if (level_.level() == 0) prepare_input(lane, *result);
    simplify(lane, *result);
    result->record_count = lane.log.records.size();
    result->records = store::pack_section(encode_records(lane.log));
    collect(lane, *result);
    return result;
  }

  void prepare_input(Lane& lane, SegmentResult& result) const {
    const Segment& s = lane.segment;
    for (LocalIndex v = 0; v < s.own_vertices; ++v)
      result.unreferenced += !lane.patch.vertex_alive(v);
    initialize_loads(lane.patch, options_.diagonal, lane.segment);
    result.topology = count_segment(s, lane.patch);
    result.tile = store::pack_section(encode_tile(make_tile(s)));
  }

  FeatureOptions feature_options() const {
    FeatureOptions features;
    features.angle_rad = options_.feature_angle_rad;
    features.labels = options_.feature_labels;
    features.least_loose = kLeastLoose * options_.diagonal;
    features.least_per_corner = kLeastPerCorner * options_.diagonal;
    return features;
  }

  void simplify(Lane& lane, SegmentResult& result) const {
    Segment& s = lane.segment;
    std::size_t alive = 0;
    std::size_t locked = 0;
    for (LocalIndex v = 0; v < s.own_vertices; ++v) {
      alive += lane.patch.vertex_alive(v);
      locked += s.locked[v];
    }
    lane.log.faces = s.home_faces;
    lane.removed.clear();
    SimplifyOptions simplify;
    simplify.target_vertices =
        output_.next == nullptr
            ? static_cast<std::size_t>(options_.base_vertices)
            : locked + static_cast<std::size_t>(std::ceil(double(alive - locked) * options_.keep));
    if (options_.draft && output_.next != nullptr) {
      lane.draft_simplifier.run(simplify, s, lane.patch, alive, lane.log.records, lane.removed);
      for (const LocalIndex v : lane.removed) lane.log.removed.push_back(s.vertex_id[v]);
      return;
    }
    if (output_.next == nullptr) simplify.thorough_below = kThorough * simplify.target_vertices;
    if (level_.segments() == 1) simplify.progress = options_.progress;
    alive = lane.simplifier.run(simplify, s, lane.patch, alive, lane.log.records, lane.removed);
    if (output_.next == nullptr && alive > simplify.target_vertices) {
      if (lane.patch.has_features() && count_features(lane.patch) > 0) {
        result.least_vertices = alive;
        const auto wanted = static_cast<std::size_t>(kAboveLeast * double(alive));
        take_back(lane, std::min(wanted - alive, lane.removed.size()));
      } else {
        go_on(simplify, lane, alive);
      }
    }
    for (const LocalIndex v : lane.removed) lane.log.removed.push_back(s.vertex_id[v]);
  }

  /// Nothing goes any more under the usual rules: allows worse shapes and one more valence before
  /// giving up.
  void go_on(SimplifyOptions simplify, Lane& lane, std::size_t alive) const {
    simplify.wedge_floor = simplify.fan_floor = 1e-6;
    simplify.max_valence = kMaxStarFaces - 1;
    simplify.progress = nullptr;  // few are left: not begun again from none
    lane.simplifier.run(simplify, lane.segment, lane.patch, alive, lane.log.records, lane.removed);
  }

  /// Takes the last removals of the last sweep back: the patch is built again and follows the rest.
  void take_back(Lane& lane, std::size_t count) const {
    Segment& s = lane.segment;
    lane.patch.build(s.vertex_id.size(), s.own_vertices, s.triangle);
    std::fill(s.locked.begin(), s.locked.end(), std::uint8_t{0});
    if (level_.level() == 0) s.feature.clear();  // as it was when they were first found
    find_features(feature_options(), lane.patch, s);
    lane.removed.resize(lane.removed.size() - count);
    RetriangulationLog records;
    Star star;
    for (std::size_t r = 0; r < lane.removed.size(); ++r) {
      const Retriangulation record = lane.log.records[r];
      lane.patch.star(lane.removed[r], star);
      lane.patch.retriangulate(lane.removed[r], star, record.apex);
      records.append(record);
    }
    lane.log.records = std::move(records);
  }

  void collect(const Lane& lane, SegmentResult& result) const {
    const Segment& s = lane.segment;
    std::vector<std::uint32_t> segment(s.vertex_id.size(), 0);
    if (output_.next != nullptr) {
      for (LocalIndex v = 0; v < s.vertex_id.size(); ++v) {
        if (lane.patch.vertex_alive(v)) segment[v] = output_.next->cut().segment_of(s.position[v]);
      }
    }
    const auto routed = [&](LocalIndex v) {
      return RoutedVertex{s.vertex_id[v], s.position[v], segment[v]};
    };
    for (LocalIndex v = 0; v < s.own_vertices; ++v) {
      if (!lane.patch.vertex_alive(v)) continue;
      result.vertex.push_back(routed(v));
      result.quadric.push_back(s.quadric[v]);
    }
    for (LocalIndex f = 0; f < s.home_faces; ++f) {
      if (!lane.patch.face_alive(f)) continue;
      const LocalTriangle& t = lane.patch.face(f);
      result.face.push_back({routed(t[0]), routed(t[1]), routed(t[2])});
      result.load.push_back(s.load[f]);
      if (lane.patch.has_features()) result.feature.push_back(lane.patch.marks(f));
      // What changed a face knows its edges, so this is the label of a face as it was in the input.
      if (!s.label.empty()) result.label.push_back(s.label[f]);
      result.log.survivor.push_back(f);
    }
    result.log.faces = s.home_faces;
    if (lane.patch.has_features()) result.features_left = count_features(lane.patch);
  }

  void commit(std::size_t i, SegmentResult& result) {
    output_.log->append(result.records);
    if (output_.tiles != nullptr) output_.tiles->append(result.tile);
    if (output_.topology != nullptr) output_.topology->add(result.topology);
    output_.next != nullptr ? hand_on(i, result) : finish_base(result);
    output_.log->append(store::pack_section(encode_survivors(result.log)));
    counts_.faces_in += result.faces_in;
    counts_.faces_out += result.face.size();
    counts_.vertices_out += result.vertex.size();
    counts_.records += result.record_count;
    counts_.unreferenced_vertices += result.unreferenced;
    counts_.feature_edges += result.features.edges;
    counts_.dropped_features += result.features.dropped;
    counts_.corners += result.features.corners;
    if (output_.next == nullptr) {
      counts_.base_feature_edges = result.features_left;
      counts_.least_vertices = result.least_vertices;
    }
    if (options_.progress != nullptr)
      options_.progress->advance(double(i + 1) / double(level_.segments()));
  }

  void hand_on(std::size_t i, SegmentResult& result) {
    for (std::size_t v = 0; v < result.vertex.size(); ++v) {
      output_.next->add_vertex(result.vertex[v], result.quadric[v]);
      output_.sample->add(result.vertex[v].position);
    }
    for (std::size_t f = 0; f < result.face.size(); ++f) {
      const FaceLink origin{static_cast<std::uint32_t>(i), result.log.survivor[f]};
      const std::uint8_t feature = result.feature.empty() ? std::uint8_t{0} : result.feature[f];
      const FaceLabel label = result.label.empty() ? kNoLabel : result.label[f];
      result.log.next.push_back(
          output_.next->add_face(result.face[f], {0, result.load[f], origin, feature, label}));
    }
  }

  void finish_base(SegmentResult& result) {
    BaseMesh& base = *output_.base;
    VertexIndex index;
    index.reset(result.vertex.size());
    for (const RoutedVertex& v : result.vertex) {
      index[v.id] = static_cast<LocalIndex>(base.vertex_id.size());
      base.vertex_id.push_back(v.id);
      base.position.push_back(v.position);
    }
    for (const auto& corner : result.face) {
      result.log.next.push_back({0, static_cast<LocalIndex>(base.triangle.size())});
      base.triangle.push_back({index[corner[0].id], index[corner[1].id], index[corner[2].id]});
    }
  }

  DomainLevel& level_;
  const SweepOptions& options_;
  const SweepOutput& output_;
  std::vector<Lane> lanes_;
  SweepCounts counts_;
};

}  // namespace

SweepCounts run_sweep(DomainLevel& level, const SweepOptions& options, const SweepOutput& output) {
  return Sweep(level, options, output).run();
}

}  // namespace remaps::simplify
