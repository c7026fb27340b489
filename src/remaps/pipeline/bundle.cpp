#include "remaps/pipeline/bundle.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "remaps/formats/mesh_reader.h"
#include "remaps/formats/mesh_writer.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/pipeline/query.h"
#include "remaps/store/file.h"

namespace remaps::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBundleVersion = 2;

/// What stands before the manifest's checksum of itself: 16 digits, taken as zeros for the sum.
constexpr std::string_view kOwnChecksum = "\"manifest.json\": \"";
constexpr std::size_t kChecksumDigits = 16;
constexpr const char* kNoChecksum = "0000000000000000";

/// The place of the manifest's own checksum in its text, or npos.
std::size_t find_own_checksum(std::string_view text) {
  const std::size_t at = text.rfind(kOwnChecksum);
  const bool whole =
      at != std::string_view::npos && at + kOwnChecksum.size() + kChecksumDigits <= text.size();
  return whole ? at + kOwnChecksum.size() : std::string_view::npos;
}

std::string own_checksum(std::string text, std::size_t place) {
  text.replace(place, kChecksumDigits, kNoChecksum);
  return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
}

Json to_json(const AttributeSpec& spec) {
  Json json;
  json["name"] = spec.name;
  json["kind"] = name_of(spec.kind);
  json["per"] = name_of(spec.per);
  json["components"] = Json::array();
  for (const AttributeComponent& c : spec.components) {
    json["components"].push_back({{"name", c.name}, {"type", name_of(c.type)}});
  }
  return json;
}

AttributeSpec attribute_from(const Json& json) {
  AttributeSpec spec;
  spec.name = json.at("name");
  spec.kind = attribute_kind_named(json.at("kind").get<std::string>()).value();
  spec.per = attribute_per_named(json.at("per").get<std::string>()).value();
  for (const Json& c : json.at("components")) {
    spec.components.push_back(
        {c.at("name"), scalar_type_named(c.at("type").get<std::string>()).value()});
  }
  if (spec.components.empty()) throw CorruptionError("an attribute has no components");
  return spec;
}

Manifest parse_manifest(const std::filesystem::path& path, const std::string& text) {
  Manifest m;
  try {
    const Json json = Json::parse(text);
    if (json.at("format") != "remaps-bundle")
      throw CorruptionError(path.string() + ": not a bundle's manifest");
    if (json.at("version") != kBundleVersion) {
      throw CorruptionError(fmt::format("{}: bundle version {}, this program reads {}",
                                        path.string(), json.at("version").dump(), kBundleVersion));
    }
    const std::size_t place = find_own_checksum(text);
    if (place == std::string::npos) throw CorruptionError(path.string() + ": has no checksum");
    if (text.substr(place, kChecksumDigits) != own_checksum(text, place)) {
      throw CorruptionError(path.string() + ": fails its checksum");
    }
    const Json& input = json.at("input");
    m.input_name = input.at("name");
    m.input_vertices = input.at("vertices");
    m.input_faces = input.at("file_faces");
    m.absent_vertices = input.at("absent_vertices");
    m.copied_vertices = input.at("copied_vertices");
    m.filled_faces = input.at("filled_faces");
    m.topology.vertices = input.at("referenced_vertices");
    m.topology.faces = input.at("faces");
    m.topology.boundary_edges = input.at("boundary_edges");
    m.topology.components = input.at("components");
    m.topology.boundary_loops = input.at("boundary_loops");
    m.diagonal = input.at("bbox_diagonal");
    const Json& origin = input.at("origin");
    m.origin = {origin.at(0), origin.at(1), origin.at(2)};
    m.base_vertices_requested = json.at("base_vertices_requested");
    m.feature_angle_deg = json.value("feature_angle_deg", 0.0);
    for (const Json& level : json.at("levels")) m.segments.push_back(level.at("segments"));
    m.levels = static_cast<unsigned>(m.segments.size());
    if (json.contains("attributes")) {
      const Json& attributes = json.at("attributes");
      m.attributes.vertices = attributes.at("vertices");
      m.attributes.faces = attributes.at("faces");
      m.attributes.copies = attributes.value("copies", std::uint64_t{0});
      for (const Json& spec : attributes.at("list")) {
        m.attributes.specs.push_back(attribute_from(spec));
      }
    }
    m.map_checksum = std::stoull(json.at("checksums").at(kMapName).get<std::string>(), nullptr, 16);
    m.base_checksum =
        std::stoull(json.at("checksums").at(kBaseName).get<std::string>(), nullptr, 16);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw CorruptionError(path.string() + ": malformed manifest: " + error.what());
  }
  if (m.levels == 0 || !(m.diagonal >= 0))
    throw CorruptionError(path.string() + ": malformed manifest");
  return m;
}

BaseMesh read_base(const std::filesystem::path& path, const Vec3& origin) {
  BaseMesh base;
  try {
    const auto reader = open_mesh_reader(path);
    reader->read_positions([&](std::span<const Vec3> positions) {
      for (const Vec3& p : positions) {
        base.position.push_back(to_float(p - origin));
        if (!std::isnan(p.x)) continue;
        throw CorruptionError(
            fmt::format("{}: vertex {} is not finite", path.string(), base.position.size() - 1));
      }
    });
    reader->read_triangles([&](std::span<const Triangle> triangles) {
      for (const Triangle& t : triangles) {
        base.triangle.push_back({narrow<std::uint32_t>(t[0]), narrow<std::uint32_t>(t[1]),
                                 narrow<std::uint32_t>(t[2])});
      }
    });
  } catch (const InputError& error) {
    throw CorruptionError(error.what());
  }
  return base;
}

}  // namespace

std::string read_manifest(const std::filesystem::path& bundle) {
  const std::filesystem::path path = bundle / kManifestName;
  if (!std::filesystem::exists(path)) {
    throw InputError(bundle.string() + ": not a bundle (no " + std::string(kManifestName) +
                     " in it)");
  }
  return store::read_whole_file(path);
}

std::string log_name(std::size_t level) {
  return fmt::format("log-{}.bin", level);
}

std::uint64_t checksum_file(const std::filesystem::path& path) {
  const store::File file = store::File::open_read(path);
  XXH3_state_t* hash = XXH3_createState();
  XXH3_64bits_reset(hash);
  store::Bytes buffer(1 << 20);
  const std::uint64_t size = file.size();
  for (std::uint64_t at = 0; at < size; at += buffer.size()) {
    const std::span<std::byte> part(
        buffer.data(), static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), size - at)));
    file.read_at(at, part);
    XXH3_64bits_update(hash, part.data(), part.size());
  }
  const std::uint64_t checksum = XXH3_64bits_digest(hash);
  XXH3_freeState(hash);
  return checksum;
}

void write_manifest(const Manifest& m, const std::filesystem::path& directory) {
  Json json;
  json["format"] = "remaps-bundle";
  json["version"] = kBundleVersion;
  json["input"] = {{"name", m.input_name},
                   {"vertices", m.input_vertices},
                   {"file_faces", m.input_faces},
                   {"absent_vertices", m.absent_vertices},
                   {"copied_vertices", m.copied_vertices},
                   {"filled_faces", m.filled_faces},
                   {"referenced_vertices", m.topology.vertices},
                   {"faces", m.topology.faces},
                   {"boundary_edges", m.topology.boundary_edges},
                   {"components", m.topology.components},
                   {"boundary_loops", m.topology.boundary_loops},
                   {"euler_characteristic", m.topology.euler_characteristic()},
                   {"bbox_diagonal", m.diagonal},
                   {"origin", {m.origin.x, m.origin.y, m.origin.z}}};
  json["base_vertices_requested"] = m.base_vertices_requested;
  if (m.feature_angle_deg > 0) json["feature_angle_deg"] = m.feature_angle_deg;
  json["levels"] = Json::array();
  for (std::size_t level = 0; level < m.segments.size(); ++level) {
    json["levels"].push_back({{"log", log_name(level)}, {"segments", m.segments[level]}});
  }
  // Bundles without attributes are as they always were.
  if (!m.attributes.specs.empty()) {
    json["attributes"] = {{"vertices", m.attributes.vertices},
                          {"faces", m.attributes.faces},
                          {"list", Json::array()}};
    if (m.attributes.copies > 0) json["attributes"]["copies"] = m.attributes.copies;
    for (const AttributeSpec& spec : m.attributes.specs) {
      json["attributes"]["list"].push_back(to_json(spec));
    }
  }
  json["checksums"] = {{kMapName, fmt::format("{:016x}", m.map_checksum)},
                       {kBaseName, fmt::format("{:016x}", m.base_checksum)},
                       {kManifestName, kNoChecksum}};
  // The name of the input need not be UTF-8.
  std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  const std::size_t place = find_own_checksum(text);
  text.replace(place, kChecksumDigits, own_checksum(text, place));
  store::write_file_atomically(directory / kManifestName, text);
}

void write_base(const BaseMesh& base, const Vec3& origin, const std::filesystem::path& path) {
  const auto writer = open_mesh_writer(path, base.position.size(), base.triangle.size());
  std::vector<Vec3> positions;
  for (const Vec3f& p : base.position) positions.push_back(origin + widen(p));
  std::vector<Triangle> triangles;
  for (const auto& t : base.triangle) triangles.push_back({t[0], t[1], t[2]});
  writer->write_positions(positions);
  writer->write_triangles(triangles);
  writer->close();
}

Bundle::Bundle(const std::filesystem::path& directory) : directory_(directory) {
  manifest_ = parse_manifest(directory / kManifestName, read_manifest(directory));
  try {
    base_ = read_base(directory / kBaseName, manifest_.origin);
    for (std::size_t level = 0; level < manifest_.levels; ++level) {
      logs_.push_back(std::make_unique<store::SectionFile>(directory / log_name(level), kLogKind));
      const std::size_t sections = logs_.back()->sections();
      if (sections % 2 != 0 || sections / 2 != manifest_.segments[level]) {
        throw CorruptionError((directory / log_name(level)).string() +
                              ": another number of segments than the manifest says");
      }
    }
    tiles_ = std::make_unique<store::SectionFile>(directory / kTilesName, kTileKind);
    if (!manifest_.attributes.specs.empty()) {
      attributes_ = std::make_unique<AttributeFile>(directory / kAttributesName,
                                                    manifest_.attributes, directory / kCopiesName);
    }
  } catch (const IoError& error) {
    throw CorruptionError(error.what());
  }
  if (tiles_->sections() != manifest_.segments[0] || manifest_.segments.back() != 1) {
    throw CorruptionError(directory.string() + ": tiles and logs do not belong together");
  }
}

resample::MapFiles Bundle::files() const {
  resample::MapFiles files;
  for (const auto& log : logs_) files.logs.push_back(log.get());
  files.tiles = tiles_.get();
  return files;
}

}  // namespace remaps::pipeline
