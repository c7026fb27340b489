#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "remaps/formats/mesh_reader.h"
#include "remaps/formats/mesh_writer.h"
#include "support/remesh_job.h"

namespace remaps::test {

/// All attributes of a mesh file, as lists of rows.
struct AttributeLists {
  std::vector<AttributeSpec> specs;
  std::vector<double> vertex, face, corner;

  const AttributeSpec* find(std::string_view name) const {
    for (const AttributeSpec& spec : specs) {
      if (spec.name == name) return &spec;
    }
    return nullptr;
  }
  const std::vector<double>& rows(AttributePer per) const {
    return per == AttributePer::vertex ? vertex : per == AttributePer::face ? face : corner;
  }
  /// A component of an attribute of each element.
  std::vector<double> column(std::string_view name, std::size_t component = 0) const {
    std::size_t channel = component;
    const AttributeSpec* const wanted = find(name);
    if (wanted == nullptr) return {};
    for (const AttributeSpec& spec : specs) {
      if (&spec == wanted) break;
      if (spec.per == wanted->per) channel += spec.components.size();
    }
    std::vector<double> result;
    const std::vector<double>& all = rows(wanted->per);
    for (std::size_t at = channel; at < all.size(); at += channels(specs, wanted->per)) {
      result.push_back(all[at]);
    }
    return result;
  }
};

inline AttributeLists read_attributes(const std::filesystem::path& path) {
  AttributeLists lists;
  const auto reader = open_mesh_reader(path);
  reader->read_positions([](std::span<const Vec3>) {});
  reader->read_triangles([](std::span<const Triangle>) {});
  lists.specs = reader->attributes();
  const auto take = [&](AttributePer per, std::vector<double>& rows) {
    reader->read_attributes(per, [&](std::span<const double> part) {
      rows.insert(rows.end(), part.begin(), part.end());
    });
  };
  take(AttributePer::vertex, lists.vertex);
  take(AttributePer::face, lists.face);
  take(AttributePer::corner, lists.corner);
  return lists;
}

/// Writes a mesh with attributes: value(element, channel) of each vertex, face, and corner.
struct AttributeValues {
  std::function<double(std::size_t vertex, std::size_t channel)> vertex;
  std::function<double(std::size_t face, std::size_t channel)> face;
  std::function<double(std::size_t corner, std::size_t channel)> corner;
};

inline std::vector<std::byte> packed_rows(
    const std::vector<AttributeSpec>& all, AttributePer per, std::size_t count,
    const std::function<double(std::size_t, std::size_t)>& value) {
  const std::vector<AttributeSpec> specs = attributes_per(all, per);
  const std::size_t bytes = row_bytes(specs, per);
  std::vector<std::byte> rows(bytes == 0 ? 0 : bytes * count);
  std::vector<double> values(channels(specs, per));
  for (std::size_t i = 0; bytes > 0 && i < count; ++i) {
    for (std::size_t c = 0; c < values.size(); ++c) values[c] = value(i, c);
    pack_row(specs, values, std::span(rows).subspan(i * bytes, bytes));
  }
  return rows;
}

inline void write_with_attributes(const MeshLists& mesh, const std::vector<AttributeSpec>& specs,
                                  const AttributeValues& values,
                                  const std::filesystem::path& path) {
  const auto writer =
      open_mesh_writer(path, mesh.position.size(), mesh.triangle.size(), {std::nullopt, specs});
  writer->write_positions(mesh.position);
  const auto send = [&](AttributePer per, std::size_t count, const auto& value) {
    const auto rows = packed_rows(specs, per, count, value);
    if (!rows.empty()) writer->write_attributes(per, rows);
  };
  send(AttributePer::vertex, mesh.position.size(), values.vertex);
  send(AttributePer::face, mesh.triangle.size(), values.face);
  send(AttributePer::corner, 3 * mesh.triangle.size(), values.corner);
  writer->write_triangles(mesh.triangle);
  writer->close();
}

}  // namespace remaps::test
