#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/formats/chunk_emitter.h"
#include "remaps/formats/corner_runs.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/pass_range.h"
#include "remaps/formats/position_text.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {
namespace {

/// The lines of an OFF file that say something: comments run from '#' to the end of the line.
class OffLines {
 public:
  explicit OffLines(ByteSource& source) : scanner_(source) {}

  TextScanner& scanner() { return scanner_; }

  /// Goes to the first word of the next line that has one; false at the end of the file.
  bool next_line() {
    while (!next_value()) {
      if (scanner_.at_end()) return false;
      scanner_.skip_line();
    }
    return true;
  }
  /// Goes to the next word of the line; false at its end.
  bool next_value() {
    scanner_.skip_blanks();
    return !scanner_.at_line_end() && scanner_.peek(0) != '#';
  }
  void end_line() { scanner_.skip_line(); }

 private:
  TextScanner scanner_;
};

class OffReader final : public IndexedMeshReader {
 public:
  explicit OffReader(ByteSource source) : source_(std::move(source)) { read_header(); }

  void read_positions(PositionSink sink) override {
    OffLines lines = rewind(vertices_offset_);
    // Three words a vertex, four a face.
    const double share = 3 * double(vertices_) / (3 * double(vertices_) + 4 * double(faces_) + 1);
    pass_ = {vertices_offset_,
             faces_offset_.value_or(vertices_offset_ + static_cast<std::uint64_t>(
                                                           share * double(source_.remaining())))};
    ChunkEmitter<Vec3> positions(sink);
    PositionText text;
    for (std::uint64_t i = 0; i < vertices_; ++i) {
      expect_line(lines, "vertex", i, vertices_);
      positions.push(text.read(lines.scanner(), [&] { return lines.next_value(); }));
      lines.end_line();
    }
    positions.flush();
    all_float_ = text.all_float();
    faces_offset_ = source_.offset();
  }

  void read_triangles(IndexSink sink) override {
    OffLines lines = go_to_faces();
    pass_ = {*faces_offset_, source_.size()};
    ChunkEmitter<Triangle> triangles(sink);
    PolygonFan fan(triangles);
    for (std::uint64_t i = 0; i < faces_; ++i) {
      expect_line(lines, "face", i, faces_);
      read_face(lines, fan);
      lines.end_line();
    }
    triangles.flush();
  }

  bool positions_are_float() const override { return all_float_; }
  double pass_fraction() const override { return pass_.fraction(source_.offset()); }
  std::uint64_t bytes_total() const override { return source_.size(); }
  std::uint64_t bytes_read() const override { return source_.offset(); }
  std::uint64_t bytes_read_total() const override { return source_.bytes_read_total(); }

 private:
  OffLines rewind(std::uint64_t offset) {
    source_.seek(offset);
    return OffLines(source_);
  }

  OffLines go_to_faces() {
    if (faces_offset_) return rewind(*faces_offset_);
    OffLines lines = rewind(vertices_offset_);
    for (std::uint64_t i = 0; i < vertices_; ++i) {
      expect_line(lines, "vertex", i, vertices_);
      lines.end_line();
    }
    faces_offset_ = source_.offset();
    return lines;
  }

  void read_header() {
    OffLines lines = rewind(0);
    TextScanner& scanner = lines.scanner();
    if (!lines.next_line()) scanner.fail_expected("an OFF header");
    const char first = scanner.peek(0);
    if (first < '0' || first > '9') {
      check_keyword(scanner);
      while (lines.next_value()) {
        const char next = scanner.peek(0);
        if (next >= '0' && next <= '9') break;
        check_variant(scanner);
      }
    }
    vertices_ = read_count(lines, "the number of vertices");
    faces_ = read_count(lines, "the number of faces");
    lines.end_line();
    vertices_offset_ = source_.offset();
    check_counts();
  }

  /// Accepts OFF with the prefixes ST, C and N: what they announce comes after the position.
  static void check_keyword(TextScanner& scanner) {
    const std::string found(scanner.word());
    std::string_view word = found;
    for (const std::string_view prefix : {"ST", "C", "N"}) {
      if (word.starts_with(prefix)) word.remove_prefix(prefix.size());
    }
    if (word == "4OFF" || word == "nOFF" || word == "4nOFF") {
      scanner.fail("expected an OFF of three dimensions, 4OFF and nOFF are not supported");
    }
    if (word != "OFF") {
      scanner.fail(fmt::format("expected OFF as the first word, found '{}'", found.substr(0, 40)));
    }
  }

  static void check_variant(TextScanner& scanner) {
    const std::string word(scanner.word());
    if (word == "BINARY") scanner.fail("expected ASCII, binary OFF is not supported");
    scanner.fail(fmt::format("expected the number of vertices, found '{}'", word.substr(0, 40)));
  }

  /// Reads a count on this line or a later one.
  static std::uint64_t read_count(OffLines& lines, std::string_view what) {
    if (!lines.next_line()) lines.scanner().fail_expected(what);
    const std::int64_t count = lines.scanner().integer();
    if (count < 0) lines.scanner().fail(fmt::format("expected {}, found {}", what, count));
    return static_cast<std::uint64_t>(count);
  }

  /// A vertex takes 6 bytes at least ("0 0 0" and a line end), a face 8; the last has no line end.
  void check_counts() const {
    const std::uint64_t left = source_.remaining() + 1;
    if (vertices_ > left / 6 || faces_ > (left - 6 * vertices_) / 8) {
      source_.fail_at_byte(
          vertices_offset_,
          fmt::format("the header announces {} vertices and {} faces, but the file "
                      "has only {} bytes left for them",
                      vertices_, faces_, source_.remaining()));
    }
  }

  static void expect_line(OffLines& lines, std::string_view kind, std::uint64_t i,
                          std::uint64_t count) {
    if (lines.next_line()) return;
    lines.scanner().fail(
        fmt::format("expected {} {} of {}, found the end of the file", kind, i, count));
  }

  void read_face(OffLines& lines, PolygonFan& fan) const {
    TextScanner& scanner = lines.scanner();
    const std::int64_t corners = scanner.integer();
    if (corners < 3) {
      scanner.fail(fmt::format("expected a face of at least 3 corners, found {}", corners));
    }
    fan.begin();
    for (std::int64_t i = 0; i < corners; ++i) {
      if (!lines.next_value()) {
        scanner.fail(fmt::format("expected {} vertex indices, found {}", corners, i));
      }
      const std::int64_t index = scanner.integer();
      if (index < 0 || static_cast<std::uint64_t>(index) >= vertices_) {
        scanner.fail(fmt::format("expected a vertex index below {}, found {}", vertices_, index));
      }
      fan.corner(static_cast<VertexId>(index));
    }
  }

  ByteSource source_;
  std::uint64_t vertices_ = 0, faces_ = 0;
  std::uint64_t vertices_offset_ = 0;
  std::optional<std::uint64_t> faces_offset_;
  bool all_float_ = false;
  PassRange pass_;
};

}  // namespace

std::unique_ptr<IndexedMeshReader> make_off_reader(ByteSource source) {
  return std::make_unique<OffReader>(std::move(source));
}

}  // namespace remaps
