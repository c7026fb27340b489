#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

class PlyWriter final : public CountedWriter {
 public:
  PlyWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces,
            std::vector<AttributeSpec> attributes)
      : CountedWriter(path, vertices, faces, std::move(attributes)),
        wide_(vertices > std::numeric_limits<std::uint32_t>::max()) {
    const bool fits_int = vertices <= std::numeric_limits<std::int32_t>::max();
    const std::string header = fmt::format(
        "ply\n"
        "format binary_little_endian 1.0\n"
        "element vertex {}\n"
        "property float x\n"
        "property float y\n"
        "property float z\n"
        "{}"
        "element face {}\n"
        "property list uchar {} vertex_indices\n"
        "{}{}"
        "end_header\n",
        vertices, properties(AttributePer::vertex), faces,
        fits_int ? "int"
        : wide_  ? "uint64"
                 : "uint",
        texture_property(), properties(AttributePer::face));
    sink().write(header.data(), header.size());
  }

 private:
  /// The header's lines about the attributes of an element.
  std::string properties(AttributePer per) const {
    std::string lines;
    for (const AttributeSpec& spec : attributes()) {
      if (spec.per != per) continue;
      for (const AttributeComponent& c : spec.components) {
        lines += fmt::format("property {} {}\n", type_name(c.type), c.name);
      }
    }
    return lines;
  }
  /// Finds the first texture coordinates of corners, where they are in a row and how long they are.
  std::string texture_property() {
    std::size_t at = 0;
    for (const AttributeSpec& spec : attributes()) {
      if (spec.per != AttributePer::corner) continue;
      if (spec.kind == AttributeKind::uv && spec.components.size() == 2 && texture_bytes_ == 0) {
        texture_at_ = at;
        texture_bytes_ = row_bytes(spec);
        return fmt::format("property list uchar {} texcoord\n", type_name(spec.components[0].type));
      }
      at += row_bytes(spec);
    }
    return "";
  }
  static const char* type_name(ScalarType type) {
    constexpr const char* kNames[] = {"char", "uchar", "short",  "ushort", "int",
                                      "uint", "int64", "uint64", "float",  "double"};
    return kNames[static_cast<std::size_t>(type)];
  }

  void put_vertices(std::span<const Vec3> positions, std::span<const std::byte> rows) override {
    const std::size_t row = rows.size() / positions.size();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      put_positions(positions.subspan(i, 1));
      sink().write(rows.data() + i * row, row);
    }
  }

  void put_faces(std::span<const Triangle> triangles, std::span<const std::byte> face_rows,
                 std::span<const std::byte> corner_rows) override {
    const std::size_t face = face_rows.size() / triangles.size();
    const std::size_t corner = corner_rows.size() / triangles.size() / 3;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      put_triangles(triangles.subspan(i, 1));
      if (texture_bytes_ > 0) {
        const char values = 6;
        sink().write(&values, 1);
        for (std::size_t k = 0; k < 3; ++k) {
          sink().write(corner_rows.data() + (3 * i + k) * corner + texture_at_, texture_bytes_);
        }
      }
      sink().write(face_rows.data() + i * face, face);
    }
  }

  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& position : positions) {
      const Vec3f stored = to_float(position);
      std::memcpy(sink().room(sizeof stored), &stored, sizeof stored);
      sink().advance(sizeof stored);
    }
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    if (wide_) {
      put<std::uint64_t>(triangles);
    } else {
      put<std::uint32_t>(triangles);
    }
  }

  template <class Index>
  void put(std::span<const Triangle> triangles) {
    constexpr std::size_t kRecord = 1 + 3 * sizeof(Index);
    for (const Triangle& triangle : triangles) {
      const Index corners[3] = {static_cast<Index>(triangle[0]), static_cast<Index>(triangle[1]),
                                static_cast<Index>(triangle[2])};
      char* const to = sink().room(kRecord);
      to[0] = 3;
      std::memcpy(to + 1, corners, sizeof corners);
      sink().advance(kRecord);
    }
  }

  bool wide_;
  std::size_t texture_at_ = 0, texture_bytes_ = 0;  // of texture coordinates in a corner's row
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_ply_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   std::vector<AttributeSpec> attributes) {
  return std::make_unique<PlyWriter>(path, vertices, faces, std::move(attributes));
}

}  // namespace remaps
