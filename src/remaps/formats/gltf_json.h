#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/formats/random_source.h"

namespace remaps {

/// Where the payload of a data: URI lies in the file. The JSON text in memory has "@N" in its
/// place.
struct DataPayload {
  std::uint64_t offset = 0, bytes = 0;
  bool escaped = false;  ///< has backslashes, which are no base64
};

/// The JSON of a glTF file: what tells the geometry, without names, extras, materials, images and
/// so on, and without the payloads of data: URIs, which may be large.
struct GltfJson {
  nlohmann::json root;
  std::vector<DataPayload> payloads;
};

/// Text of more bytes, payloads left out, is refused: in memory it takes several times as many.
inline constexpr std::size_t kMostGltfJson = std::size_t{8} << 20;

/// Reads and parses the JSON at a place of a file.
/// @throws InputError  malformed, too deep or too long
GltfJson read_gltf_json(const RandomSource& source, std::uint64_t offset, std::uint64_t bytes);

/// A value of the JSON with its place, which messages name: "accessors[3].byteOffset". Whatever is
/// not as expected throws InputError. The JSON must outlive it.
class GltfValue {
 public:
  GltfValue(const nlohmann::json& json, const std::filesystem::path& file, std::string place = {})
      : json_(&json), file_(&file), place_(std::move(place)) {}

  const std::string& place() const { return place_; }
  [[noreturn]] void fail(std::string_view what) const;

  /// A member of an object.
  std::optional<GltfValue> find(std::string_view key) const;
  GltfValue require(std::string_view key) const;
  /// An element of an array.
  std::size_t size() const;
  GltfValue item(std::size_t i) const;
  /// A member that is a whole number of at least 0.
  std::uint64_t count(std::string_view key, std::uint64_t otherwise) const;
  /// The element of an array of the root that this number names.
  GltfValue element(const GltfValue& root, std::string_view array) const;

  std::uint64_t whole() const;
  double number() const;
  std::string text() const;
  bool flag() const;

 private:
  [[noreturn]] void fail_expected(std::string_view what) const;

  const nlohmann::json* json_;
  const std::filesystem::path* file_;
  std::string place_;
};

}  // namespace remaps
