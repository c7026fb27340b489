#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "remaps/formats/chunk_emitter.h"
#include "remaps/formats/format_detection.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/pass_range.h"
#include "remaps/formats/position_text.h"
#include "remaps/formats/position_value.h"
#include "remaps/formats/stl_layout.h"
#include "remaps/formats/text_scanner.h"

namespace remaps {
namespace {

/// What both kinds of STL share: face f has the vertices 3f, 3f + 1, 3f + 2. If one of them is not
/// finite none of them is: they are nobody else's.
class StlReader : public IndexedMeshReader {
 public:
  explicit StlReader(ByteSource source) : source_(std::move(source)) {}

  void read_triangles(IndexSink sink) final {
    const std::uint64_t faces = face_count();
    triangles_pass_ = true;
    ChunkEmitter<Triangle> triangles(sink);
    for (std::uint64_t f = 0; f < faces; ++f) {
      triangles.push({3 * f, 3 * f + 1, 3 * f + 2});
      fraction_ = double(f + 1) / double(faces);
    }
    triangles.flush();
  }

  VertexSharing vertex_sharing() const final { return VertexSharing::none; }
  double pass_fraction() const final {
    return triangles_pass_ ? fraction_ : pass_.fraction(source_.file_offset());
  }
  std::uint64_t bytes_total() const final { return source_.file_size(); }
  std::uint64_t bytes_read() const final { return source_.file_offset(); }
  std::uint64_t bytes_read_total() const final { return source_.bytes_read_total(); }

 protected:
  virtual std::uint64_t face_count() = 0;

  ByteSource& source() { return source_; }
  void begin_positions(std::uint64_t offset) {
    source_.seek(offset);
    triangles_pass_ = false;
    pass_ = {source_.file_offset(), source_.file_size()};
  }

 private:
  ByteSource source_;
  PassRange pass_;
  bool triangles_pass_ = false;
  double fraction_ = 0;
};

class BinaryStlReader final : public StlReader {
 public:
  explicit BinaryStlReader(ByteSource from) : StlReader(std::move(from)) {
    if (source().require(kStlHeader) < kStlHeader) {
      source().fail_at_byte(source().size(),
                            "expected a binary STL with a header of 80 bytes and the number of "
                            "triangles, found the end of the file");
    }
    faces_ = stl_triangle_count(source().data());
    source().consume(kStlHeader);
    if (faces_ > source().remaining() / kStlTriangle) {
      source().fail_at_byte(
          kStlCount, fmt::format("the header announces {} triangles of {} bytes each, but {}",
                                 faces_, kStlTriangle, source().room_text()));
    }
  }

  void read_positions(PositionSink sink) override {
    begin_positions(kStlHeader);
    ChunkEmitter<Vec3> positions(sink);
    for (std::uint64_t f = 0; f < faces_;) f += read_some(f, positions);
    positions.flush();
  }

  bool positions_are_float() const override { return true; }

 private:
  using Corners = std::array<std::array<float, 3>, 3>;

  std::uint64_t face_count() override { return faces_; }

  static Corners corners_at(const char* record) {
    Corners corners;
    std::memcpy(&corners, record + kStlNormal, sizeof corners);
    return corners;
  }

  /// Reads the triangles in the buffer that the present chunk has room for, from the f-th on.
  std::uint64_t read_some(std::uint64_t f, ChunkEmitter<Vec3>& positions) {
    const std::size_t there = source().require(kStlTriangle) / kStlTriangle;
    if (there == 0) {
      source().fail_at_byte(source().size(), fmt::format("triangle {} of {}: the file ends within "
                                                         "this record",
                                                         f, faces_));
    }
    const std::span<Vec3> room = positions.room();
    const auto n = static_cast<std::size_t>(
        std::min<std::uint64_t>({there, std::max<std::size_t>(room.size() / 3, 1), faces_ - f}));
    const char* at = source().data();
    for (std::size_t i = 0; i < n; ++i, at += kStlTriangle) {
      const Corners corners = corners_at(at);
      const bool finite = is_finite(corners);
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3 p = finite ? Vec3{corners[c][0], corners[c][1], corners[c][2]} : kNotFinite;
        room.size() < 3 ? positions.push(p) : void(room[3 * i + c] = p);
      }
    }
    if (room.size() >= 3) positions.keep(3 * n);
    source().consume(n * kStlTriangle);
    return n;
  }

  static bool is_finite(const Corners& corners) {
    float sum = 0;  // times 0: NaN if any is infinite or NaN
    for (const auto& corner : corners) {
      for (const float x : corner) sum += 0 * x;
    }
    return sum == 0;
  }

  std::uint64_t faces_ = 0;
};

/// "solid NAME", facets, "endsolid NAME"; any number of solids. Keywords are in whatever case, line
/// ends count only behind names.
class AsciiStlReader final : public StlReader {
 public:
  explicit AsciiStlReader(ByteSource source) : StlReader(std::move(source)) {}

  void read_positions(PositionSink sink) override {
    begin_positions(0);
    skip_byte_order_mark(source());
    TextScanner scanner(source());
    ChunkEmitter<Vec3> positions(sink);
    PositionText text;
    std::uint64_t faces = 0;
    expect(scanner, "solid");
    do {
      scanner.skip_line();
      for (; !read_end_of_solid(scanner); ++faces) read_facet(scanner, text, positions);
      scanner.skip_line();
      scanner.skip_space();
      if (scanner.at_end()) break;
      expect(scanner, "solid");
    } while (true);
    positions.flush();
    faces_ = faces;
    all_float_ = text.all_float();
  }

  bool positions_are_float() const override { return all_float_; }

 private:
  std::uint64_t face_count() override {
    if (!faces_) read_positions([](std::span<const Vec3>) {});
    return *faces_;
  }

  /// True if the word ahead is this one, in whatever case.
  static bool is_ahead(const TextScanner& scanner, std::string_view word) {
    for (std::size_t i = 0; i < word.size(); ++i) {
      const char c = scanner.peek(i);
      if (c == '\n' || (c != word[i] && c + ('a' - 'A') != word[i])) return false;
    }
    const char behind = scanner.peek(word.size());
    return is_blank(behind) || behind == '\n';
  }
  static bool take(TextScanner& scanner, std::string_view word) {
    scanner.skip_space();
    if (!is_ahead(scanner, word)) return false;
    scanner.consume(word.size());
    return true;
  }
  static void expect(TextScanner& scanner, std::string_view word) {
    if (!take(scanner, word)) scanner.fail_expected(fmt::format("'{}'", word));
  }

  /// Passes over "facet" or "endsolid"; true if it is the latter.
  static bool read_end_of_solid(TextScanner& scanner) {
    if (take(scanner, "facet")) return false;
    if (!take(scanner, "endsolid")) scanner.fail_expected("'facet' or 'endsolid'");
    return true;
  }

  /// Reads what follows "facet". The normal is passed over unread: it may be missing or NaN.
  static void read_facet(TextScanner& scanner, PositionText& text, ChunkEmitter<Vec3>& positions) {
    constexpr int kNormalWords = 4;
    for (int i = 0; i < kNormalWords && !is_next(scanner, "outer"); ++i) scanner.skip_word();
    expect(scanner, "outer");
    expect(scanner, "loop");
    std::array<Vec3, 3> corners;
    for (Vec3& corner : corners) {
      expect(scanner, "vertex");
      corner = text.read(scanner, [&] {
        scanner.skip_blanks();
        return !scanner.at_line_end();
      });
    }
    const bool finite = std::all_of(corners.begin(), corners.end(), has_position);
    for (const Vec3& corner : corners) positions.push(finite ? corner : kNotFinite);
    expect(scanner, "endloop");
    expect(scanner, "endfacet");
  }
  static bool is_next(TextScanner& scanner, std::string_view word) {
    scanner.skip_space();
    return is_ahead(scanner, word);
  }

  std::optional<std::uint64_t> faces_;
  bool all_float_ = false;
};

}  // namespace

std::unique_ptr<IndexedMeshReader> make_binary_stl_reader(ByteSource source) {
  return std::make_unique<BinaryStlReader>(std::move(source));
}

std::unique_ptr<IndexedMeshReader> make_ascii_stl_reader(ByteSource source) {
  return std::make_unique<AsciiStlReader>(std::move(source));
}

}  // namespace remaps
