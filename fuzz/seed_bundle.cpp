#include "seed_bundle.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <span>

#include "remaps/formats/mesh_writer.h"
#include "remaps/generate/scan_generator.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/remesh.h"
#include "remaps/store/file.h"

namespace remaps::fuzz {
namespace {

constexpr std::size_t kDigits = 16;

void make_mesh(const std::filesystem::path& path) {
  GeneratorOptions options;
  options.vertices = 700;
  const ScanGenerator generator(options);
  const auto writer = open_mesh_writer(path, generator.vertices(), generator.faces());
  generator.positions([&](std::span<const Vec3> p) { writer->write_positions(p); });
  generator.triangles([&](std::span<const Triangle> t) { writer->write_triangles(t); });
  writer->close();
}

/// Replaces the checksum that stands behind a file's name in a manifest, if one does.
void put_checksum(std::string& manifest, std::string_view name, std::string_view digits) {
  const std::string key = fmt::format("\"{}\": \"", name);
  const std::size_t at = manifest.rfind(key);
  if (at == std::string::npos || at + key.size() + kDigits > manifest.size()) return;
  manifest.replace(at + key.size(), kDigits, digits);
}

store::Bytes bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

SeedBundle::SeedBundle() : directory_(scratch_directory() / "seed.remaps") {
  pipeline::RemeshOptions options;
  options.input = scratch_directory() / "seed.ply";
  options.bundle = directory_;
  options.temp_dir = scratch_directory();
  options.base_vertices = 12;
  options.domain_buffer = 600;
  options.memory_bytes = 32 << 20;
  options.threads = 1;
  make_mesh(options.input);
  Progress progress;
  pipeline::remesh(options, progress);
  manifest_ = pipeline::read_manifest(directory_);
  levels_ = pipeline::Bundle(directory_).manifest().levels;
}

SeedBundle::Place SeedBundle::place_of(BundlePart part) const {
  if (part == BundlePart::tile) return {directory_ / pipeline::kTilesName, kTileKind, 0};
  const bool first = part == BundlePart::first_records || part == BundlePart::first_survivors;
  const bool records = part == BundlePart::first_records || part == BundlePart::last_records;
  return {directory_ / pipeline::log_name(first ? 0 : levels_ - 1), kLogKind, records ? 0u : 1u};
}

std::filesystem::path SeedBundle::file_of(BundlePart part) const {
  switch (part) {
    case BundlePart::manifest:
      return directory_ / pipeline::kManifestName;
    case BundlePart::base:
      return directory_ / pipeline::kBaseName;
    case BundlePart::map:
      return directory_ / pipeline::kMapName;
    default:
      return place_of(part).path;
  }
}

store::Bytes SeedBundle::part(BundlePart part) const {
  if (part <= BundlePart::map) return bytes_of(store::read_whole_file(file_of(part)));
  const Place place = place_of(part);
  store::Bytes bytes;
  store::SectionFile(place.path, place.kind).read(place.section, bytes);
  return bytes;
}

void SeedBundle::write_with(BundlePart part, Input content) const {
  const std::filesystem::path path = file_of(part);
  if (part == BundlePart::manifest) {
    write_manifest(std::string(reinterpret_cast<const char*>(content.data()), content.size()),
                   part);
    return;
  }
  const std::filesystem::path sound = path.string() + ".sound";
  std::filesystem::rename(path, sound);
  if (part <= BundlePart::map) {
    write_file(path, content);
    write_manifest(manifest_, part);
    return;
  }
  const Place place = place_of(part);
  const store::SectionFile from(sound, place.kind);
  store::SectionFileWriter to(path, place.kind);
  store::Bytes bytes;
  for (std::size_t i = 0; i < from.sections(); ++i) {
    if (i != place.section) from.read(i, bytes);
    to.append(store::pack_section(i == place.section ? content : Input(bytes)));
  }
  to.seal();
}

void SeedBundle::restore(BundlePart part) const {
  if (part <= BundlePart::map) write_file(file_of(BundlePart::manifest), bytes_of(manifest_));
  if (part != BundlePart::manifest) {
    std::filesystem::rename(file_of(part).string() + ".sound", file_of(part));
  }
}

void SeedBundle::write_manifest(std::string text, BundlePart changed) const {
  if (changed != BundlePart::manifest) {
    const std::uint64_t checksum = pipeline::checksum_file(file_of(changed));
    put_checksum(text, file_of(changed).filename().string(), fmt::format("{:016x}", checksum));
  }
  put_checksum(text, pipeline::kManifestName, std::string(kDigits, '0'));
  const std::uint64_t own = XXH3_64bits(text.data(), text.size());
  put_checksum(text, pipeline::kManifestName, fmt::format("{:016x}", own));
  write_file(file_of(BundlePart::manifest), bytes_of(text));
}

}  // namespace remaps::fuzz
