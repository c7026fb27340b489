#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/attribute_file.h"
#include "remaps/mesh/base_mesh.h"
#include "remaps/mesh/topology.h"
#include "remaps/resample/resampler.h"
#include "remaps/store/section_file.h"

namespace remaps::pipeline {

/// What a bundle's manifest.json says. Format: docs/formats/bundle.md.
struct Manifest {
  std::string input_name;            ///< file name only
  std::uint64_t input_vertices = 0;  ///< all, those without a face included
  std::uint64_t input_faces = 0;  ///< all triangles of the file, those that were left out included
  std::uint64_t absent_vertices = 0;  ///< of the input: not finite, and so in no tile
  std::uint64_t filled_faces = 0;     ///< made by repair; numbered from input_faces on
  std::uint64_t copied_vertices = 0;  ///< made by repair; numbered from input_vertices on
  Topology topology;                  ///< of the repaired input, counted on that
  Vec3 origin;                        ///< added to stored positions
  double diagonal = 0;                ///< of the input's bounding box
  std::uint64_t base_vertices_requested = 0;
  double feature_angle_deg = 0;             ///< 0: none were kept by angle
  std::vector<std::string> feature_labels;  ///< between which features were kept
  unsigned levels = 0;                      ///< number of logs
  std::vector<std::uint64_t> segments;      ///< (levels)
  std::uint64_t map_checksum = 0;           ///< XXH3-64 of map.bin
  std::uint64_t base_checksum = 0;          ///< XXH3-64 of base.ply
  AttributeLayout attributes;  ///< of attributes.bin; without any there is no such file
};

std::string log_name(std::size_t level);
inline constexpr const char* kTilesName = "tiles.bin";
inline constexpr const char* kMapName = "map.bin";
inline constexpr const char* kAttributesName = "attributes.bin";
inline constexpr const char* kCopiesName = "copies.bin";
inline constexpr const char* kBaseName = "base.ply";
inline constexpr const char* kManifestName = "manifest.json";

/// Writes manifest.json, with a checksum of its own text in it.
void write_manifest(const Manifest& manifest, const std::filesystem::path& directory);
/// XXH3-64 of a file, read in pieces.
std::uint64_t checksum_file(const std::filesystem::path& path);

void write_base(const BaseMesh& base, const Vec3& origin, const std::filesystem::path& path);

/// A sealed bundle, open for reading.
class Bundle {
 public:
  /// Opens and checks manifest and indices; blocks are checked as they are read.
  /// @throws InputError  no such directory, or no manifest in it; CorruptionError: damaged
  explicit Bundle(const std::filesystem::path& directory);

  const std::filesystem::path& directory() const { return directory_; }
  const Manifest& manifest() const { return manifest_; }
  const BaseMesh& base() const {
    return base_;
  }  ///< vertex_id is empty: base.ply has none; positions are relative
  const store::SectionFile& log(std::size_t level) const { return *logs_[level]; }
  const store::SectionFile& tiles() const { return *tiles_; }
  AttributeFile* attributes() const { return attributes_.get(); }  ///< null: there are none
  resample::MapFiles files() const;

 private:
  std::filesystem::path directory_;
  Manifest manifest_;
  BaseMesh base_;
  std::vector<std::unique_ptr<store::SectionFile>> logs_;
  std::unique_ptr<store::SectionFile> tiles_;
  std::unique_ptr<AttributeFile> attributes_;
};

}  // namespace remaps::pipeline
