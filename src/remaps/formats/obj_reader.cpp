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
#include "remaps/formats/pass_range.h"
#include "remaps/formats/position_text.h"
#include "remaps/formats/row_emitter.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {
namespace {

/// The file as logical lines, of which those that begin with 'v', 'vt', 'vn' and 'f' matter.
class ObjLines {
 public:
  explicit ObjLines(ByteSource& source) : scanner_(source) {}

  enum class Kind { vertex, texture, normal, face, other };

  bool at_end() const { return scanner_.at_end(); }
  TextScanner& scanner() { return scanner_; }

  /// Passes over the keyword of the line ahead.
  Kind begin_line() {
    scanner_.skip_blanks();
    const char first = scanner_.peek(0);
    comment_ = first == '#';
    if (first != 'v' && first != 'f') return Kind::other;
    if (ends_keyword(scanner_.peek(1))) {
      scanner_.consume(1);
      return first == 'v' ? Kind::vertex : Kind::face;
    }
    const char second = scanner_.peek(1);
    const bool known = first == 'v' && (second == 't' || second == 'n');
    if (!known || !ends_keyword(scanner_.peek(2))) return Kind::other;
    scanner_.consume(2);
    return second == 't' ? Kind::texture : Kind::normal;
  }

  /// Passes over blanks and over line ends hidden by a backslash; true if the line has more to say.
  bool next_value() {
    do {
      scanner_.skip_blanks();
    } while (scanner_.skip_escaped_line_end());
    return !scanner_.at_line_end() && scanner_.peek(0) != '#';
  }

  /// Passes over the rest of the line. A backslash at the end of a comment (a Windows path, say)
  /// hides nothing.
  void end_line() {
    while (scanner_.skip_line() == '\\' && !comment_ && !scanner_.at_end()) {
    }
  }

 private:
  static bool ends_keyword(char c) { return is_blank(c) || c == '\n' || c == '\\'; }

  TextScanner scanner_;
  bool comment_ = false;
};

/// The numbers of a corner, v, v/t, v//n or v/t/n: 0 for what is not there.
struct ObjCorner {
  std::int64_t vertex = 0;
  std::array<std::int64_t, 2> pool{};  // texture, normal
};

ObjCorner read_corner(TextScanner& scanner) {
  ObjCorner corner;
  corner.vertex = scanner.integer('/');
  for (std::int64_t& number : corner.pool) {
    if (scanner.peek(0) != '/') break;
    scanner.consume(1);
    const char next = scanner.peek(0);
    if (next != '/' && next != '\\' && !is_blank(next) && next != '\n')
      number = scanner.integer('/');
  }
  return corner;
}

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
    std::uint64_t vertices = 0, values = 0;
    for (; !lines.at_end(); lines.end_line()) {
      const ObjLines::Kind kind = lines.begin_line();
      vertices += kind == ObjLines::Kind::vertex;
      values += kind == (normal ? ObjLines::Kind::normal : ObjLines::Kind::texture);
      if (kind != ObjLines::Kind::face) continue;
      // A fan, as read_face makes it.
      std::array<PoolUse, 3> fan;
      for (std::size_t corners = 0; lines.next_value(); ++corners) {
        const ObjCorner corner = read_corner(lines.scanner());
        const std::int64_t index = corner.pool[normal ? 1 : 0];
        fan[std::min<std::size_t>(corners, 2)] = {
            numbered(lines.scanner(), corner.vertex, *vertices_, vertices, "a vertex"),
            index == 0 ? PoolUse::kNone
                       : numbered(lines.scanner(), index, pool.values, values,
                                  normal ? "a normal" : "a texture coordinate")};
        if (corners < 2) continue;
        uses.insert(uses.end(), fan.begin(), fan.end());
        fan[1] = fan[2];
        if (uses.size() < kUses) continue;
        sink(uses);
        uses.clear();
      }
    }
    if (!uses.empty()) sink(uses);
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
      while (scanner.peek(0) != '\\' && !is_blank(scanner.peek(0)) && !scanner.at_line_end()) {
        scanner.consume(1);
      }
    }
    if (polygon.corners() < 3) {
      scanner.fail(
          fmt::format("expected a face of at least 3 corners, found {}", polygon.corners()));
    }
    polygon.end();
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
