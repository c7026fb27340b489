#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "remaps/formats/attribute_field.h"
#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

/// Room for a line: a dozen numbers of at most 20 characters with a separator each.
constexpr std::size_t kLongestLine = 320;

bool is_bytes(const AttributeField& colour) {
  return std::all_of(colour.spec().components.begin(), colour.spec().components.end(),
                     [](const AttributeComponent& c) { return c.type == ScalarType::uint8; });
}

/// What a line is made of. Floats are the shortest text that reads back as the same float.
class OffLine {
 public:
  explicit OffLine(char* first) : first_(first), to_(first) {}

  template <class Number>
  void put(Number number) {
    to_ = std::to_chars(to_, first_ + kLongestLine, number).ptr;
    *to_++ = ' ';
  }
  /// With a point or an exponent, so that nobody takes it for a byte.
  void put_fraction(float number) {
    const char* const begin = to_;
    to_ = std::to_chars(to_, first_ + kLongestLine, number).ptr;
    if (std::find_if(begin, const_cast<const char*>(to_),
                     [](char c) { return c == '.' || c == 'e'; }) == to_) {
      *to_++ = '.';
      *to_++ = '0';
    }
    *to_++ = ' ';
  }
  /// @return  bytes of the line
  std::size_t end() {
    to_[-1] = '\n';
    return static_cast<std::size_t>(to_ - first_);
  }

 private:
  char* first_;
  char* to_;
};

/// Behind a position stand the normal, the colour and the texture coordinates, as the keyword
/// announces; behind the corners of a face its colour.
class OffWriter final : public CountedWriter {
 public:
  OffWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces,
            std::vector<AttributeSpec> specs)
      : CountedWriter(path, vertices, faces, std::move(specs)),
        normal_(find_field(attributes(), AttributePer::vertex, AttributeKind::normal, 3, 3)),
        colour_(find_field(attributes(), AttributePer::vertex, AttributeKind::colour, 3, 4)),
        texture_(find_field(attributes(), AttributePer::vertex, AttributeKind::uv, 2, 2)),
        face_colour_(find_field(attributes(), AttributePer::face, AttributeKind::colour, 3, 4)) {
    const std::string header = fmt::format("{}{}{}OFF\n{} {} 0\n", texture_ ? "ST" : "",
                                           colour_ ? "C" : "", normal_ ? "N" : "", vertices, faces);
    sink().write(header.data(), header.size());
  }

 private:
  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& p : positions) put_vertex(p, {});
  }
  void put_vertices(std::span<const Vec3> positions, std::span<const std::byte> rows) override {
    const std::size_t width = rows.size() / positions.size();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      put_vertex(positions[i], rows.subspan(i * width, width));
    }
  }

  void put_vertex(const Vec3& position, std::span<const std::byte> row) {
    const Vec3f p = to_float(position);
    OffLine line(sink().room(kLongestLine));
    for (const float number : {p.x, p.y, p.z}) line.put(number);
    if (!row.empty()) {
      if (normal_) put_floats(line, *normal_, row);
      // Where texture coordinates follow, what is behind positions does not tell its type.
      if (colour_) put_colour(line, *colour_, row, is_bytes(*colour_) && !texture_);
      if (texture_) put_floats(line, *texture_, row);
    }
    sink().advance(line.end());
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) put_face(t, {});
  }
  void put_faces(std::span<const Triangle> triangles, std::span<const std::byte> face_rows,
                 std::span<const std::byte>) override {
    const std::size_t width = face_rows.size() / triangles.size();
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      put_face(triangles[i], face_rows.subspan(i * width, width));
    }
  }

  void put_face(const Triangle& t, std::span<const std::byte> row) {
    OffLine line(sink().room(kLongestLine));
    line.put(3);
    for (const VertexId v : t) line.put(v);
    if (face_colour_ && !row.empty()) {
      put_colour(line, *face_colour_, row, is_bytes(*face_colour_));
    }
    sink().advance(line.end());
  }

  static void put_floats(OffLine& line, const AttributeField& field,
                         std::span<const std::byte> row) {
    std::array<float, 4> values{};
    field.read(row, std::span(values).first(field.size()));
    for (std::size_t i = 0; i < field.size(); ++i) line.put(values[i]);
  }
  static void put_colour(OffLine& line, const AttributeField& field, std::span<const std::byte> row,
                         bool bytes) {
    std::array<float, 4> values{};
    if (!bytes) field.read(row, std::span(values).first(field.size()));
    for (std::size_t i = 0; i < field.size(); ++i) {
      if (bytes) {
        line.put(std::to_integer<unsigned>(row[field.at() + i]));
      } else {
        line.put_fraction(values[i]);
      }
    }
  }

  std::optional<AttributeField> normal_, colour_, texture_;  // of vertices
  std::optional<AttributeField> face_colour_;
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_off_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   std::vector<AttributeSpec> attributes) {
  return std::make_unique<OffWriter>(path, vertices, faces, std::move(attributes));
}

}  // namespace remaps
