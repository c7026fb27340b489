#include "remaps/pipeline/sphere_files.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "remaps/pipeline/map_file.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/vertex_ledger.h"
#include "remaps/sphere/spherical_parameterization.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {
namespace {

using Json = nlohmann::ordered_json;
using sphere::SpherePoint;

constexpr int kVersion = 1;
constexpr std::size_t kBlock = 1 << 15;  // vertices read and written at a time
constexpr std::uint64_t kFaceBytes = 160;
constexpr std::uint64_t kBlockBytes = kBlock * (sizeof(MapRecord) + 2 * sizeof(Vec3));

std::vector<LocalTriangle> triangles_of(const BaseMesh& base) {
  return {base.triangle.begin(), base.triangle.end()};
}

std::vector<Vec3> positions_of(const BaseMesh& base) {
  std::vector<Vec3> result;
  for (const Vec3f& p : base.position) result.push_back(widen(p));
  return result;
}

/// XXH3-64 of the manifest's text: a sphere belongs to one bundle.
std::uint64_t checksum_of_bundle(const Bundle& bundle) {
  const std::string text = read_manifest(bundle.directory());
  return XXH3_64bits(text.data(), text.size());
}

/// Maps one component.
/// @param place  those of its vertices are set
void map_component(const BaseMesh& base, const std::vector<std::uint32_t>& of_face,
                   std::uint32_t component, MemoryBudget& budget, Progress& progress,
                   std::vector<SpherePoint>& place) {
  std::vector<LocalIndex> local(base.position.size(), kNoIndex), vertex;
  std::vector<Vec3> position;
  std::vector<LocalTriangle> triangle;
  for (std::size_t f = 0; f < of_face.size(); ++f) {
    if (of_face[f] != component) continue;
    LocalTriangle t = base.triangle[f];
    for (LocalIndex& v : t) {
      if (local[v] == kNoIndex) {
        local[v] = static_cast<LocalIndex>(vertex.size());
        vertex.push_back(v);
        position.push_back(widen(base.position[v]));
      }
      v = local[v];
    }
    triangle.push_back(t);
  }
  const std::vector<SpherePoint> mapped =
      sphere::parameterize_sphere(position, triangle, {}, budget, progress);
  for (std::size_t i = 0; i < vertex.size(); ++i) place[vertex[i]] = mapped[i];
}

void check_record(const store::File& map, std::uint64_t vertex, const MapRecord& r,
                  std::size_t faces) {
  if (r.face == MapRecord{}.face) return;
  const double sum = static_cast<double>(r.u) + r.v;
  if (r.face < faces && r.u >= 0 && r.v >= 0 && sum <= 1 + 1e-6) return;
  throw CorruptionError(fmt::format("{}: input vertex {} is at ({}, {}) of base face {}",
                                    map.path().string(), vertex, r.u, r.v, r.face));
}

/// Calls visit(first, records) for all of map.bin, block by block.
template <class Visit>
void for_map_blocks(const Bundle& bundle, Progress& progress, Visit&& visit) {
  const store::File file = store::File::open_read(bundle.directory() / kMapName);
  const std::uint64_t vertices = bundle.manifest().input_vertices;
  const std::size_t faces = bundle.base().triangle.size();
  std::vector<MapRecord> records;
  for (std::uint64_t first = 0; first < vertices; first += records.size()) {
    records.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, vertices - first)));
    file.read_at(first * sizeof(MapRecord), std::as_writable_bytes(std::span(records)));
    for (std::size_t i = 0; i < records.size(); ++i)
      check_record(file, first + i, records[i], faces);
    visit(first, records);
    progress.advance(static_cast<double>(first + records.size()) / static_cast<double>(vertices));
  }
}

/// Where the vertex of a record is; not a number if nowhere.
Vec3 direction_of(const sphere::SphericalMap& map, const MapRecord& record) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (record.face == MapRecord{}.face || map.component_of(record.face) == kNoIndex) {
    return {kNone, kNone, kNone};
  }
  return map.direction({record.face, record.u, record.v});
}

/// Writes sphere.bin and returns its checksum.
std::uint64_t write_directions(const Bundle& bundle, const sphere::SphericalMap& map,
                               SphereManifest& manifest, Progress& progress) {
  const std::filesystem::path path = bundle.directory() / kSphereName;
  const std::filesystem::path partial = store::partial_name(path);
  store::File out = store::File::create(partial);
  XXH3_state_t* hash = XXH3_createState();
  XXH3_64bits_reset(hash);
  std::vector<Vec3> directions;
  for_map_blocks(bundle, progress, [&](std::uint64_t first, const std::vector<MapRecord>& records) {
    directions.clear();
    for (const MapRecord& record : records) {
      directions.push_back(direction_of(map, record));
      if (std::isnan(directions.back().x)) continue;
      ++manifest.vertices;
      const sphere::FaceWeights back = map.locate(directions.back(), record.face);
      const Vec3 there = position_on_base(bundle.base(), {record.face, record.u, record.v});
      const Vec3 here = position_on_base(bundle.base(), {back.face, back.u, back.v});
      manifest.round_trip_max = std::max(manifest.round_trip_max, norm(here - there));
    }
    const auto bytes = std::as_bytes(std::span(directions));
    XXH3_64bits_update(hash, bytes.data(), bytes.size());
    out.write_at(first * sizeof(Vec3), bytes);
  });
  const std::uint64_t checksum = XXH3_64bits_digest(hash);
  XXH3_freeState(hash);
  out.close();
  std::filesystem::rename(partial, path);
  if (bundle.manifest().diagonal > 0) manifest.round_trip_max /= bundle.manifest().diagonal;
  return checksum;
}

Json to_json(const SphereComponent& c) {
  return {{"vertices", c.base.vertices},
          {"faces", c.base.faces},
          {"stretch_efficiency", c.quality.stretch_efficiency},
          {"area_distortion", c.quality.area_distortion},
          {"angle_distortion", c.quality.angle_distortion}};
}

void write_sphere_manifest(const Bundle& bundle, const SphereManifest& manifest,
                           std::uint64_t base_checksum, std::uint64_t vertex_checksum) {
  Json json;
  json["format"] = "remaps-sphere";
  json["version"] = kVersion;
  json["vertices"] = manifest.vertices;
  json["round_trip_max"] = manifest.round_trip_max;
  json["components"] = Json::array();
  for (const SphereComponent& c : manifest.components) json["components"].push_back(to_json(c));
  json["checksums"] = {{kManifestName, fmt::format("{:016x}", checksum_of_bundle(bundle))},
                       {kSphereBaseName, fmt::format("{:016x}", base_checksum)},
                       {kSphereName, fmt::format("{:016x}", vertex_checksum)}};
  store::write_file_atomically(bundle.directory() / kSphereManifestName, json.dump(2) + "\n");
}

/// Before memory is taken for it.
/// @throws CorruptionError  the file is missing or of another size
void require_size(const std::filesystem::path& path, std::uint64_t bytes) {
  std::error_code missing;
  const std::uint64_t found = std::filesystem::file_size(path, missing);
  if (missing) {
    throw CorruptionError(
        fmt::format("{}: no such file, but {} names it", path.string(), kSphereManifestName));
  }
  if (found != bytes) {
    throw CorruptionError(
        fmt::format("{}: expected {} bytes, found {}", path.string(), bytes, found));
  }
}

std::uint64_t checksum_in(const Json& json, const char* name) {
  return std::stoull(json.at("checksums").at(name).get<std::string>(), nullptr, 16);
}

}  // namespace

void check_is_sphere(const sphere::SurfaceComponent& component, std::size_t number,
                     std::size_t of) {
  if (component.is_sphere()) return;
  const std::string which =
      of == 1 ? "the surface" : fmt::format("component {} of {}, by size,", number + 1, of);
  throw GeometryError(fmt::format(
      "{} has genus {} and {} boundary {}: only closed surfaces of genus 0 can be mapped to a "
      "sphere{}",
      which, component.genus(), component.boundary_loops,
      component.boundary_loops == 1 ? "loop" : "loops",
      component.genus() == 0 ? "; --fill-holes EDGES closes holes of a mesh" : ""));
}

SphereManifest add_sphere(const Bundle& bundle, bool all, MemoryBudget& budget,
                          Progress& progress) {
  const BaseMesh& base = bundle.base();
  const Reservation memory =
      budget.reserve(kFaceBytes * base.triangle.size() + kBlockBytes, "the base on the sphere");
  const std::vector<LocalTriangle> triangles = triangles_of(base);
  sphere::SurfaceComponents found = sphere::find_components(base.position.size(), triangles);
  const std::size_t mapped = all ? found.component.size() : 1;
  if (found.component.empty()) throw GeometryError("the surface has no faces");
  for (std::size_t c = 0; c < mapped; ++c) {
    check_is_sphere(found.component[c], c, found.component.size());
  }
  std::vector<SpherePoint> place(base.position.size());
  for (std::uint32_t c = 0; c < mapped; ++c) {
    map_component(base, found.of_face, c, budget, progress, place);
  }
  for (std::uint32_t& c : found.of_face) {
    if (c >= mapped) c = kNoIndex;
  }
  const auto bytes = std::as_bytes(std::span(place));
  const std::uint64_t base_checksum = XXH3_64bits(bytes.data(), bytes.size());
  store::write_file_atomically(bundle.directory() / kSphereBaseName,
                               {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const sphere::SphericalMap map(std::move(place), triangles, std::move(found.of_face));
  SphereManifest manifest;
  const std::vector<Vec3> positions = positions_of(base);
  for (std::uint32_t c = 0; c < mapped; ++c) {
    manifest.components.push_back({found.component[c], map.quality(positions, c)});
  }
  progress.begin("vertices to the sphere");
  const std::uint64_t vertex_checksum = write_directions(bundle, map, manifest, progress);
  write_sphere_manifest(bundle, manifest, base_checksum, vertex_checksum);
  return manifest;
}

bool has_sphere(const Bundle& bundle) {
  return std::filesystem::exists(bundle.directory() / kSphereManifestName);
}

SphereFiles::SphereFiles(const Bundle& bundle, MemoryBudget& budget) {
  if (!has_sphere(bundle)) {
    throw InputError(bundle.directory().string() +
                     ": has no map to the sphere; remaps sphere makes one");
  }
  const std::filesystem::path path = bundle.directory() / kSphereManifestName;
  std::uint64_t base_checksum = 0;
  try {
    const Json json = Json::parse(store::read_whole_file(path));
    if (json.at("format") != "remaps-sphere" || json.at("version") != kVersion) {
      throw CorruptionError(
          fmt::format("{}: not a map to the sphere of version {}", path.string(), kVersion));
    }
    if (checksum_in(json, kManifestName) != checksum_of_bundle(bundle)) {
      throw CorruptionError(path.string() + ": belongs to another bundle");
    }
    base_checksum = checksum_in(json, kSphereBaseName);
    sphere_checksum_ = checksum_in(json, kSphereName);
    manifest_.vertices = json.at("vertices");
    manifest_.round_trip_max = json.at("round_trip_max");
    manifest_.components.resize(json.at("components").size());
    for (std::size_t c = 0; c < manifest_.components.size(); ++c) {
      const Json& of = json.at("components").at(c);
      manifest_.components[c].base.vertices = of.at("vertices");
      manifest_.components[c].base.faces = of.at("faces");
      manifest_.components[c].quality = {of.at("stretch_efficiency"), of.at("area_distortion"),
                                         of.at("angle_distortion")};
    }
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw CorruptionError(path.string() + ": malformed: " + error.what());
  }
  const BaseMesh& base = bundle.base();
  memory_ =
      budget.reserve(kFaceBytes * base.triangle.size() + kBlockBytes, "the base on the sphere");
  const std::filesystem::path places = bundle.directory() / kSphereBaseName;
  require_size(places, base.position.size() * sizeof(SpherePoint));
  const std::string bytes = store::read_whole_file(places);
  if (XXH3_64bits(bytes.data(), bytes.size()) != base_checksum) {
    throw CorruptionError(places.string() + ": fails its checksum");
  }
  std::vector<SpherePoint> place(base.position.size());
  std::memcpy(place.data(), bytes.data(), bytes.size());
  const std::vector<LocalTriangle> triangles = triangles_of(base);
  try {
    sphere::SurfaceComponents found = sphere::find_components(base.position.size(), triangles);
    if (manifest_.components.empty() || manifest_.components.size() > found.component.size()) {
      throw CorruptionError(path.string() + ": another number of components than the base has");
    }
    for (std::uint32_t& c : found.of_face) {
      if (c >= manifest_.components.size()) c = kNoIndex;
    }
    for (std::size_t c = 0; c < manifest_.components.size(); ++c) {
      manifest_.components[c].base = found.component[c];
    }
    map_.emplace(std::move(place), triangles, std::move(found.of_face));
  } catch (const GeometryError& error) {
    throw CorruptionError(places.string() + ": " + error.what());
  }
}

void SphereFiles::check_vertices(const Bundle& bundle, Progress& progress) const {
  const std::filesystem::path path = bundle.directory() / kSphereName;
  require_size(path, bundle.manifest().input_vertices * sizeof(Vec3));
  const store::File file = store::File::open_read(path);
  if (checksum_file(path) != sphere_checksum_) {
    throw CorruptionError(path.string() + ": fails its checksum");
  }
  std::vector<Vec3> there;
  for_map_blocks(bundle, progress, [&](std::uint64_t first, const std::vector<MapRecord>& records) {
    there.resize(records.size());
    file.read_at(first * sizeof(Vec3), std::as_writable_bytes(std::span(there)));
    for (std::size_t i = 0; i < records.size(); ++i) {
      const Vec3 here = direction_of(*map_, records[i]);
      if (std::isnan(here.x) ? std::isnan(there[i].x) : here == there[i]) continue;
      throw CorruptionError(fmt::format("{}: input vertex {} is not where map.bin and {} say",
                                        path.string(), first + i, kSphereBaseName));
    }
  });
}

}  // namespace remaps::pipeline
