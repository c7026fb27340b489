#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/formats/chunk_emitter.h"
#include "remaps/formats/corner_runs.h"
#include "remaps/formats/format_detection.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/obj_lines.h"
#include "remaps/formats/pass_range.h"
#include "remaps/formats/position_text.h"
#include "remaps/formats/row_emitter.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {
namespace {

/// Turns the corners of a polygon, with what they use, into triangles as PolygonRun does.
class PolygonUses {
 public:
  PolygonUses(std::vector<PoolUse>& to, PolygonCutter* cutter)
      : to_(to), most_(cutter == nullptr ? 2 : PolygonCutter::kMostCorners), cutter_(cutter) {}

  void begin() {
    kept_.clear();
    corners_ = 0;
  }
  void corner(const PoolUse& use) {
    ++corners_;
    if (corners_ <= most_) {
      kept_.push_back(use);
      return;
    }
    // Too many to be cut: a fan after all, which needs the first and the last.
    fan_kept();
    to_.insert(to_.end(), {kept_[0], kept_[1], use});
    kept_[1] = use;
  }
  void end() {
    if (corners_ > most_ || kept_.size() < 3) return;
    if (kept_.size() == 3) {
      to_.insert(to_.end(), kept_.begin(), kept_.end());
      return;
    }
    vertices_.clear();
    for (const PoolUse& use : kept_) vertices_.push_back(use.vertex);
    for (const PolygonCorners& t : cutter_->cut(vertices_)) {
      for (const std::uint32_t i : t) to_.push_back(kept_[i]);
    }
  }

 private:
  void fan_kept() {
    for (std::size_t i = 2; i < kept_.size(); ++i) {
      to_.insert(to_.end(), {kept_[0], kept_[i - 1], kept_[i]});
    }
    if (kept_.size() > 2) kept_ = {kept_.front(), kept_.back()};
  }

  std::vector<PoolUse>& to_;
  std::uint64_t most_;
  PolygonCutter* cutter_;
  std::vector<PoolUse> kept_;
  std::uint64_t corners_ = 0;
  std::vector<VertexId> vertices_;
};

class ObjReader final : public IndexedMeshReader {
 public:
  explicit ObjReader(ByteSource source) : source_(std::move(source)) {}

  void read_positions(PositionSink sink) override {
    ChunkEmitter<Vec3> positions(sink);
    PositionText text;
    visit_vertices([&](ObjLines& lines) {
      positions.push(text.read(lines.scanner(), [&] { return lines.next_value(); }));
    });
    positions.flush();
    all_float_ = text.all_float();
  }

  void read_triangles(IndexSink sink) override {
    if (!vertices_) visit_vertices([](ObjLines&) {});
    ObjLines lines = go_to(first_face_);
    begin_pass();
    ChunkEmitter<Triangle> triangles(sink);
    PolygonRun polygon(triangles, cutter_);
    std::uint64_t seen = first_face_.seen;
    for (; !lines.at_end(); lines.end_line()) {
      const ObjLines::Kind kind = lines.begin_line();
      if (kind == ObjLines::Kind::vertex) ++seen;
      if (kind == ObjLines::Kind::face) read_face(lines, polygon, seen);
    }
    triangles.flush();
  }

  std::vector<AttributeSpec> attributes() override {
    if (!vertices_) visit_vertices([](ObjLines&) {});
    std::vector<AttributeSpec> specs;
    colours_ = count_colours();
    if (colours_ > 0) {
      AttributeSpec colour{"colour", AttributeKind::colour, AttributePer::vertex, {}, false};
      for (std::size_t i = 0; i < colours_; ++i) {
        constexpr std::array<const char*, 4> kNames = {"red", "green", "blue", "alpha"};
        colour.components.push_back({kNames[i], ScalarType::float32});
      }
      specs.push_back(colour);
    }
    const ObjCorner corner = first_corner();
    pools_.clear();
    // Some programs write indices of values that are not in the file.
    if (corner.pool[1] != 0 && has_normals_) {
      specs.push_back(
          {"normal",
           AttributeKind::normal,
           AttributePer::vertex,
           {{"nx", ScalarType::float32}, {"ny", ScalarType::float32}, {"nz", ScalarType::float32}},
           true});
    }
    if (corner.pool[0] != 0 && has_textures_) {
      specs.push_back({"uv",
                       AttributeKind::uv,
                       AttributePer::corner,
                       {{"u", ScalarType::float32}, {"v", ScalarType::float32}},
                       true});
    }
    for (const AttributeSpec& spec : specs) pools_.push_back({spec.kind});
    return specs;
  }

  void read_attributes(AttributePer per, AttributeSink sink) override {
    if (per != AttributePer::vertex || colours_ == 0) return;
    RowEmitter rows(colours_, sink);
    std::array<double, 4> colour{};
    visit_vertices([&](ObjLines& lines) {
      colour.fill(0);
      std::size_t number = 0;
      while (number < 3 + colours_ && lines.next_value()) {
        if (number < 3) {
          lines.scanner().coordinate();
        } else {
          colour[number - 3] = lines.scanner().real();
        }
        ++number;
      }
      rows.push(std::span(colour).first(colours_));
    });
    rows.flush();
  }

  void read_pool(std::size_t number, AttributeSink sink) override {
    Pool& pool = pools_.at(number);
    const bool normal = pool.kind == AttributeKind::normal;
    const auto wanted = normal ? ObjLines::Kind::normal : ObjLines::Kind::texture;
    RowEmitter rows(normal ? 3 : 2, sink);
    ObjLines lines = go_to({});
    begin_pass();
    pool.values = 0;
    std::array<double, 3> value{};
    for (; !lines.at_end(); lines.end_line()) {
      if (lines.begin_line() != wanted) continue;
      value.fill(0);
      std::size_t have = 0;
      while (have < (normal ? 3U : 2U) && lines.next_value())
        value[have++] = lines.scanner().real();
      if (have < (normal ? 3U : 1U)) {
        lines.scanner().fail(normal ? "expected three numbers of a normal, found fewer"
                                    : "expected texture coordinates, found none");
      }
      rows.push(std::span(value).first(normal ? 3 : 2));
      ++pool.values;
    }
    rows.flush();
  }

  void read_pool_uses(std::size_t number, PoolUseSink sink) override {
    const Pool pool = pools_.at(number);
    const bool normal = pool.kind == AttributeKind::normal;
    ObjLines lines = go_to({});
    begin_pass();
    std::vector<PoolUse> uses;
    PolygonUses triangles(uses, cutter_);
    std::uint64_t vertices = 0, values = 0;
    for (; !lines.at_end(); lines.end_line()) {
      const ObjLines::Kind kind = lines.begin_line();
      vertices += kind == ObjLines::Kind::vertex;
      values += kind == (normal ? ObjLines::Kind::normal : ObjLines::Kind::texture);
      if (kind != ObjLines::Kind::face) continue;
      triangles.begin();
      while (lines.next_value()) {
        const ObjCorner corner = read_corner(lines.scanner());
        const std::int64_t index = corner.pool[normal ? 1 : 0];
        triangles.corner(
            {numbered(lines.scanner(), corner.vertex, *vertices_, vertices, "a vertex"),
             index == 0 ? PoolUse::kNone
                        : numbered(lines.scanner(), index, pool.values, values,
                                   normal ? "a normal" : "a texture coordinate")});
      }
      triangles.end();
      if (uses.size() < kUses) continue;
      sink(uses);
      uses.clear();
    }
    if (!uses.empty()) sink(uses);
  }

  std::vector<std::string> face_labels() override {
    ObjLines lines = go_to({});
    begin_pass();
    ObjLabels labels;
    for (; !lines.at_end(); lines.end_line()) {
      if (lines.begin_line() == ObjLines::Kind::other) labels.read(lines);
    }
    return labels.seen();
  }

  void read_face_labels(std::span<const std::string> names, FaceLabelSink sink) override {
    ObjLines lines = go_to({});
    begin_pass();
    ObjLabels labels;
    ChunkEmitter<FaceLabel> emitter(sink);
    for (; !lines.at_end(); lines.end_line()) {
      const ObjLines::Kind kind = lines.begin_line();
      if (kind == ObjLines::Kind::other) labels.read(lines);
      if (kind != ObjLines::Kind::face) continue;
      const FaceLabel label = labels.of(names);
      // As many triangles as read_face makes.
      std::size_t corners = 0;
      for (; lines.next_value(); ++corners) {
        lines.scanner().integer('/');
        skip_rest_of_corner(lines.scanner());
      }
      for (; corners > 2; --corners) emitter.push(label);
    }
    emitter.flush();
  }

  void set_polygon_cutter(PolygonCutter* cutter) override { cutter_ = cutter; }
  bool positions_are_float() const override { return all_float_; }
  double pass_fraction() const override { return pass_.fraction(source_.file_offset()); }
  std::uint64_t bytes_total() const override { return source_.file_size(); }
  std::uint64_t bytes_read() const override { return source_.file_offset(); }
  std::uint64_t bytes_read_total() const override { return source_.bytes_read_total(); }

 private:
  /// A place in the file, and the vertices before it.
  struct Place {
    std::uint64_t offset = 0;
    std::uint64_t seen = 0;
  };

  /// A pass from here to the end of the file.
  void begin_pass() { pass_ = {source_.file_offset(), source_.file_size()}; }

  ObjLines go_to(const Place& place) {
    source_.seek(place.offset);
    if (place.offset == 0) skip_byte_order_mark(source_);
    return ObjLines(source_);
  }

  /// Goes through the file, calls visit(lines) behind the keyword of each vertex, counts them and
  /// notes where the faces begin.
  template <class Visit>
  void visit_vertices(Visit visit) {
    ObjLines lines = go_to({});
    begin_pass();
    std::optional<Place> first_face;
    std::uint64_t count = 0;
    for (; !lines.at_end(); lines.end_line()) {
      const std::uint64_t line = source_.offset();
      const ObjLines::Kind kind = lines.begin_line();
      if (kind == ObjLines::Kind::face && !first_face) first_face = {line, count};
      has_normals_ = has_normals_ || kind == ObjLines::Kind::normal;
      has_textures_ = has_textures_ || kind == ObjLines::Kind::texture;
      if (kind != ObjLines::Kind::vertex) continue;
      visit(lines);
      ++count;
    }
    set_vertices(count);
    first_face_ = first_face.value_or(Place{source_.size(), count});
  }

  void set_vertices(std::uint64_t count) {
    if (count == 0) {
      source_.fail_at_byte(source_.size(),
                           "expected an OBJ mesh, found no vertex ('v') up to the end of the file");
    }
    vertices_ = count;
  }

  /// @param seen  vertices before this line: what negative indices count back from
  void read_face(ObjLines& lines, PolygonRun& polygon, std::uint64_t seen) const {
    TextScanner& scanner = lines.scanner();
    polygon.begin();
    while (lines.next_value()) {
      const std::int64_t index = scanner.integer('/');
      polygon.corner(vertex_id(scanner, index, seen));
      skip_rest_of_corner(scanner);
    }
    if (polygon.corners() < 3) {
      scanner.fail(
          fmt::format("expected a face of at least 3 corners, found {}", polygon.corners()));
    }
    polygon.end();
  }

  static void skip_rest_of_corner(TextScanner& scanner) {
    while (scanner.peek(0) != '\\' && !is_blank(scanner.peek(0)) && !scanner.at_line_end()) {
      scanner.consume(1);
    }
  }

  VertexId vertex_id(const TextScanner& scanner, std::int64_t index, std::uint64_t seen) const {
    return numbered(scanner, index, *vertices_, seen, "a vertex");
  }

  static std::uint64_t numbered(const TextScanner& scanner, std::int64_t index, std::uint64_t count,
                                std::uint64_t seen, std::string_view what) {
    const auto magnitude =
        index < 0 ? 0 - static_cast<std::uint64_t>(index) : static_cast<std::uint64_t>(index);
    if (index > 0 && magnitude <= count) return magnitude - 1;
    if (index < 0 && magnitude <= seen) return seen - magnitude;
    scanner.fail(fmt::format("expected {} index from 1 to {} or from -{} to -1, found {}", what,
                             count, seen, index));
  }

  /// Numbers behind the position of the first vertex, if they are a colour.
  std::size_t count_colours() {
    ObjLines lines = go_to({});
    for (; !lines.at_end(); lines.end_line()) {
      if (lines.begin_line() != ObjLines::Kind::vertex) continue;
      std::size_t numbers = 0;
      while (numbers < 8 && lines.next_value()) {
        // What does not look like a number is not a colour, and is passed over as it always was.
        const std::string_view word = lines.scanner().word();
        double value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size()) return 0;
        ++numbers;
      }
      return numbers == 6 || numbers == 7 ? numbers - 3 : 0;
    }
    return 0;
  }

  /// Of the first face, which speaks for all.
  ObjCorner first_corner() {
    ObjLines lines = go_to(first_face_);
    if (lines.at_end() || lines.begin_line() != ObjLines::Kind::face || !lines.next_value())
      return {};
    return read_corner(lines.scanner());
  }

  struct Pool {
    AttributeKind kind;
    std::uint64_t values = 0;  // once read
  };
  static constexpr std::size_t kUses = 3 * 2048;

  ByteSource source_;
  std::optional<std::uint64_t> vertices_;
  Place first_face_;  // once vertices_ is known
  bool all_float_ = false;
  std::size_t colours_ = 0;                          // numbers of a vertex's colour
  bool has_normals_ = false, has_textures_ = false;  // once read
  std::vector<Pool> pools_;                          // (attributes)
  PolygonCutter* cutter_ = nullptr;
  PassRange pass_;
};

}  // namespace

std::unique_ptr<IndexedMeshReader> make_obj_reader(ByteSource source) {
  return std::make_unique<ObjReader>(std::move(source));
}

}  // namespace remaps
