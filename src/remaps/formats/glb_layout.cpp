#include "remaps/formats/glb_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

namespace remaps {
namespace {

constexpr unsigned kBytes = 5121, kWords = 5123, kFloats = 5126;
constexpr std::size_t kTriangleBytes = 3 * sizeof(std::uint32_t);

std::size_t bytes_of(unsigned component) {
  return component == kBytes ? 1 : component == kWords ? 2 : 4;
}

/// A float as a decimal of the same value as a double: whoever reads it in either type gets it.
void append_number(std::string& text, double value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, std::end(digits), value).ptr);
}

void append_point(std::string& text, const Vec3& p) {
  text += '[';
  append_number(text, p.x);
  text += ',';
  append_number(text, p.y);
  text += ',';
  append_number(text, p.z);
  text += ']';
}

/// Of length 1, whatever it was.
void make_unit(std::array<float, 4>& n) {
  const double length = std::hypot(double(n[0]), double(n[1]), double(n[2]));
  if (length > 0 && std::isfinite(length)) {
    for (std::size_t i = 0; i < 3; ++i) n[i] = static_cast<float>(double(n[i]) / length);
  } else {
    n = {0, 0, 1, 0};
  }
}

/// glTF counts texture coordinates from above.
float turned(float v) {
  return 1 - v;
}

}  // namespace

void GlbLayout::add(std::string name, unsigned component, std::size_t numbers) {
  fields_.push_back({std::move(name), component, numbers, stride_});
  // Whatever is in a vertex begins at a multiple of four bytes.
  stride_ += (numbers * bytes_of(component) + 3) / 4 * 4;
}

GlbLayout::GlbLayout(std::span<const AttributeSpec> specs) {
  using Kind = AttributeKind;
  constexpr auto kVertex = AttributePer::vertex;
  if (const auto normal = find_field(specs, kVertex, Kind::normal, 3, 3)) {
    sources_.push_back({*normal, fields_.size()});
    add("NORMAL", kFloats, 3);
  }
  if (const auto colour = find_field(specs, kVertex, Kind::colour, 3, 4)) {
    const ScalarType type = colour->spec().components[0].type;
    const bool alike =
        std::all_of(colour->spec().components.begin(), colour->spec().components.end(),
                    [type](const AttributeComponent& c) { return c.type == type; });
    sources_.push_back({*colour, fields_.size()});
    add("COLOR_0",
        alike && type == ScalarType::uint8    ? kBytes
        : alike && type == ScalarType::uint16 ? kWords
                                              : kFloats,
        colour->size());
  }
  const auto is_texture = [](const AttributeSpec& spec) {
    return spec.kind == Kind::uv && spec.components.size() == 2;
  };
  // Those of vertices first, so that those of corners are together.
  unsigned set = 0;
  for (const AttributeField& field : find_fields(specs, kVertex, is_texture)) {
    if (set == kMostGlbTextures) break;
    sources_.push_back({field, fields_.size()});
    add(fmt::format("TEXCOORD_{}", set++), kFloats, 2);
  }
  for (const AttributeField& field : find_fields(specs, AttributePer::corner, is_texture)) {
    if (set == kMostGlbTextures) break;
    corner_fields_.push_back(field);
    add(fmt::format("TEXCOORD_{}", set++), kFloats, 2);
  }
}

void GlbLayout::put(std::span<const std::byte> row, std::byte* vertex) const {
  for (const Source& source : sources_) {
    const Field& field = fields_[source.to];
    if (field.component != kFloats) {
      std::memcpy(vertex + field.at, row.data() + source.field.at(),
                  field.numbers * bytes_of(field.component));
      continue;
    }
    std::array<float, 4> values{};
    source.field.read(row, std::span(values).first(field.numbers));
    switch (source.field.spec().kind) {
      case AttributeKind::normal:
        make_unit(values);
        break;
      case AttributeKind::colour:
        for (float& value : values) value = std::clamp(value, 0.0F, 1.0F);
        break;
      default:
        values[1] = turned(values[1]);
        break;
    }
    std::memcpy(vertex + field.at, values.data(), field.numbers * sizeof(float));
  }
}

void GlbLayout::read_corner(std::span<const std::byte> row, std::span<float> values) const {
  for (const AttributeField& field : corner_fields_) {
    field.read(row, values.first(2));
    values[1] = turned(values[1]);
    values = values.subspan(2);
  }
}

std::string GlbLayout::json(const Mesh& mesh) const {
  const std::uint64_t vertex_bytes = stride_ * mesh.vertices;
  const std::uint64_t face_bytes = kTriangleBytes * mesh.faces;
  std::string names, accessors;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const Field& f = fields_[i];
    names += fmt::format(R"(,"{}":{})", f.name, i + 2);
    accessors += fmt::format(
        R"(,{{"bufferView":0,"byteOffset":{},"componentType":{},"count":{},"type":"VEC{}"{}}})",
        f.at, f.component, mesh.vertices, f.numbers,
        f.component == kFloats ? "" : R"(,"normalized":true)");
  }
  const auto offset = [](std::uint64_t bytes) {
    return bytes == 0 ? std::string() : fmt::format(R"("byteOffset":{},)", bytes);
  };
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0","generator":"remaps"}},"scene":0,"scenes":[{{"nodes":[0]}}],)"
      R"("nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":1{}}},)"
      R"("indices":0}}]}}],"buffers":[{{"byteLength":{}}}],"bufferViews":[)"
      R"({{"buffer":0,{}"byteLength":{},{}"target":34962}},)"
      R"({{"buffer":0,{}"byteLength":{},"target":34963}}],"accessors":[)"
      R"({{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}},)"
      R"({{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":)",
      names, vertex_bytes + face_bytes, offset(mesh.faces_first ? face_bytes : 0), vertex_bytes,
      fields_.empty() ? "" : fmt::format(R"("byteStride":{},)", stride_),
      offset(mesh.faces_first ? 0 : vertex_bytes), face_bytes, 3 * mesh.faces, mesh.vertices);
  append_point(json, mesh.box.low);
  json += R"(,"max":)";
  append_point(json, mesh.box.high);
  json += "}" + accessors + "]}";
  json.resize(json_bytes(), ' ');
  return json;
}

}  // namespace remaps
