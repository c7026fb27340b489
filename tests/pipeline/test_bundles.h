#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "remaps/formats/mesh_writer.h"
#include "remaps/generate/scan_generator.h"
#include "remaps/mesh/segment_log.h"
#include "remaps/pipeline/bundle.h"
#include "remaps/pipeline/query.h"
#include "remaps/pipeline/remesh.h"
#include "remaps/store/section_file.h"

namespace remaps::test {

/// A generated mesh and the bundle made of it, in many segments and several levels.
struct TestBundle {
  std::filesystem::path mesh, bundle;
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

/// @param unused  so many vertices without a face come first
inline TestBundle make_test_bundle(const std::filesystem::path& directory, BaseShape shape,
                                   std::uint64_t vertices, std::uint64_t domain_buffer,
                                   std::size_t unused = 0) {
  TestBundle made{directory / "scan.ply", directory / "scan.remaps", {}, {}};
  GeneratorOptions options;
  options.base = shape;
  options.vertices = vertices;
  options.shuffled = true;
  const ScanGenerator generator(options);
  made.positions.assign(unused, Vec3{});
  for (VertexId v = 0; v < generator.vertices(); ++v) {
    made.positions.push_back(widen(to_float(generator.vertex(v))));
  }
  for (FaceId f = 0; f < generator.faces(); ++f) {
    Triangle t = generator.triangle(f);
    for (VertexId& v : t) v += unused;
    made.triangles.push_back(t);
  }
  const auto writer = open_mesh_writer(made.mesh, made.positions.size(), made.triangles.size());
  writer->write_positions(made.positions);
  writer->write_triangles(made.triangles);
  writer->close();

  pipeline::RemeshOptions remesh;
  remesh.input = made.mesh;
  remesh.bundle = made.bundle;
  remesh.base_vertices = 60;
  remesh.domain_buffer = domain_buffer;
  remesh.memory_bytes = 64 << 20;
  remesh.threads = 2;
  Progress progress;
  pipeline::remesh(remesh, progress);
  return made;
}

inline pipeline::QueryOptions query_options(const std::filesystem::path& bundle,
                                            unsigned threads = 1) {
  pipeline::QueryOptions options;
  options.bundle = bundle;
  options.temp_dir = bundle.parent_path();
  options.memory_bytes = 48 << 20;
  options.threads = threads;
  return options;
}

/// Replaces one section of a section file by what `edit` makes of it, checksums and all.
inline void edit_section(const std::filesystem::path& path, std::array<char, 4> kind,
                         std::size_t section, const std::function<void(store::Bytes&)>& edit) {
  std::vector<store::PackedSection> packed;
  {
    const store::SectionFile file(path, kind);
    store::Bytes bytes;
    for (std::size_t i = 0; i < file.sections(); ++i) {
      file.read(i, bytes);
      if (i == section) edit(bytes);
      packed.push_back(store::pack_section(bytes));
    }
  }
  store::SectionFileWriter writer(path, kind);
  for (const store::PackedSection& p : packed) writer.append(p);
  writer.seal();
}

inline SegmentLog read_segment(const std::filesystem::path& bundle, std::size_t level,
                               std::size_t segment) {
  const store::SectionFile file(bundle / pipeline::log_name(level), kLogKind);
  SegmentLog log;
  store::Bytes bytes;
  file.read(2 * segment, bytes);
  decode_records(bytes, "log", log);
  file.read(2 * segment + 1, bytes);
  decode_survivors(bytes, "log", log);
  return log;
}

inline void write_segment(const std::filesystem::path& bundle, std::size_t level,
                          std::size_t segment, const SegmentLog& log) {
  const std::filesystem::path path = bundle / pipeline::log_name(level);
  edit_section(path, kLogKind, 2 * segment, [&](store::Bytes& b) { b = encode_records(log); });
  edit_section(path, kLogKind, 2 * segment + 1,
               [&](store::Bytes& b) { b = encode_survivors(log); });
}

/// The log with record r replaced.
inline RetriangulationLog with_record(const RetriangulationLog& log, std::size_t r,
                                      const Retriangulation& record) {
  RetriangulationLog result;
  for (std::size_t i = 0; i < log.size(); ++i) result.append(i == r ? record : log[i]);
  return result;
}

/// Overwrites bytes of a file in place.
template <class T>
void overwrite(const std::filesystem::path& path, std::uint64_t offset, const T& value) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(offset));
  file.write(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Writes the manifest anew, with the checksums of map.bin and base.ply as they are now.
inline void reseal(const std::filesystem::path& bundle,
                   const std::function<void(pipeline::Manifest&)>& edit = {}) {
  pipeline::Manifest manifest = pipeline::Bundle(bundle).manifest();
  manifest.map_checksum = pipeline::checksum_file(bundle / pipeline::kMapName);
  manifest.base_checksum = pipeline::checksum_file(bundle / pipeline::kBaseName);
  if (edit) edit(manifest);
  pipeline::write_manifest(manifest, bundle);
}

}  // namespace remaps::test
