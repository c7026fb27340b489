#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/formats/chunk_emitter.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/gltf_scene.h"
#include "remaps/formats/position_value.h"

namespace remaps {
namespace {

/// Turns three components into numbers. Normalized integers of n bits mean -1 to 1 or 0 to 1.
template <class T>
Vec3 load_point(const char* from, bool normalized) {
  T c[3];
  std::memcpy(c, from, sizeof c);
  Vec3 p{double(c[0]), double(c[1]), double(c[2])};
  if constexpr (std::is_integral_v<T>) {
    if (normalized) {
      const double most = std::numeric_limits<T>::max();
      p = {std::max(p.x / most, -1.0), std::max(p.y / most, -1.0), std::max(p.z / most, -1.0)};
    }
  }
  return p;
}

Vec3 load_point(const char* from, GltfComponent component, bool normalized) {
  switch (component) {
    case GltfComponent::i8:
      return load_point<std::int8_t>(from, normalized);
    case GltfComponent::u8:
      return load_point<std::uint8_t>(from, normalized);
    case GltfComponent::i16:
      return load_point<std::int16_t>(from, normalized);
    case GltfComponent::u16:
      return load_point<std::uint16_t>(from, normalized);
    default:
      return load_point<float>(from, false);
  }
}

/// Puts the corners of a primitive together to triangles.
class TriangleMaker {
 public:
  /// @param mirrored  the node's transform turns surfaces inside out: turn them back
  TriangleMaker(GltfMode mode, bool mirrored, ChunkEmitter<Triangle>& to)
      : mode_(mode), mirrored_(mirrored), to_(to) {}

  void corner(VertexId v) {
    if (held_ < 2) {
      last_[held_++] = v;
      return;
    }
    switch (mode_) {
      case GltfMode::triangles:
        send(last_[0], last_[1], v);
        held_ = 0;
        return;
      case GltfMode::strip:
        send_if_proper(last_[odd_ ? 1 : 0], last_[odd_ ? 0 : 1], v);
        odd_ = !odd_;
        last_ = {last_[1], v};
        return;
      case GltfMode::fan:
        send_if_proper(last_[0], last_[1], v);
        last_[1] = v;
        return;
    }
  }

 private:
  void send(VertexId a, VertexId b, VertexId c) {
    if (mirrored_) std::swap(b, c);
    to_.push({a, b, c});
  }
  /// Strips repeat corners to turn.
  void send_if_proper(VertexId a, VertexId b, VertexId c) {
    if (a != b && b != c && c != a) send(a, b, c);
  }

  GltfMode mode_;
  bool mirrored_;
  ChunkEmitter<Triangle>& to_;
  std::array<VertexId, 2> last_{};
  std::size_t held_ = 0;
  bool odd_ = false;
};

class GltfReader final : public IndexedMeshReader {
 public:
  explicit GltfReader(std::filesystem::path path)
      : path_(std::move(path)), scene_(read_gltf_scene(path_)) {}

  void read_positions(PositionSink sink) override {
    begin_pass(scene_.vertices);
    ChunkEmitter<Vec3> positions(sink);
    for (const GltfScene::Part& part : scene_.parts) read_part(part, positions);
    positions.flush();
  }

  void read_triangles(IndexSink sink) override {
    begin_pass(scene_.corners);
    ChunkEmitter<Triangle> triangles(sink);
    for (const GltfScene::Draw& draw : scene_.draws) read_draw(draw, triangles);
    triangles.flush();
  }

  bool positions_are_float() const override {
    return std::all_of(scene_.parts.begin(), scene_.parts.end(), [this](const auto& part) {
      return scene_.transforms[part.transform].is_identity() &&
             !scene_.accessors[part.accessor].normalized;
    });
  }

  VertexSharing vertex_sharing() const override { return VertexSharing::split; }

  std::optional<PositionArray> position_array() const override {
    if (scene_.parts.size() != 1 || !positions_are_float()) return std::nullopt;
    const GltfAccessor& accessor = scene_.accessors[scene_.parts[0].accessor];
    const GltfBuffer& buffer = scene_.buffers[accessor.base.buffer];
    if (accessor.component != GltfComponent::f32 || accessor.base.stride != sizeof(Vec3f) ||
        accessor.sparse || !buffer.plain_begin()) {
      return std::nullopt;
    }
    return PositionArray{buffer.source().path(), *buffer.plain_begin() + accessor.base.begin};
  }

  double pass_fraction() const override {
    return pass_elements_ == 0 ? 1 : double(done_elements_) / double(pass_elements_);
  }
  std::uint64_t bytes_total() const override {
    std::uint64_t bytes = 0;
    for (const auto& source : scene_.sources) bytes += source->size();
    return bytes;
  }
  std::uint64_t bytes_read() const override {
    return static_cast<std::uint64_t>(pass_fraction() * double(bytes_total()));
  }
  std::uint64_t bytes_read_total() const override {
    std::uint64_t bytes = 0;
    for (const auto& source : scene_.sources) bytes += source->bytes_read_total();
    return bytes;
  }

 private:
  void begin_pass(std::uint64_t elements) {
    pass_elements_ = elements;
    done_elements_ = 0;
  }

  /// Calls visit(bytes of the element, its number) for all elements of an accessor.
  template <class Visit>
  void for_each_element(const GltfAccessor& accessor, Visit visit) {
    const std::size_t bytes = accessor.element_bytes();
    GltfElements elements(scene_.buffers, accessor, path_);
    for (;;) {
      const std::uint64_t first = elements.position();
      const std::span<const char> chunk = elements.next();
      if (chunk.empty()) return;
      const std::size_t n = chunk.size() / bytes;
      for (std::size_t i = 0; i < n; ++i) visit(chunk.data() + i * bytes, first + i);
      done_elements_ += n;
    }
  }

  void read_part(const GltfScene::Part& part, ChunkEmitter<Vec3>& positions) {
    const GltfAccessor& accessor = scene_.accessors[part.accessor];
    const Affine& transform = scene_.transforms[part.transform];
    const bool stays = transform.is_identity();
    for_each_element(accessor, [&](const char* at, std::uint64_t) {
      Vec3 p = load_point(at, accessor.component, accessor.normalized);
      if (!stays) p = transform.point(p);
      positions.push(has_position(p) ? p : kNotFinite);
    });
  }

  void read_draw(const GltfScene::Draw& draw, ChunkEmitter<Triangle>& triangles) {
    const GltfPrimitive& primitive = scene_.primitives[draw.primitive];
    const std::uint64_t vertices = scene_.accessors[primitive.positions].count;
    TriangleMaker maker(primitive.mode, scene_.transforms[draw.transform].mirrors(), triangles);
    if (!primitive.indices) {
      for (VertexId v = 0; v < vertices; ++v) maker.corner(draw.first + v);
      done_elements_ += vertices;
      return;
    }
    const GltfAccessor& accessor = scene_.accessors[*primitive.indices];
    for_each_element(accessor, [&](const char* at, std::uint64_t number) {
      const std::uint64_t v = load_index(at, accessor.component);
      if (v >= vertices) {
        fail(fmt::format("{}.indices: {}", primitive.place, accessor.place), number,
             fmt::format("expected a vertex index below {}, found {}", vertices, v));
      }
      maker.corner(draw.first + v);
    });
  }

  [[noreturn]] void fail(const std::string& place, std::uint64_t element,
                         std::string_view what) const {
    throw InputError(fmt::format("{}: {}, element {}: {}", path_.string(), place, element, what));
  }

  std::filesystem::path path_;
  GltfScene scene_;
  std::uint64_t pass_elements_ = 0, done_elements_ = 0;
};

}  // namespace

std::unique_ptr<IndexedMeshReader> make_gltf_reader(ByteSource source) {
  return std::make_unique<GltfReader>(source.path());
}

}  // namespace remaps
