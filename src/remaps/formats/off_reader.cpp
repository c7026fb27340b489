#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
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
    const std::uint64_t begin = source_.file_offset();
    pass_ = {begin, faces_offset_ ? source_.file_offset_of(*faces_offset_)
                                  : begin + static_cast<std::uint64_t>(
                                                share * double(source_.file_size() - begin))};
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
    pass_ = {source_.file_offset(), source_.file_size()};
    ChunkEmitter<Triangle> triangles(sink);
    PolygonRun polygon(triangles, cutter_);
    for (std::uint64_t i = 0; i < faces_; ++i) {
      expect_line(lines, "face", i, faces_);
      read_face(lines, polygon);
      lines.end_line();
    }
    triangles.flush();
  }

  std::vector<AttributeSpec> attributes() override {
    std::vector<AttributeSpec> specs;
    const auto add = [&](const char* name, AttributeKind kind, AttributePer per,
                         std::initializer_list<const char*> names, ScalarType type) {
      specs.push_back({name, kind, per, {}, false});
      for (const char* component : names) specs.back().components.push_back({component, type});
    };
    const auto add_colour = [&](const char* name, AttributePer per, const Rest& rest) {
      if (rest.numbers != 3 && rest.numbers != 4) return;
      add(name, AttributeKind::colour, per, {"red", "green", "blue"}, rest.type);
      if (rest.numbers == 4) specs.back().components.push_back({"alpha", rest.type});
    };
    if (has_normals_) {
      add("normal", AttributeKind::normal, AttributePer::vertex, {"nx", "ny", "nz"},
          ScalarType::float32);
    }
    if (has_colours_ && vertices_ > 0) add_colour("colour", AttributePer::vertex, vertex_colour());
    if (has_texture_) {
      add("uv", AttributeKind::uv, AttributePer::vertex, {"s", "t"}, ScalarType::float32);
    }
    if (faces_ > 0) {
      const bool taken = has_colours_ && channels(specs, AttributePer::vertex) > 0;
      add_colour(taken ? "face-colour" : "colour", AttributePer::face, face_colour());
    }
    vertex_numbers_ = channels(specs, AttributePer::vertex);
    face_numbers_ = channels(specs, AttributePer::face);
    return specs;
  }

  void read_attributes(AttributePer per, AttributeSink sink) override {
    if (per == AttributePer::vertex && vertex_numbers_ > 0) read_vertex_rows(sink);
    if (per == AttributePer::face && face_numbers_ > 0) read_face_rows(sink);
  }

  void set_polygon_cutter(PolygonCutter* cutter) override { cutter_ = cutter; }
  bool positions_are_float() const override { return all_float_; }
  double pass_fraction() const override { return pass_.fraction(source_.file_offset()); }
  std::uint64_t bytes_total() const override { return source_.file_size(); }
  std::uint64_t bytes_read() const override { return source_.file_offset(); }
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

  /// The numbers in the rest of a line.
  struct Rest {
    std::size_t numbers = 0;
    ScalarType type = ScalarType::uint8;  // float32 if one is not a whole number of 0 to 255
  };

  static Rest look_at_rest(OffLines& lines) {
    Rest rest;
    while (rest.numbers < 16 && lines.next_value()) {
      std::string word(lines.scanner().word());
      const bool ended = word.find('#') != std::string::npos;
      word.resize(std::min(word.find('#'), word.size()));
      const bool whole = !word.empty() && word.size() <= 3 &&
                         word.find_first_not_of("0123456789") == std::string::npos &&
                         std::stoi(word) <= 255;
      if (!whole) rest.type = ScalarType::float32;
      ++rest.numbers;
      if (ended) break;
    }
    return rest;
  }

  Rest vertex_colour() {
    OffLines lines = rewind(vertices_offset_);
    expect_line(lines, "vertex", 0, vertices_);
    for (std::size_t i = 0; i < (has_normals_ ? 6U : 3U) && lines.next_value(); ++i) {
      lines.scanner().coordinate();
    }
    Rest rest = look_at_rest(lines);
    if (has_texture_ && rest.numbers >= 2) {
      rest.numbers -= 2;
      // Texture coordinates say nothing about the colour's type: take the wider one.
      rest.type = ScalarType::float32;
    }
    return rest;
  }

  Rest face_colour() {
    OffLines lines = go_to_faces();
    expect_line(lines, "face", 0, faces_);
    pass_corners(lines);
    return look_at_rest(lines);
  }

  static std::int64_t pass_corners(OffLines& lines) {
    const std::int64_t corners = lines.scanner().integer();
    for (std::int64_t i = 0; i < corners && lines.next_value(); ++i) lines.scanner().integer();
    return corners;
  }

  /// Reads numbers of the line; those that are missing are 0. A comment may follow without a blank.
  void read_values(OffLines& lines, std::span<double> values) {
    bool ended = false;
    for (double& value : values) {
      value = 0;
      if (ended || !lines.next_value()) continue;
      const std::uint64_t at = lines.scanner().source().offset();
      std::string_view word = lines.scanner().word();
      ended = word.find('#') != std::string_view::npos;
      word = word.substr(0, word.find('#'));
      if (word.starts_with('+')) word.remove_prefix(1);
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (error != std::errc() || end != word.data() + word.size()) {
        source_.fail_at_line(at, fmt::format("expected a number, found '{}'", word.substr(0, 40)));
      }
    }
  }

  void read_vertex_rows(AttributeSink sink) {
    OffLines lines = rewind(vertices_offset_);
    pass_ = {source_.file_offset(), source_.file_size()};
    RowEmitter rows(vertex_numbers_, sink);
    std::vector<double> values(vertex_numbers_);
    for (std::uint64_t i = 0; i < vertices_; ++i, lines.end_line()) {
      expect_line(lines, "vertex", i, vertices_);
      for (int axis = 0; axis < 3 && lines.next_value(); ++axis) lines.scanner().coordinate();
      read_values(lines, values);
      rows.push(values);
    }
    rows.flush();
  }

  void read_face_rows(AttributeSink sink) {
    OffLines lines = go_to_faces();
    pass_ = {source_.file_offset(), source_.file_size()};
    RowEmitter rows(face_numbers_, sink);
    std::vector<double> values(face_numbers_);
    for (std::uint64_t i = 0; i < faces_; ++i, lines.end_line()) {
      expect_line(lines, "face", i, faces_);
      const std::int64_t corners = pass_corners(lines);
      read_values(lines, values);
      for (std::int64_t triangle = 2; triangle < corners; ++triangle) rows.push(values);
    }
    rows.flush();
  }

  void read_header() {
    OffLines lines = rewind(0);
    skip_byte_order_mark(source_);
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

  /// Some files have the number of vertices right behind it: "OFF8 6 12".
  static std::string take_keyword(TextScanner& scanner) {
    constexpr std::size_t kLongest = 8;
    std::string letters;
    while (letters.size() < kLongest && scanner.peek(letters.size()) >= 'A' &&
           scanner.peek(letters.size()) <= 'Z') {
      letters += scanner.peek(letters.size());
    }
    const char next = scanner.peek(letters.size());
    if (!letters.ends_with("OFF") || next < '0' || next > '9') return std::string(scanner.word());
    scanner.consume(letters.size());
    return letters;
  }

  /// Accepts OFF with the prefixes ST, C and N: what they announce comes after the position:
  /// normal, colour, texture coordinates.
  void check_keyword(TextScanner& scanner) {
    const std::string found = take_keyword(scanner);
    std::string_view word = found;
    const auto announces = [&word](std::string_view prefix) {
      const bool starts = word.starts_with(prefix);
      if (starts) word.remove_prefix(prefix.size());
      return starts;
    };
    has_texture_ = announces("ST");
    has_colours_ = announces("C");
    has_normals_ = announces("N");
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
          fmt::format("the header announces {} vertices and {} faces, but {} for them", vertices_,
                      faces_, source_.room_text()));
    }
  }

  static void expect_line(OffLines& lines, std::string_view kind, std::uint64_t i,
                          std::uint64_t count) {
    if (lines.next_line()) return;
    lines.scanner().fail(
        fmt::format("expected {} {} of {}, found the end of the file", kind, i, count));
  }

  void read_face(OffLines& lines, PolygonRun& polygon) const {
    TextScanner& scanner = lines.scanner();
    const std::int64_t corners = scanner.integer();
    if (corners < 3) {
      scanner.fail(fmt::format("expected a face of at least 3 corners, found {}", corners));
    }
    polygon.begin();
    for (std::int64_t i = 0; i < corners; ++i) {
      if (!lines.next_value()) {
        scanner.fail(fmt::format("expected {} vertex indices, found {}", corners, i));
      }
      const std::int64_t index = scanner.integer();
      if (index < 0 || static_cast<std::uint64_t>(index) >= vertices_) {
        scanner.fail(fmt::format("expected a vertex index below {}, found {}", vertices_, index));
      }
      polygon.corner(static_cast<VertexId>(index));
    }
    polygon.end();
  }

  ByteSource source_;
  std::uint64_t vertices_ = 0, faces_ = 0;
  std::uint64_t vertices_offset_ = 0;
  std::optional<std::uint64_t> faces_offset_;
  bool all_float_ = false;
  bool has_texture_ = false, has_colours_ = false, has_normals_ = false;
  std::size_t vertex_numbers_ = 0, face_numbers_ = 0;  // of a row
  PolygonCutter* cutter_ = nullptr;
  PassRange pass_;
};

}  // namespace

std::unique_ptr<IndexedMeshReader> make_off_reader(ByteSource source) {
  return std::make_unique<OffReader>(std::move(source));
}

}  // namespace remaps
