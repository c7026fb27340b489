#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>

#include "remaps/base/workers.h"
#include "remaps/pipeline/map_file.h"
#include "remaps/pipeline/push_forward.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/query_run.h"
#include "remaps/pipeline/sphere_files.h"
#include "remaps/pipeline/vertex_ledger.h"

namespace remaps::pipeline {
namespace {

/// How far weights may lie outside their triangle: they are clamped, since text and floats round.
constexpr double kOutside = 1e-6;

/// Weights of a point asked for, clamped.
/// @return  false when they are not those of a point of a triangle
bool clamp_weights(double& u, double& v) {
  if (!(u >= -kOutside && v >= -kOutside && u + v <= 1 + kOutside)) return false;
  u = std::max(u, 0.0);
  v = std::max(v, 0.0);
  const double sum = std::max(u + v, 1.0);
  u /= sum;
  v /= sum;
  return true;
}

[[noreturn]] void refuse_weights(const char* what, std::uint64_t face, double u, double v) {
  throw InputError(fmt::format(
      "{} face {}: weights {}, {} are outside of it (u, v >= 0, u + v <= 1)", what, face, u, v));
}

class Locator {
 public:
  Locator(const QueryOptions& options, Progress& progress)
      : run_(options), bundle_(run_.bundle), manifest_(bundle_.manifest()), progress_(progress) {
    if (has_sphere(bundle_)) sphere_.emplace(bundle_, run_.budget);
  }

  std::vector<Location> from_directions(const std::vector<SpherePlace>& places) {
    if (!sphere_) sphere_.emplace(bundle_, run_.budget);  // says that there is none
    const sphere::SphericalMap& map = sphere_->map();
    std::vector<BasePoint> points;
    for (const SpherePlace& place : places) {
      const double length = norm(place.direction);
      if (!(length > 0) || !std::isfinite(length)) {
        throw InputError(fmt::format("{}, {}, {} is no direction", place.direction.x,
                                     place.direction.y, place.direction.z));
      }
      if (place.component >= map.components()) {
        throw InputError(fmt::format("there is no sphere of component {}; there {} {}",
                                     place.component, map.components() == 1 ? "is" : "are",
                                     map.components()));
      }
      const LocalIndex near =
          points.empty() || map.component_of(points.back().face) != place.component
              ? map.first_face(place.component)
              : points.back().face;
      const sphere::FaceWeights at = map.locate(1 / length * place.direction, near);
      points.push_back({at.face, at.u, at.v});
    }
    return pull_back(points, nullptr);
  }

  std::vector<Location> from_vertices(const std::vector<VertexId>& vertices) {
    std::vector<BasePoint> points;
    const store::File map = store::File::open_read(bundle_.directory() / kMapName);
    for (const VertexId v : vertices) points.push_back(read_map(map, v));
    return pull_back(points, &vertices);
  }

  std::vector<Location> from_base(std::vector<BasePoint> points) {
    for (BasePoint& p : points) {
      if (p.face >= bundle_.base().triangle.size()) {
        throw InputError(fmt::format("there is no base face {}; the base has {}", p.face,
                                     bundle_.base().triangle.size()));
      }
      if (!clamp_weights(p.u, p.v)) refuse_weights("base", p.face, p.u, p.v);
    }
    return pull_back(points, nullptr);
  }

  std::vector<Location> from_input(const std::vector<InputPoint>& points) {
    std::vector<Location> found(points.size());
    PushOptions push{carry_options(), run_.plan.bucket_bytes, run_.temp.path()};
    auto start = make_points(bundle_, 0, push, run_.budget);
    find_faces(points, *start, found);
    progress_.begin("points to the base");
    push_forward(bundle_, std::move(start), push, run_.budget,
                 [&](const map::TaggedPoint& point) { set_base(point.at, found.at(point.tag)); });
    return found;
  }

 private:
  map::CarryOptions carry_options() {
    map::CarryOptions carry;
    carry.threads = run_.threads;
    carry.map_buffer = run_.plan.map_buffer;
    carry.progress = &progress_;
    return carry;
  }

  void set_base(const map::FacePoint& at, Location& location) const {
    location.base = {at.face, at.u, at.v};
    location.base_position = manifest_.origin + position_on_base(bundle_.base(), at);
    if (!sphere_ || sphere_->map().component_of(at.face) == kNoIndex) return;
    location.sphere = {sphere_->map().direction({at.face, at.u, at.v}),
                       sphere_->map().component_of(at.face)};
  }

  void set_input(const Tile& tile, const map::FacePoint& at, Location& location) const {
    const auto& t = tile.triangle[at.face];
    location.input.face = tile.face_id[at.face];
    location.input.u = at.u;
    location.input.v = at.v;
    location.input.vertex = {tile.vertex_id[t[0]], tile.vertex_id[t[1]], tile.vertex_id[t[2]]};
    location.position = manifest_.origin + resample::position_on_tile(tile, at);
  }

  BasePoint read_map(const store::File& map, VertexId vertex) const {
    if (vertex >= manifest_.input_vertices) {
      throw InputError(fmt::format("there is no input vertex {}; the input has {}", vertex,
                                   manifest_.input_vertices));
    }
    MapRecord record;
    map.read_at(vertex * sizeof record, std::as_writable_bytes(std::span(&record, 1)));
    if (record.face == MapRecord{}.face) {
      throw GeometryError(fmt::format("input vertex {} has no face, or is not finite", vertex));
    }
    BasePoint point{record.face, record.u, record.v};
    if (record.face >= bundle_.base().triangle.size() || !clamp_weights(point.u, point.v)) {
      throw CorruptionError(fmt::format("{}: input vertex {} is at ({}, {}) of base face {}",
                                        map.path().string(), vertex, record.u, record.v,
                                        record.face));
    }
    return point;
  }

  /// @param vertices  optional: the vertices that the points stand for
  std::vector<Location> pull_back(const std::vector<BasePoint>& points,
                                  const std::vector<VertexId>* vertices) {
    std::vector<Location> found(points.size());
    resample::ResampleOptions options;
    options.carry = carry_options();
    options.buffer_bytes = run_.plan.bucket_bytes;
    options.temp_dir = run_.temp.path();
    const auto produce = [&](const std::function<void(const map::TaggedPoint&)>& add) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        const map::FacePoint at{points[i].face, points[i].u, points[i].v};
        set_base(at, found[i]);
        add({i, at});
      }
    };
    progress_.begin("points to the input");
    resample::pull_back(
        bundle_.files(), produce, options, run_.budget,
        [&](std::uint32_t, const Tile& tile, std::span<const map::TaggedPoint> batch) {
          for (const map::TaggedPoint& point : batch) {
            const map::FacePoint at =
                vertices == nullptr ? point.at : snap_to((*vertices)[point.tag], tile, point.at);
            set_input(tile, at, found.at(point.tag));
          }
        });
    return found;
  }

  /// map.bin has floats, so what is pulled back lies a little beside the vertex. Where the face
  /// found has it as a corner, as nearly always, the answer is that corner.
  static map::FacePoint snap_to(VertexId vertex, const Tile& tile, const map::FacePoint& at) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (tile.vertex_id[tile.triangle[at.face][i]] == vertex) {
        return {at.face, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
      }
    }
    return at;
  }

  void find_faces(const std::vector<InputPoint>& points, map::PointBuckets& start,
                  std::vector<Location>& found);

  QueryRun run_;
  const Bundle& bundle_;
  const Manifest& manifest_;
  Progress& progress_;
  std::optional<SphereFiles> sphere_;
};

/// Looks through the tiles for the faces asked for, until all are found.
void Locator::find_faces(const std::vector<InputPoint>& points, map::PointBuckets& start,
                         std::vector<Location>& found) {
  std::vector<std::pair<FaceId, std::size_t>> wanted;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].face >= manifest_.input_faces + manifest_.filled_faces) {
      throw InputError(fmt::format("there is no input face {}; the input has {}", points[i].face,
                                   manifest_.input_faces));
    }
    wanted.emplace_back(points[i].face, i);
  }
  std::sort(wanted.begin(), wanted.end());
  progress_.begin("search for the faces");
  std::atomic<std::size_t> left = points.size();
  const store::SectionFile& tiles = bundle_.tiles();
  run_ordered(tiles.sections(), run_.threads, [&](std::size_t tile_number, unsigned) -> Commit {
    progress_.check();
    if (left.load() == 0) return [] {};
    const std::string what = fmt::format("{}: tile {}", tiles.path().string(), tile_number);
    store::Bytes bytes;
    std::vector<FaceId> ids;
    tiles.read(tile_number, bytes);
    decode_tile_face_ids(bytes, what, ids);
    auto hits = std::make_shared<std::vector<map::TaggedPoint>>();
    for (LocalIndex f = 0; f < ids.size(); ++f) {
      auto at = std::lower_bound(wanted.begin(), wanted.end(), std::pair{ids[f], std::size_t{0}});
      for (; at != wanted.end() && at->first == ids[f]; ++at) {
        map::FacePoint point{f, points[at->second].u, points[at->second].v};
        if (!clamp_weights(point.u, point.v)) refuse_weights("input", ids[f], point.u, point.v);
        hits->push_back({at->second, point});
      }
    }
    auto tile = std::make_shared<Tile>();
    if (!hits->empty()) decode_tile(bytes, what, *tile);
    return [&, tile_number, hits, tile] {
      for (const map::TaggedPoint& hit : *hits) {
        set_input(*tile, hit.at, found[hit.tag]);
        start.add(tile_number, hit);
      }
      left -= std::min(left.load(), hits->size());
      progress_.advance(double(tile_number + 1) / double(tiles.sections()));
    };
  });
  if (left.load() != 0 &&
      manifest_.topology.faces < manifest_.input_faces + manifest_.filled_faces) {
    throw GeometryError("some of the faces asked for were left out by repair");
  }
  if (left.load() != 0) {
    throw CorruptionError(
        fmt::format("{}: no tile has some of the faces asked for", tiles.path().string()));
  }
}

}  // namespace

std::vector<Location> locate_vertices(const QueryOptions& options,
                                      const std::vector<VertexId>& vertices, Progress& progress) {
  return Locator(options, progress).from_vertices(vertices);
}

std::vector<Location> locate_base_points(const QueryOptions& options,
                                         const std::vector<BasePoint>& points, Progress& progress) {
  return Locator(options, progress).from_base(points);
}

std::vector<Location> locate_input_points(const QueryOptions& options,
                                          const std::vector<InputPoint>& points,
                                          Progress& progress) {
  return Locator(options, progress).from_input(points);
}

std::vector<Location> locate_directions(const QueryOptions& options,
                                        const std::vector<SpherePlace>& places,
                                        Progress& progress) {
  return Locator(options, progress).from_directions(places);
}

}  // namespace remaps::pipeline
