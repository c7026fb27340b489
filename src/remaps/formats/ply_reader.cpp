#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/formats/chunk_emitter.h"
#include "remaps/formats/corner_runs.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/pass_range.h"
#include "remaps/formats/ply_attributes.h"
#include "remaps/formats/ply_cursor.h"
#include "remaps/formats/ply_header.h"
#include "remaps/formats/ply_records.h"
#include "remaps/formats/ply_runs.h"
#include "remaps/formats/position_value.h"

namespace remaps {
namespace {

/// The first n elements, or all.
template <class T>
std::span<T> up_to(std::span<T> all, std::uint64_t n) {
  return all.first(static_cast<std::size_t>(std::min<std::uint64_t>(all.size(), n)));
}

template <class Cursor>
class PositionHandler {
 public:
  PositionHandler(PositionSink sink, std::optional<PlyPointRuns> runs)
      : positions_(sink), runs_(runs) {}

  void coordinate(Cursor& cursor, const PlyStep& step) {
    point_[step.axis] = cursor.coordinate(step.type);
  }
  void corners(Cursor&, const PlyStep&) {}
  void end_record() {
    const Vec3 p{point_[0], point_[1], point_[2]};
    if (!has_position(p)) {
      positions_.push(kNotFinite);
      return;
    }
    all_float_ = all_float_ && is_float(p);
    positions_.push(p);
  }

  std::uint64_t run(Cursor& cursor, std::uint64_t wanted) {
    std::uint64_t taken = 0;
    if constexpr (Cursor::kBinary) {
      while (runs_ && taken < wanted) {
        const std::span<Vec3> room = up_to(positions_.room(), wanted - taken);
        const auto done = runs_->decode(cursor.ahead(runs_->record_bytes()), room);
        if (done.records == 0) break;
        all_float_ = all_float_ && done.all_float;
        cursor.pass(done.records * runs_->record_bytes());
        positions_.keep(done.records);
        taken += done.records;
      }
    }
    return taken;
  }

  void flush() { positions_.flush(); }
  bool all_float() const { return all_float_; }

 private:
  ChunkEmitter<Vec3> positions_;
  std::optional<PlyPointRuns> runs_;
  std::array<double, 3> point_{};
  bool all_float_ = true;
};

/// Reads the lists of 'face' and of 'tristrips'.
template <class Cursor>
class CornerHandler {
 public:
  CornerHandler(ChunkEmitter<Triangle>& triangles, PolygonCutter* cutter, std::uint64_t vertices,
                bool strips, std::optional<PlyTriangleRuns> runs)
      : triangles_(triangles),
        polygon_(triangles, cutter),
        strip_(triangles),
        vertices_(vertices),
        strips_(strips),
        runs_(runs) {}

  void coordinate(Cursor&, const PlyStep&) {}
  void corners(Cursor& cursor, const PlyStep& step) {
    const std::uint64_t n = cursor.integer(step.count_type);
    cursor.expect_list(n, step.type);
    if (strips_) {
      read_strip(cursor, step.type, n);
    } else {
      read_polygon(cursor, step, n);
    }
  }
  void end_record() {}

  std::uint64_t run(Cursor& cursor, std::uint64_t wanted) {
    std::uint64_t taken = 0;
    if constexpr (Cursor::kBinary) {
      while (runs_ && taken < wanted) {
        const std::span<Triangle> room = up_to(triangles_.room(), wanted - taken);
        const std::size_t n = runs_->decode(cursor.ahead(runs_->record_bytes()), vertices_, room);
        if (n == 0) break;
        cursor.pass(n * runs_->record_bytes());
        triangles_.keep(n);
        taken += n;
      }
    }
    return taken;
  }

 private:
  static constexpr std::uint64_t kRestart = ~std::uint64_t{0};  // -1

  void read_polygon(Cursor& cursor, const PlyStep& step, std::uint64_t n) {
    if (n < 3) {
      cursor.fail(step.count_type, fmt::format("expected at least 3 corners, found {}", n));
    }
    polygon_.begin();
    for (; n > 0; --n) polygon_.corner(checked(cursor, step.type, cursor.integer(step.type)));
    polygon_.end();
  }

  void read_strip(Cursor& cursor, PlyType type, std::uint64_t n) {
    strip_.restart();
    for (; n > 0; --n) {
      const std::uint64_t index = cursor.integer(type);
      if (index == kRestart) {
        strip_.restart();
      } else {
        strip_.corner(checked(cursor, type, index));
      }
    }
  }

  VertexId checked(Cursor& cursor, PlyType type, std::uint64_t index) const {
    if (index >= vertices_) {
      cursor.fail(type, fmt::format("expected a vertex index below {}, found {}", vertices_,
                                    static_cast<std::int64_t>(index)));
    }
    return index;
  }

  ChunkEmitter<Triangle>& triangles_;
  PolygonRun polygon_;
  StripUnroller strip_;
  std::uint64_t vertices_;
  bool strips_;
  std::optional<PlyTriangleRuns> runs_;
};

class PlyReader final : public IndexedMeshReader {
 public:
  explicit PlyReader(ByteSource source)
      : source_(std::move(source)), header_(read_ply_header(source_)) {
    offsets_.resize(header_.elements.size() + 1);
    offsets_[0] = header_.data_offset;
    find_coordinates();
    for (const PlyElement& element : header_.elements) {
      if (has_corners(element) && element.count > 0) check_corner_list(element);
    }
  }

  void read_positions(PositionSink sink) override {
    with_cursor([&]<class Cursor>(Cursor& cursor) {
      const std::size_t index = index_of(*vertex_);
      go_to(cursor, index);
      begin_pass(index, index);
      std::optional<PlyPointRuns> runs;
      if constexpr (Cursor::kBinary) runs = PlyPointRuns::of(*vertex_, cursor.big_endian());
      PositionHandler<Cursor> handler(sink, runs);
      walk_records(cursor, *vertex_, plan_record<Cursor>(*vertex_, true), handler);
      handler.flush();
      all_float_ = all_float_ || handler.all_float();
      offsets_[index + 1] = cursor.offset();
    });
  }

  void read_triangles(IndexSink sink) override {
    with_cursor([&]<class Cursor>(Cursor& cursor) {
      ChunkEmitter<Triangle> triangles(sink);
      bool begun = false;
      for (const PlyElement& element : header_.elements) {
        if (!has_corners(element) || element.count == 0) continue;
        go_to(cursor, index_of(element));
        if (!std::exchange(begun, true)) begin_pass(index_of(element), last_with_corners());
        const bool strips = element.name == "tristrips";
        std::optional<PlyTriangleRuns> runs;
        if constexpr (Cursor::kBinary) {
          if (!strips)
            runs = PlyTriangleRuns::of(element, *corner_list(element), cursor.big_endian());
        }
        CornerHandler<Cursor> handler(triangles, cutter_, vertex_->count, strips, runs);
        walk_records(cursor, element, plan_record<Cursor>(element, true), handler);
        offsets_[index_of(element) + 1] = cursor.offset();
      }
      triangles.flush();
    });
  }

  void set_polygon_cutter(PolygonCutter* cutter) override { cutter_ = cutter; }
  bool positions_are_float() const override { return all_float_; }
  std::optional<PositionArray> position_array() const override {
    const std::optional<std::uint64_t> begin = offsets_[index_of(*vertex_)];
    const bool as_in_memory = header_.encoding == PlyEncoding::little_endian &&
                              std::endian::native == std::endian::little;
    if (!begin || !as_in_memory || source_.is_compressed() || !is_float_triple())
      return std::nullopt;
    return PositionArray{source_.path(), *begin};
  }
  std::vector<AttributeSpec> attributes() override { return find_ply_attributes(header_); }
  void read_attributes(AttributePer per, AttributeSink sink) override {
    const std::vector<AttributeSpec> specs = attributes_per(attributes(), per);
    const PlyElement* const element = per == AttributePer::vertex ? vertex_ : header_.find("face");
    if (specs.empty() || element == nullptr) return;
    with_cursor([&]<class Cursor>(Cursor& cursor) {
      const std::size_t index = index_of(*element);
      go_to(cursor, index);
      begin_pass(index, index);
      read_ply_rows(cursor, *element, per, specs, {cutter_, vertex_->count}, sink);
    });
  }
  double pass_fraction() const override { return pass_.fraction(source_.file_offset()); }
  std::uint64_t bytes_total() const override { return source_.file_size(); }
  std::uint64_t bytes_read() const override { return source_.file_offset(); }
  std::uint64_t bytes_read_total() const override { return source_.bytes_read_total(); }

 private:
  static bool has_corners(const PlyElement& element) {
    return element.name == "face" || element.name == "tristrips";
  }

  std::size_t index_of(const PlyElement& element) const {
    return static_cast<std::size_t>(&element - header_.elements.data());
  }

  void find_coordinates() {
    vertex_ = header_.find("vertex");
    if (vertex_ == nullptr) fail_header("expected an element 'vertex'");
    all_float_ = true;
    const bool text = header_.encoding == PlyEncoding::ascii;
    for (const std::string_view axis : kPlyAxes) {
      const PlyProperty* const property = vertex_->find(axis);
      if (property == nullptr || property->count_type) {
        fail_header(fmt::format("expected a scalar property '{}' of 'vertex'", axis));
      }
      // Text may have fractions where the header says integer: what they are is seen when read.
      all_float_ &= fits_float(property->type) && !(text && is_integer(property->type));
    }
  }

  /// True when a vertex is x, y and z in floats and nothing else.
  bool is_float_triple() const {
    const std::vector<PlyProperty>& properties = vertex_->properties;
    if (properties.size() != kPlyAxes.size()) return false;
    for (std::size_t i = 0; i < kPlyAxes.size(); ++i) {
      if (&properties[i] != vertex_->find(kPlyAxes[i]) || properties[i].type != PlyType::float32)
        return false;
    }
    return true;
  }

  void check_corner_list(const PlyElement& element) const {
    const PlyProperty* const list = corner_list(element);
    if (list == nullptr || !list->count_type || !is_integer(list->type)) {
      fail_header(
          fmt::format("expected a list of integers 'vertex_indices' of '{}'", element.name));
    }
  }

  [[noreturn]] void fail_header(std::string_view what) const {
    throw InputError(fmt::format("{}: PLY header: {}", source_.path().string(), what));
  }

  std::size_t last_with_corners() const {
    std::size_t last = 0;
    for (const PlyElement& element : header_.elements) {
      if (has_corners(element) && element.count > 0) last = index_of(element);
    }
    return last;
  }

  /// Notes where a pass through elements first ... last begins and, if need be guessed by the sizes
  /// of the rest of the file with three values a list, where it will end.
  void begin_pass(std::size_t first, std::size_t last) {
    const auto expected = [this](std::size_t begin, std::size_t end) {
      double size = 0;
      for (std::size_t e = begin; e < end; ++e) {
        size += double(header_.elements[e].count) * expected_record_size(header_.elements[e]);
      }
      return size;
    };
    pass_.begin = source_.file_offset();
    const double rest = expected(first, header_.elements.size());
    const double share = rest > 0 ? expected(first, last + 1) / rest : 1;
    const std::uint64_t left = source_.file_size() - pass_.begin;
    pass_.end = offsets_[last + 1] ? source_.file_offset_of(*offsets_[last + 1])
                                   : pass_.begin + static_cast<std::uint64_t>(share * double(left));
  }

  double expected_record_size(const PlyElement& element) const {
    std::size_t size = 0;
    for (const PlyProperty& property : element.properties) {
      const bool text = header_.encoding == PlyEncoding::ascii;
      const std::size_t value = text ? 1 : size_of(property.type);
      size += property.count_type ? (text ? 1 : size_of(*property.count_type)) + 3 * value : value;
    }
    return double(size);
  }

  template <class Pass>
  void with_cursor(Pass pass) {
    if (header_.encoding == PlyEncoding::ascii) {
      PlyTextCursor cursor(source_);
      pass(cursor);
    } else {
      PlyBinaryCursor cursor(source_, header_.encoding == PlyEncoding::big_endian);
      pass(cursor);
    }
  }

  /// Goes to the first record of an element, from the last element before it whose place is known.
  template <class Cursor>
  void go_to(Cursor& cursor, std::size_t index) {
    std::size_t at = index;
    while (!offsets_[at]) --at;
    source_.seek(*offsets_[at]);
    for (; at < index; ++at) {
      skip_element(cursor, header_.elements[at]);
      offsets_[at + 1] = cursor.offset();
    }
  }

  ByteSource source_;
  PlyHeader header_;
  const PlyElement* vertex_ = nullptr;
  std::vector<std::optional<std::uint64_t>> offsets_;  // where each element begins, once known
  bool all_float_ = false;
  PolygonCutter* cutter_ = nullptr;
  PassRange pass_;
};

}  // namespace

std::unique_ptr<IndexedMeshReader> make_ply_reader(ByteSource source) {
  return std::make_unique<PlyReader>(std::move(source));
}

}  // namespace remaps
