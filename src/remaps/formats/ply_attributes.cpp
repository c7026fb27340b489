#include "remaps/formats/ply_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "remaps/formats/chunk_emitter.h"
#include "remaps/formats/corner_runs.h"
#include "remaps/formats/ply_cursor.h"
#include "remaps/formats/row_emitter.h"

namespace remaps {
namespace {

constexpr std::string_view kTextureList = "texcoord";
/// Of an element; more are passed over. Nobody has so many, but a header may.
constexpr std::size_t kMostAttributes = 256;

/// Properties that belong together, by name; the last ones may be missing.
struct KnownNames {
  std::string_view attribute;
  AttributeKind kind;
  std::size_t needed;
  std::array<std::string_view, 4> names;
};
constexpr KnownNames kKnown[] = {
    {"colour", AttributeKind::colour, 3, {"red", "green", "blue", "alpha"}},
    {"colour",
     AttributeKind::colour,
     3,
     {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"}},
    {"normal", AttributeKind::normal, 3, {"nx", "ny", "nz", ""}},
    {"normal", AttributeKind::normal, 3, {"normal_x", "normal_y", "normal_z", ""}},
    {"uv", AttributeKind::uv, 2, {"s", "t", "", ""}},
    {"uv", AttributeKind::uv, 2, {"u", "v", "", ""}},
    {"uv", AttributeKind::uv, 2, {"texture_u", "texture_v", "", ""}},
    {"uv", AttributeKind::uv, 2, {"texture_s", "texture_t", "", ""}},
};
/// Integers with these names are measured, not labels.
constexpr std::string_view kMeasured[] = {"intensity", "confidence", "quality", "alpha"};

ScalarType scalar_type(PlyType type) {
  return static_cast<ScalarType>(type);
}

const PlyProperty* find_scalar(const PlyElement& element, std::string_view name) {
  const PlyProperty* const property = name.empty() ? nullptr : element.find(name);
  return property != nullptr && !property->count_type ? property : nullptr;
}

bool is_corner_element(const PlyElement& element) {
  return element.name == "face" || element.name == "tristrips";
}

/// Finds the attributes of one element, in the order of their first properties.
class ElementAttributes {
 public:
  ElementAttributes(const PlyElement& element, AttributePer per) : element_(element), per_(per) {
    taken_.resize(element.properties.size());
    for (const std::string_view axis : {"x", "y", "z"}) {
      if (per == AttributePer::vertex) take(find_scalar(element, axis));
    }
  }

  std::vector<AttributeSpec> find() {
    std::vector<AttributeSpec> specs;
    for (const PlyProperty& property : element_.properties) {
      if (specs.size() == kMostAttributes) break;
      if (property.count_type || taken_[index_of(property)]) continue;
      specs.push_back(attribute_from(property));
    }
    return specs;
  }

 private:
  std::size_t index_of(const PlyProperty& property) const {
    return static_cast<std::size_t>(&property - element_.properties.data());
  }
  void take(const PlyProperty* property) {
    if (property != nullptr) taken_[index_of(*property)] = true;
  }

  AttributeSpec attribute_from(const PlyProperty& property) {
    for (const KnownNames& known : kKnown) {
      if (std::find(known.names.begin(), known.names.end(), property.name) == known.names.end())
        continue;
      if (const auto spec = whole(known)) return *spec;
    }
    take(&property);
    const bool measured =
        !is_integer(property.type) ||
        std::find(std::begin(kMeasured), std::end(kMeasured), property.name) != std::end(kMeasured);
    return {property.name,
            measured ? AttributeKind::scalar : AttributeKind::label,
            per_,
            {{property.name, scalar_type(property.type)}},
            false};
  }

  /// Nothing unless all needed properties are there.
  std::optional<AttributeSpec> whole(const KnownNames& known) {
    AttributeSpec spec{std::string(known.attribute), known.kind, per_, {}, false};
    for (const std::string_view name : known.names) {
      const PlyProperty* const property = find_scalar(element_, name);
      if (property == nullptr || taken_[index_of(*property)]) break;
      spec.components.push_back({property->name, scalar_type(property->type)});
    }
    if (spec.components.size() < known.needed) return std::nullopt;
    for (const AttributeComponent& c : spec.components) take(element_.find(c.name));
    return spec;
  }

  const PlyElement& element_;
  AttributePer per_;
  std::vector<bool> taken_;
};

/// A name is used once: the second one of an element gets the name of its first component, one of
/// another element that of the element before it.
void make_names_unique(std::vector<AttributeSpec>& specs) {
  for (std::size_t i = 0; i < specs.size(); ++i) {
    const auto taken = [&] {
      return std::any_of(specs.begin(), specs.begin() + static_cast<std::ptrdiff_t>(i),
                         [&](const AttributeSpec& s) { return s.name == specs[i].name; });
    };
    if (taken() && specs[i].per == AttributePer::vertex) {
      specs[i].name = specs[i].components[0].name;
    }
    if (taken()) specs[i].name = fmt::format("{}-{}", name_of(specs[i].per), specs[i].name);
    for (int n = 2; taken(); ++n) specs[i].name = fmt::format("{}-{}", specs[i].name, n);
  }
}

/// What to do with the next property of a record.
struct Step {
  enum class Kind { skip, skip_list, value, corners, texture };
  Kind kind;
  PlyType type, count_type;
  std::size_t channel = 0;
};

std::vector<Step> plan_steps(const PlyElement& element, const std::vector<AttributeSpec>& specs,
                             AttributePer per) {
  using Kind = Step::Kind;
  const PlyProperty* const corners = element.find("vertex_indices", "vertex_index");
  std::vector<const PlyProperty*> wanted;  // (channels)
  for (const AttributeSpec& spec : specs) {
    for (const AttributeComponent& c : spec.components) {
      if (per != AttributePer::corner) wanted.push_back(element.find(c.name));
    }
  }
  std::vector<Step> steps;
  for (const PlyProperty& property : element.properties) {
    if (property.count_type) {
      const bool texture = per == AttributePer::corner && property.name == kTextureList;
      const bool is_corners = per != AttributePer::vertex && &property == corners;
      steps.push_back({texture      ? Kind::texture
                       : is_corners ? Kind::corners
                                    : Kind::skip_list,
                       property.type, *property.count_type});
      continue;
    }
    Step step{Kind::skip, property.type, property.type};
    const auto at = std::find(wanted.begin(), wanted.end(), &property);
    if (at != wanted.end()) {
      step.kind = Kind::value;
      step.channel = static_cast<std::size_t>(at - wanted.begin());
    }
    steps.push_back(step);
  }
  return steps;
}

/// Reads records one by one: what they have of the values of a row, and how many corners.
template <class Cursor>
class RecordReader {
 public:
  /// @param kept_corners  lists of so many corners or fewer are kept
  RecordReader(Cursor& cursor, const std::vector<Step>& steps, std::size_t channels,
               std::uint64_t vertices, std::size_t kept_corners)
      : cursor_(cursor),
        steps_(steps),
        values_(channels),
        vertices_(vertices),
        kept_corners_(kept_corners) {}

  void read() {
    corners_ = 0;
    polygon_.clear();
    texture_.clear();
    for (const Step& step : steps_) {
      switch (step.kind) {
        case Step::Kind::skip:
          cursor_.skip(Cursor::size_in_file(step.type));
          break;
        case Step::Kind::value:
          values_[step.channel] = cursor_.real(step.type);
          break;
        case Step::Kind::texture:
          read_texture(step);
          break;
        case Step::Kind::corners:
          read_corners(step);
          break;
        default:
          skip_list(step);
          break;
      }
    }
  }

  std::span<const double> values() const { return values_; }
  std::uint64_t corners() const { return corners_; }
  /// The vertices of a polygon of more than three corners, if it was kept.
  std::span<const VertexId> polygon() const { return polygon_; }
  /// Of a corner of the polygon; zero if the list is too short.
  std::array<double, 2> texture(std::uint64_t corner) const {
    if (2 * corner + 1 >= texture_.size()) return {0, 0};
    return {texture_[static_cast<std::size_t>(2 * corner)],
            texture_[static_cast<std::size_t>(2 * corner + 1)]};
  }

 private:
  void skip_list(const Step& step) {
    const std::uint64_t n = cursor_.integer(step.count_type);
    cursor_.expect_list(n, step.type);
    cursor_.skip(n * Cursor::size_in_file(step.type));
  }
  void read_corners(const Step& step) {
    corners_ = cursor_.integer(step.count_type);
    cursor_.expect_list(corners_, step.type);
    if (corners_ <= 3 || corners_ > kept_corners_) {
      cursor_.skip(corners_ * Cursor::size_in_file(step.type));
      return;
    }
    for (std::uint64_t i = 0; i < corners_; ++i) {
      polygon_.push_back(cursor_.integer(step.type));
      if (polygon_.back() >= vertices_) {
        cursor_.fail(step.type, fmt::format("expected a vertex index below {}", vertices_));
      }
    }
  }
  void read_texture(const Step& step) {
    const std::uint64_t n = cursor_.integer(step.count_type);
    cursor_.expect_list(n, step.type);
    if (n > kMostValues) {
      cursor_.fail(step.count_type,
                   fmt::format("expected at most {} texture coordinates of a face, found {}",
                               kMostValues, n));
    }
    for (std::uint64_t i = 0; i < n; ++i) texture_.push_back(cursor_.real(step.type));
  }

  static constexpr std::uint64_t kMostValues = 1 << 16;

  Cursor& cursor_;
  const std::vector<Step>& steps_;
  std::vector<double> values_;
  std::uint64_t vertices_;
  std::size_t kept_corners_;
  std::uint64_t corners_ = 0;
  std::vector<VertexId> polygon_;
  std::vector<double> texture_;
};

/// Calls f with the corners of each triangle of a polygon, as places in the polygon: the triangles
/// that read_triangles makes of it, if it was kept where there is a cutter.
template <class F>
void for_each_triangle(std::uint64_t corners, std::span<const VertexId> polygon,
                       PolygonCutter* cutter, F f) {
  if (polygon.empty()) {
    for (std::uint64_t last = 2; last < corners; ++last) f(Triangle{0, last - 1, last});
    return;
  }
  for (const PolygonCorners& t : cutter->cut(polygon)) f(Triangle{t[0], t[1], t[2]});
}

}  // namespace

std::vector<AttributeSpec> find_ply_attributes(const PlyHeader& header) {
  std::vector<AttributeSpec> specs;
  const PlyElement* const vertex = header.find("vertex");
  if (vertex != nullptr) specs = ElementAttributes(*vertex, AttributePer::vertex).find();
  const PlyElement* const face = header.find("face");
  const bool alone = std::none_of(
      header.elements.begin(), header.elements.end(), [face](const PlyElement& element) {
        return &element != face && is_corner_element(element) && element.count > 0;
      });
  if (face != nullptr && face->count > 0 && alone) {
    for (AttributeSpec& spec : ElementAttributes(*face, AttributePer::face).find()) {
      specs.push_back(std::move(spec));
    }
    const PlyProperty* const texture = face->find(kTextureList);
    if (texture != nullptr && texture->count_type) {
      const ScalarType type = scalar_type(texture->type);
      specs.push_back(
          {"uv", AttributeKind::uv, AttributePer::corner, {{"u", type}, {"v", type}}, false});
    }
  }
  make_names_unique(specs);
  return specs;
}

template <class Cursor>
void read_ply_rows(Cursor& cursor, const PlyElement& element, AttributePer per,
                   const std::vector<AttributeSpec>& specs, const PlyPolygonCuts& cuts,
                   AttributeSink sink) {
  const std::vector<Step> steps = plan_steps(element, specs, per);
  const std::size_t width = channels(specs, per);
  const bool cut = per == AttributePer::corner && cuts.cutter != nullptr;
  RecordReader<Cursor> record(cursor, steps, width, cuts.vertices,
                              cut ? PolygonCutter::kMostCorners : 0);
  RowEmitter rows(width, sink);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    cursor.place = {&element, i};
    record.read();
    if (per == AttributePer::vertex) {
      rows.push(record.values());
      continue;
    }
    for_each_triangle(record.corners(), record.polygon(), cuts.cutter, [&](const Triangle& t) {
      if (per == AttributePer::face) {
        rows.push(record.values());
      } else {
        for (const std::uint64_t corner : t) rows.push(record.texture(corner));
      }
    });
  }
  rows.flush();
}

template void read_ply_rows(PlyBinaryCursor&, const PlyElement&, AttributePer,
                            const std::vector<AttributeSpec>&, const PlyPolygonCuts&,
                            AttributeSink);
template void read_ply_rows(PlyTextCursor&, const PlyElement&, AttributePer,
                            const std::vector<AttributeSpec>&, const PlyPolygonCuts&,
                            AttributeSink);

}  // namespace remaps
