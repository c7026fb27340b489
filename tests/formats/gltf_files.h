#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "formats/mesh_files.h"

namespace remaps {

/// A .glb of this JSON and, unless empty, these bytes.
inline std::string glb_of(std::string json, std::string bin) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  bin.resize((bin.size() + 3) / 4 * 4, '\0');
  const std::size_t length = 20 + json.size() + (bin.empty() ? 0 : 8 + bin.size());
  std::string glb = "glTF";
  append(glb, std::uint32_t{2});
  append(glb, static_cast<std::uint32_t>(length));
  append(glb, static_cast<std::uint32_t>(json.size()));
  glb += "JSON" + json;
  if (bin.empty()) return glb;
  append(glb, static_cast<std::uint32_t>(bin.size()));
  glb.append("BIN\0", 4);
  return glb + bin;
}

/// A glTF file that grows: arrays are put behind each other into one buffer.
class GltfSketch {
 public:
  using Json = nlohmann::json;

  GltfSketch() {
    json["asset"]["version"] = "2.0";
    json["scene"] = 0;
    json["scenes"] = Json::parse(R"([{"nodes": [0]}])");
    json["nodes"] = Json::parse(R"([{"mesh": 0}])");
    json["meshes"] = Json::parse(R"([{"primitives": []}])");
  }

  /// A view of these bytes; its number.
  std::size_t view(std::string_view bytes) {
    bin.resize((bin.size() + 3) / 4 * 4, '\0');
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}});
    bin += bytes;
    return json["bufferViews"].size() - 1;
  }
  template <class T>
  std::size_t accessor(const std::vector<T>& values, int component, const char* type) {
    std::string bytes;
    for (const T& value : values) append(bytes, value);
    const char last = std::string_view(type).back();
    const std::size_t count =
        values.size() / (last == 'R' ? 1 : static_cast<std::size_t>(last - '0'));
    json["accessors"].push_back({{"bufferView", view(bytes)},
                                 {"componentType", component},
                                 {"count", count},
                                 {"type", type}});
    return json["accessors"].size() - 1;
  }
  std::size_t positions(const std::vector<float>& values) { return accessor(values, 5126, "VEC3"); }
  std::size_t indices(const std::vector<std::uint16_t>& values) {
    return accessor(values, 5123, "SCALAR");
  }
  Json& primitive(std::size_t positions) {
    Json& all = json["meshes"][0]["primitives"];
    all.push_back({{"attributes", {{"POSITION", positions}}}});
    return all.back();
  }
  Json& primitive(std::size_t positions, std::size_t indices) {
    Json& added = primitive(positions);
    added["indices"] = indices;
    return added;
  }

  std::string glb() {
    json["buffers"] = Json::array({{{"byteLength", bin.size()}}});
    return glb_of(json.dump(), bin);
  }
  /// A .gltf whose buffer is at this URI.
  std::string gltf(const std::string& uri) {
    json["buffers"] = Json::array({{{"byteLength", bin.size()}, {"uri", uri}}});
    return json.dump(1);
  }

  Json json;
  std::string bin;
};

/// A square of two triangles.
inline const std::vector<float> kGltfSquare = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
inline const std::vector<Triangle> kGltfSquareTriangles = {{0, 1, 2}, {0, 2, 3}};

inline GltfSketch square_sketch() {
  GltfSketch sketch;
  const std::size_t at = sketch.positions(kGltfSquare);
  sketch.primitive(at, sketch.indices({0, 1, 2, 0, 2, 3}));
  return sketch;
}

inline std::string base64_of(std::string_view bytes, bool padded = true) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < n; ++k) {
      group |= std::uint32_t{static_cast<std::uint8_t>(bytes[i + k])} << (16 - 8 * k);
    }
    for (std::size_t k = 0; k <= n; ++k) text += kDigits[group >> (18 - 6 * k) & 63];
    if (padded) text.append(3 - n, '=');
  }
  return text;
}

}  // namespace remaps
