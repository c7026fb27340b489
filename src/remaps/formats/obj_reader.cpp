#include <fmt/format.h>

#include <optional>
#include <utility>

#include "remaps/formats/chunk_emitter.h"
#include "remaps/formats/corner_runs.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/pass_range.h"
#include "remaps/formats/position_text.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {
namespace {

/// The file as logical lines, of which only those that begin with 'v' and 'f' matter.
class ObjLines {
 public:
  explicit ObjLines(ByteSource& source) : scanner_(source) {}

  enum class Kind { vertex, face, other };

  bool at_end() const { return scanner_.at_end(); }
  TextScanner& scanner() { return scanner_; }

  /// Passes over the keyword of the line ahead.
  Kind begin_line() {
    scanner_.skip_blanks();
    const char first = scanner_.peek(0);
    comment_ = first == '#';
    if ((first != 'v' && first != 'f') || !ends_keyword(scanner_.peek(1))) return Kind::other;
    scanner_.consume(1);
    return first == 'v' ? Kind::vertex : Kind::face;
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
    pass_ = {first_face_.offset, source_.size()};
    ChunkEmitter<Triangle> triangles(sink);
    PolygonFan fan(triangles);
    std::uint64_t seen = first_face_.seen;
    for (; !lines.at_end(); lines.end_line()) {
      const ObjLines::Kind kind = lines.begin_line();
      if (kind == ObjLines::Kind::vertex) ++seen;
      if (kind == ObjLines::Kind::face) read_face(lines, fan, seen);
    }
    triangles.flush();
  }

  bool positions_are_float() const override { return all_float_; }
  double pass_fraction() const override { return pass_.fraction(source_.offset()); }
  std::uint64_t bytes_total() const override { return source_.size(); }
  std::uint64_t bytes_read() const override { return source_.offset(); }
  std::uint64_t bytes_read_total() const override { return source_.bytes_read_total(); }

 private:
  /// A place in the file, and the vertices before it.
  struct Place {
    std::uint64_t offset = 0;
    std::uint64_t seen = 0;
  };

  ObjLines go_to(const Place& place) {
    source_.seek(place.offset);
    return ObjLines(source_);
  }

  /// Goes through the file, calls visit(lines) behind the keyword of each vertex, counts them and
  /// notes where the faces begin.
  template <class Visit>
  void visit_vertices(Visit visit) {
    ObjLines lines = go_to({});
    pass_ = {0, source_.size()};
    std::optional<Place> first_face;
    std::uint64_t count = 0;
    for (; !lines.at_end(); lines.end_line()) {
      const std::uint64_t line = source_.offset();
      const ObjLines::Kind kind = lines.begin_line();
      if (kind == ObjLines::Kind::face && !first_face) first_face = {line, count};
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
  void read_face(ObjLines& lines, PolygonFan& fan, std::uint64_t seen) const {
    TextScanner& scanner = lines.scanner();
    fan.begin();
    while (lines.next_value()) {
      const std::int64_t index = scanner.integer('/');
      fan.corner(vertex_id(scanner, index, seen));
      while (scanner.peek(0) != '\\' && !is_blank(scanner.peek(0)) && !scanner.at_line_end()) {
        scanner.consume(1);
      }
    }
    if (fan.corners() < 3) {
      scanner.fail(fmt::format("expected a face of at least 3 corners, found {}", fan.corners()));
    }
  }

  VertexId vertex_id(const TextScanner& scanner, std::int64_t index, std::uint64_t seen) const {
    const auto magnitude =
        index < 0 ? 0 - static_cast<std::uint64_t>(index) : static_cast<std::uint64_t>(index);
    if (index > 0 && magnitude <= *vertices_) return magnitude - 1;
    if (index < 0 && magnitude <= seen) return seen - magnitude;
    scanner.fail(fmt::format("expected a vertex index from 1 to {} or from -{} to -1, found {}",
                             *vertices_, seen, index));
  }

  ByteSource source_;
  std::optional<std::uint64_t> vertices_;
  Place first_face_;  // once vertices_ is known
  bool all_float_ = false;
  PassRange pass_;
};

}  // namespace

std::unique_ptr<IndexedMeshReader> make_obj_reader(ByteSource source) {
  return std::make_unique<ObjReader>(std::move(source));
}

}  // namespace remaps
