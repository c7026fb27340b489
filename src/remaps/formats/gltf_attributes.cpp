#include "remaps/formats/gltf_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

#include "remaps/formats/row_emitter.h"

namespace remaps {
namespace {

/// Of each accessor, of which there may be ten at a time.
constexpr std::size_t kPieceBytes = std::size_t{1} << 15;

ScalarType scalar_of(GltfComponent component) {
  switch (component) {
    case GltfComponent::i8:
      return ScalarType::int8;
    case GltfComponent::u8:
      return ScalarType::uint8;
    case GltfComponent::i16:
      return ScalarType::int16;
    case GltfComponent::u16:
      return ScalarType::uint16;
    case GltfComponent::u32:
      return ScalarType::uint32;
    default:
      return ScalarType::float32;
  }
}

/// The colours of all primitives together.
std::optional<AttributeSpec> find_colour(const GltfScene& scene) {
  std::optional<ScalarType> type;
  std::size_t components = 3;
  for (const GltfPrimitive& primitive : scene.primitives) {
    if (primitive.attributes.colour == GltfAttributes::kNone) continue;
    const GltfAccessor& accessor = scene.accessors[primitive.attributes.colour];
    const ScalarType found = scalar_of(accessor.component);
    components = std::max(components, accessor.components);
    const bool kept = found == ScalarType::uint8 || found == ScalarType::uint16;
    type = kept && type.value_or(found) == found ? found : ScalarType::float32;
  }
  if (!type) return std::nullopt;
  AttributeSpec spec{"colour", AttributeKind::colour, AttributePer::vertex, {}, false};
  for (const char* name : {"red", "green", "blue", "alpha"}) {
    if (spec.components.size() < components) spec.components.push_back({name, *type});
  }
  return spec;
}

/// The elements of an accessor as numbers, one by one.
class GltfNumbers {
 public:
  /// @param normalized  of integers: whether they mean fractions, whatever the accessor says
  GltfNumbers(const GltfScene& scene, std::uint32_t number, const std::filesystem::path& path,
              bool normalized = false)
      : accessor_(scene.accessors[number]),
        type_(scalar_of(accessor_.component)),
        elements_(scene.buffers, accessor_, path, kPieceBytes),
        full_(normalized || accessor_.normalized ? full_colour(type_) : 1) {}

  /// The next element; what it does not have is 1, as the alpha of a colour.
  std::array<double, 4> next() {
    if (at_ == piece_.size()) {
      piece_ = elements_.next();
      at_ = 0;
    }
    std::array<double, 4> values{1, 1, 1, 1};
    for (std::size_t i = 0; i < accessor_.components; ++i) {
      const auto* from = reinterpret_cast<const std::byte*>(piece_.data() + at_);
      values[i] = std::max(load_scalar(type_, from) / full_, least());
      at_ += size_of(type_);
    }
    return values;
  }

 private:
  /// -128 of a byte means -1, as -127 does.
  double least() const { return full_ > 1 ? -1 : -std::numeric_limits<double>::infinity(); }

  const GltfAccessor& accessor_;
  ScalarType type_;
  GltfElements elements_;
  double full_;
  std::span<const char> piece_;
  std::size_t at_ = 0;
};

/// How a transform turns normals: the transposed inverse of its columns, up to a factor.
class NormalTurn {
 public:
  explicit NormalTurn(const Affine& t) : stays_(t.is_identity()) {
    const double sign = t.mirrors() ? -1 : 1;
    column_ = {sign * cross(t.column[1], t.column[2]), sign * cross(t.column[2], t.column[0]),
               sign * cross(t.column[0], t.column[1])};
  }
  Vec3 operator()(const Vec3& n) const {
    const Vec3 turned = stays_ ? n : n.x * column_[0] + n.y * column_[1] + n.z * column_[2];
    const double length = norm(turned);
    return length > 0 && std::isfinite(length) ? 1 / length * turned : Vec3{};
  }

 private:
  bool stays_;
  std::array<Vec3, 3> column_;
};

/// Makes the rows of one part of a scene after the other.
class RowMaker {
 public:
  RowMaker(const GltfScene& scene, const std::filesystem::path& path)
      : scene_(scene), path_(path), specs_(find_gltf_attributes(scene)) {
    row_.resize(channels(specs_, AttributePer::vertex));
  }

  std::size_t width() const { return row_.size(); }

  void begin(const GltfScene::Part& part) {
    turn_.emplace(scene_.transforms[part.transform]);
    columns_.clear();
    columns_.resize(specs_.size());
    for (std::size_t i = 0; i < specs_.size(); ++i) {
      const std::uint32_t number = accessor_of(scene_.primitives[part.primitive], specs_[i]);
      if (number == GltfAttributes::kNone) continue;
      columns_[i].emplace(scene_, number, path_, specs_[i].kind == AttributeKind::colour);
    }
  }

  std::span<const double> next() {
    std::size_t at = 0;
    for (std::size_t i = 0; i < specs_.size(); ++i) {
      const auto to = std::span(row_).subspan(at, specs_[i].components.size());
      at += to.size();
      if (columns_[i]) {
        put(specs_[i], columns_[i]->next(), to);
      } else {
        const bool colour = specs_[i].kind == AttributeKind::colour;
        std::fill(to.begin(), to.end(), colour ? full_colour(specs_[i].components[0].type) : 0.0);
      }
    }
    return row_;
  }

 private:
  static std::uint32_t accessor_of(const GltfPrimitive& primitive, const AttributeSpec& spec) {
    const GltfAttributes& found = primitive.attributes;
    if (spec.kind == AttributeKind::normal) return found.normal;
    if (spec.kind == AttributeKind::colour) return found.colour;
    return found.texture[spec.name == "uv" ? 0 : static_cast<std::size_t>(spec.name[2] - '0')];
  }

  void put(const AttributeSpec& spec, const std::array<double, 4>& value, std::span<double> to) {
    if (spec.kind == AttributeKind::normal) {
      const Vec3 n = (*turn_)({value[0], value[1], value[2]});
      to[0] = n.x;
      to[1] = n.y;
      to[2] = n.z;
    } else if (spec.kind == AttributeKind::uv) {
      to[0] = value[0];
      to[1] = 1 - value[1];
    } else {
      const double full = full_colour(spec.components[0].type);
      for (std::size_t i = 0; i < to.size(); ++i) to[i] = full * value[i];
    }
  }

  const GltfScene& scene_;
  const std::filesystem::path& path_;
  std::vector<AttributeSpec> specs_;
  std::vector<double> row_;
  std::optional<NormalTurn> turn_;
  std::vector<std::optional<GltfNumbers>> columns_;  // (specs)
};

}  // namespace

std::vector<AttributeSpec> find_gltf_attributes(const GltfScene& scene) {
  std::vector<AttributeSpec> specs;
  const auto any = [&](auto has) {
    return std::any_of(scene.primitives.begin(), scene.primitives.end(),
                       [&](const GltfPrimitive& p) { return has(p.attributes); });
  };
  constexpr ScalarType kFloat = ScalarType::float32;
  if (any([](const GltfAttributes& a) { return a.normal != GltfAttributes::kNone; })) {
    specs.push_back({"normal",
                     AttributeKind::normal,
                     AttributePer::vertex,
                     {{"nx", kFloat}, {"ny", kFloat}, {"nz", kFloat}},
                     false});
  }
  if (auto colour = find_colour(scene)) specs.push_back(std::move(*colour));
  for (std::size_t set = 0; set < GltfAttributes::kTextures; ++set) {
    if (!any([&](const GltfAttributes& a) { return a.texture[set] != GltfAttributes::kNone; })) {
      continue;
    }
    const std::string number = set == 0 ? "" : std::to_string(set);
    specs.push_back({"uv" + number,
                     AttributeKind::uv,
                     AttributePer::vertex,
                     {{"u" + number, kFloat}, {"v" + number, kFloat}},
                     false});
  }
  return specs;
}

void read_gltf_attributes(const GltfScene& scene, const std::filesystem::path& path,
                          AttributeSink sink, FunctionRef<void(std::uint64_t)> done) {
  RowMaker maker(scene, path);
  if (maker.width() == 0) return;
  RowEmitter rows(maker.width(), sink);
  constexpr std::uint64_t kTell = 4096;
  for (const GltfScene::Part& part : scene.parts) {
    maker.begin(part);
    const std::uint64_t count = scene.accessors[part.accessor].count;
    for (std::uint64_t v = 0; v < count; ++v) {
      rows.push(maker.next());
      if ((v + 1) % kTell == 0) done(kTell);
    }
    done(count % kTell);
  }
  rows.flush();
}

}  // namespace remaps
