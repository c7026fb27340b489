#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

/// Room for a line: a keyword, twelve numbers of at most 20 characters with a separator each.
constexpr std::size_t kLongestLine = 320;

/// Where an attribute is in a row, and what its values are to be multiplied with.
class ObjValues {
 public:
  ObjValues(const AttributeSpec& spec, std::size_t at) : at_(at) {
    for (const AttributeComponent& c : spec.components) type_.push_back(c.type);
    if (spec.kind == AttributeKind::colour) scale_ = 1 / largest(type_[0]);
  }

  /// Reads the first values of the attribute.
  template <std::size_t kCount>
  std::array<float, kCount> read(std::span<const std::byte> row) const {
    std::array<float, kCount> values{};
    std::size_t at = at_;
    for (std::size_t i = 0; i < kCount; ++i) {
      const double value = scale_ * load_scalar(type_[i], row.data() + at);
      values[i] = std::isfinite(value) ? static_cast<float>(value) : 0.0F;
      at += size_of(type_[i]);
    }
    return values;
  }

 private:
  /// What full colour is: 255 of a byte, 1 of a float.
  static double largest(ScalarType type) {
    switch (type) {
      case ScalarType::uint8:
        return std::numeric_limits<std::uint8_t>::max();
      case ScalarType::uint16:
        return std::numeric_limits<std::uint16_t>::max();
      case ScalarType::uint32:
        return std::numeric_limits<std::uint32_t>::max();
      default:
        return 1;
    }
  }

  std::size_t at_;
  std::vector<ScalarType> type_;
  double scale_ = 1;
};

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
  std::optional<ObjValues> find(AttributeKind kind, AttributePer per, std::size_t least) const {
    std::size_t at = 0;
    for (const AttributeSpec& spec : attributes()) {
      if (spec.per != per) continue;
      if (spec.kind == kind && spec.components.size() >= least) return ObjValues(spec, at);
      at += row_bytes(spec);
    }
    return std::nullopt;
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
        const auto c = colour_->read<3>(row);
        put_line("v", std::array{p.x, p.y, p.z, c[0], c[1], c[2]});
      } else {
        put_line("v", std::array{p.x, p.y, p.z});
      }
      if (normal_) put_line("vn", normal_->read<3>(row));
      if (texture_) put_line("vt", texture_->read<2>(row));
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
        if (corner_normal_) put_line("vn", corner_normal_->read<3>(row));
        if (corner_texture_) put_line("vt", corner_texture_->read<2>(row));
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

  std::optional<ObjValues> colour_, normal_, texture_;  // of vertices
  std::optional<ObjValues> corner_normal_, corner_texture_;
  std::uint64_t corners_ = 0;  // written
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_obj_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   std::vector<AttributeSpec> attributes) {
  return std::make_unique<ObjWriter>(path, vertices, faces, std::move(attributes));
}

}  // namespace remaps
