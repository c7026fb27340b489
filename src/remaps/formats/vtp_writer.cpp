#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "remaps/formats/column_spool.h"
#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/vtp_columns.h"

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

/// Before every array of the appended data: its bytes, as UInt64.
constexpr std::uint64_t kArrayHeader = sizeof(std::uint64_t);

/// Makes the XML part: arrays lie one after the other behind it, in the order of these calls.
class VtpHeader {
 public:
  VtpHeader(std::uint64_t vertices, std::uint64_t faces) {
    text_ = fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n"
        "<PolyData>\n"
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
        "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
        vertices, faces);
  }
  void line(std::string_view text) { text_.append(text).push_back('\n'); }
  void array(std::string_view type, std::string_view name, unsigned components,
             std::uint64_t bytes) {
    text_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
        "offset=\"{}\"/>\n",
        type, name, components, offset_);
    offset_ += kArrayHeader + bytes;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::uint64_t offset_ = 0;
};

class VtpWriter final : public CountedWriter {
 public:
  VtpWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces,
            const MeshWriterOptions& options)
      : CountedWriter(path, vertices, faces, options.attributes),
        level_(options.level),
        wide_(vertices > kMostNarrow || faces > kMostNarrow / 3) {
    std::vector<std::string> taken;
    points_ = find_vtp_columns(attributes(), AttributePer::vertex, taken);
    taken.clear();
    if (level_) taken = {"base_face", "level", "patch_id"};
    cells_ = find_vtp_columns(attributes(), AttributePer::face, taken);
    corners_ = find_vtp_columns(attributes(), AttributePer::corner, taken);
    put_header();
    point_spool_ = spool_of(points_, vertices);
    cell_spool_ = spool_of(cells_, faces);
    corner_spool_ = spool_of(corners_, 3 * faces);
    put<std::uint64_t>(point_bytes());
  }

 private:
  static constexpr std::uint64_t kMostNarrow = std::numeric_limits<std::int32_t>::max();

  void put_header() {
    VtpHeader header(vertices(), faces());
    const std::string_view index = wide_ ? "Int64" : "Int32";
    const auto columns = [&](const std::vector<VtpColumn>& all, std::uint64_t rows, unsigned each) {
      for (const VtpColumn& c : all) {
        header.array(c.type, c.name, each * c.components, rows * each * c.bytes);
      }
    };
    header.line("<Points>");
    header.array("Float32", "Points", 3, point_bytes());
    header.line("</Points>");
    if (!points_.empty()) {
      header.line(fmt::format("<PointData{}>", vtp_roles(points_)));
      columns(points_, vertices(), 1);
      header.line("</PointData>");
    }
    header.line("<Polys>");
    header.array(index, "connectivity", 1, 3 * faces() * index_bytes());
    header.array(index, "offsets", 1, faces() * index_bytes());
    header.line("</Polys>");
    if (level_ || !cells_.empty() || !corners_.empty()) {
      header.line(level_ ? "<CellData Scalars=\"base_face\">" : "<CellData>");
      if (level_) {
        header.array("UInt32", "base_face", 1, faces() * sizeof(std::uint32_t));
        header.array("UInt8", "level", 1, faces());
        header.array("UInt32", "patch_id", 1, faces() * sizeof(std::uint32_t));
      }
      columns(cells_, faces(), 1);
      columns(corners_, faces(), 3);
      header.line("</CellData>");
    }
    header.line("</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">");
    sink().write(header.text().data(), header.text().size());
    put<char>('_');
  }

  std::unique_ptr<ColumnSpool> spool_of(const std::vector<VtpColumn>& columns, std::uint64_t rows) {
    if (columns.empty()) return nullptr;
    std::vector<std::size_t> widths;
    for (const VtpColumn& column : columns) widths.push_back(column.bytes);
    return std::make_unique<ColumnSpool>(sink().path(), rows, std::move(widths));
  }
  void put_columns(const std::vector<VtpColumn>& columns, std::uint64_t rows,
                   const std::unique_ptr<ColumnSpool>& spool) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      put<std::uint64_t>(rows * columns[c].bytes);
      spool->copy(c, sink());
    }
  }

  std::uint64_t point_bytes() const { return vertices() * sizeof(Vec3f); }
  std::uint64_t index_bytes() const { return wide_ ? sizeof(std::int64_t) : sizeof(std::int32_t); }

  template <class T>
  void put(T value) {
    std::memcpy(sink().room(sizeof value), &value, sizeof value);
    sink().advance(sizeof value);
  }
  void put_index(std::uint64_t index) {
    if (wide_) {
      put(static_cast<std::int64_t>(index));
    } else {
      put(static_cast<std::int32_t>(index));
    }
  }

  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& position : positions) put(to_float(position));
  }

  void put_vertices(std::span<const Vec3> positions, std::span<const std::byte> rows) override {
    put_positions(positions);
    point_spool_->append(rows);
  }

  void put_faces(std::span<const Triangle> triangles, std::span<const std::byte> face_rows,
                 std::span<const std::byte> corner_rows) override {
    put_triangles(triangles);
    if (cell_spool_) cell_spool_->append(face_rows);
    if (corner_spool_) corner_spool_->append(corner_rows);
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    begin_faces();
    for (const Triangle& t : triangles) {
      for (const VertexId v : t) put_index(v);
    }
  }

  void begin_faces() {
    if (std::exchange(faces_begun_, true)) return;
    put_columns(points_, vertices(), point_spool_);
    put<std::uint64_t>(3 * faces() * index_bytes());
  }

  void finish() override {
    begin_faces();
    put<std::uint64_t>(faces() * index_bytes());
    for (std::uint64_t f = 1; f <= faces(); ++f) put_index(3 * f);
    if (level_) put_cell_data(2 * *level_);
    put_columns(cells_, faces(), cell_spool_);
    put_columns(corners_, 3 * faces(), corner_spool_);
    constexpr std::string_view kEnd = "\n</AppendedData>\n</VTKFile>\n";
    sink().write(kEnd.data(), kEnd.size());
  }

  /// @param shift  binary digits of a face's number within its base face
  void put_cell_data(unsigned shift) {
    const std::uint64_t within = (std::uint64_t{1} << shift) - 1;
    put<std::uint64_t>(faces() * sizeof(std::uint32_t));
    for (std::uint64_t f = 0; f < faces(); ++f) put(static_cast<std::uint32_t>(f >> shift));
    put<std::uint64_t>(faces());
    for (std::uint64_t f = 0; f < faces(); ++f) put(static_cast<std::uint8_t>(*level_));
    put<std::uint64_t>(faces() * sizeof(std::uint32_t));
    for (std::uint64_t f = 0; f < faces(); ++f) put(static_cast<std::uint32_t>(f & within));
  }

  std::optional<unsigned> level_;
  bool wide_;
  bool faces_begun_ = false;
  std::vector<VtpColumn> points_, cells_, corners_;
  std::unique_ptr<ColumnSpool> point_spool_, cell_spool_, corner_spool_;
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_vtp_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   const MeshWriterOptions& options) {
  return std::make_unique<VtpWriter>(path, vertices, faces, options);
}

}  // namespace remaps
