#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/formats/attribute_field.h"
#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

/// Room for a line: a keyword, twelve numbers of at most 20 characters with a separator each.
constexpr std::size_t kLongestLine = 320;

/// The first values of an attribute.
template <std::size_t kCount>
std::array<float, kCount> first_of(const AttributeField& field, std::span<const std::byte> row) {
  std::array<float, kCount> values{};
  field.read(row, values);
  return values;
}

/// Colours of vertices stand behind their positions, normals and texture coordinates on lines of
/// their own: one for each vertex, or three before each face.
class ObjWriter final : public CountedWriter {
 public:
  ObjWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces,
            std::vector<AttributeSpec> specs)
      : CountedWriter(path, vertices, faces, std::move(specs)),
        colour_(find(AttributeKind::colour, AttributePer::vertex, 3)),
        normal_(find(AttributeKind::normal, AttributePer::vertex, 3)),
        texture_(find(AttributeKind::uv, AttributePer::vertex, 2)),
        corner_normal_(find(AttributeKind::normal, AttributePer::corner, 3)),
        corner_texture_(find(AttributeKind::uv, AttributePer::corner, 2)) {
    if (corner_normal_) normal_.reset();
    if (corner_texture_) texture_.reset();
  }

 private:
  std::optional<AttributeField> find(AttributeKind kind, AttributePer per,
                                     std::size_t least) const {
    return find_field(attributes(), per, kind, least, ~std::size_t{0});
  }

  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& position : positions) {
      const Vec3f p = to_float(position);
      put_line("v", std::array{p.x, p.y, p.z});
    }
  }

  void put_vertices(std::span<const Vec3> positions, std::span<const std::byte> rows) override {
    const std::size_t width = rows.size() / positions.size();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Vec3f p = to_float(positions[i]);
      const auto row = rows.subspan(i * width, width);
      if (colour_) {
        const auto c = first_of<3>(*colour_, row);
        put_line("v", std::array{p.x, p.y, p.z, c[0], c[1], c[2]});
      } else {
        put_line("v", std::array{p.x, p.y, p.z});
      }
      if (normal_) put_line("vn", first_of<3>(*normal_, row));
      if (texture_) put_line("vt", first_of<2>(*texture_, row));
    }
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) put_face(t);
  }

  void put_faces(std::span<const Triangle> triangles, std::span<const std::byte>,
                 std::span<const std::byte> corner_rows) override {
    const std::size_t width = corner_rows.size() / triangles.size() / 3;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto row = corner_rows.subspan((3 * i + k) * width, width);
        if (corner_normal_) put_line("vn", first_of<3>(*corner_normal_, row));
        if (corner_texture_) put_line("vt", first_of<2>(*corner_texture_, row));
      }
      put_face(triangles[i]);
      corners_ += 3;
    }
  }

  void put_face(const Triangle& triangle) {
    char* const first = sink().room(kLongestLine);
    char* to = first;
    *to++ = 'f';
    const auto put = [&](std::uint64_t number) {
      to = std::to_chars(to, first + kLongestLine, number + 1).ptr;
    };
    const bool texture = texture_ || corner_texture_;
    const bool normal = normal_ || corner_normal_;
    for (std::size_t k = 0; k < 3; ++k) {
      *to++ = ' ';
      put(triangle[k]);
      if (texture || normal) *to++ = '/';
      if (texture) put(corner_texture_ ? corners_ + k : triangle[k]);
      if (normal) *to++ = '/';
      if (normal) put(corner_normal_ ? corners_ + k : triangle[k]);
    }
    *to++ = '\n';
    sink().advance(static_cast<std::size_t>(to - first));
  }

  /// Floats as the shortest text that reads back as the same float.
  template <std::size_t kCount>
  void put_line(std::string_view keyword, const std::array<float, kCount>& numbers) {
    char* const first = sink().room(kLongestLine);
    char* to = std::copy(keyword.begin(), keyword.end(), first);
    for (const float number : numbers) {
      *to++ = ' ';
      to = std::to_chars(to, first + kLongestLine, number).ptr;
    }
    *to++ = '\n';
    sink().advance(static_cast<std::size_t>(to - first));
  }

  std::optional<AttributeField> colour_, normal_, texture_;  // of vertices
  std::optional<AttributeField> corner_normal_, corner_texture_;
  std::uint64_t corners_ = 0;  // written
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_obj_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   std::vector<AttributeSpec> attributes) {
  return std::make_unique<ObjWriter>(path, vertices, faces, std::move(attributes));
}

}  // namespace remaps
