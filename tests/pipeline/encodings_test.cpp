#include "formats/mesh_files.h"
#include "pipeline/welded_lists.h"
#include "remaps/pipeline/input_mesh.h"
#include "remaps/pipeline/remesh.h"
#include "support/compress.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

using test::equal_roots;
using test::expected_of;
using test::MeshLists;
using test::soup_of;

/// One mesh in many encodings.
class Encodings : public test::TempFiles {
 protected:
  Encodings() : mesh_(test::scan(BaseShape::kTorus, 2'000)) {}

  const MeshLists& mesh() const { return mesh_; }

  std::string binary_stl(std::string header) const {
    header.resize(80, ' ');
    append(header, static_cast<std::uint32_t>(mesh_.triangle.size()));
    for (const Triangle& t : mesh_.triangle) {
      header += std::string(12, '\0');
      for (const VertexId v : t) append_point<float>(header, mesh_.position[v]);
      header += "\1\2";
    }
    return header;
  }
  std::string ascii_stl() const {
    std::string text = "solid\n";
    for (const Triangle& t : mesh_.triangle) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const VertexId v : t) text += "vertex " + words(mesh_.position[v]) + "\n";
      text += "endloop\nendfacet\n";
    }
    return text + "endsolid\n";
  }
  std::string off() const {
    std::string text = "COFF\n" + std::to_string(mesh_.position.size()) + " " +
                       std::to_string(mesh_.triangle.size()) + " 0\n";
    for (const Vec3& p : mesh_.position) text += words(p) + " 255 0 0 255\n";
    for (const Triangle& t : mesh_.triangle) text += "3 " + numbers(t, 0, "") + " 0.5 0.5 0.5\n";
    return text;
  }
  enum class Obj { plain, negative, colours, normals };
  std::string obj(Obj kind, const char* line_end = "\n") const {
    std::string text = "# a mesh" + std::string(line_end) + "o it" + line_end;
    for (const Vec3& p : mesh_.position) {
      text += "v " + words(p) + (kind == Obj::colours ? " 1 0.5 0" : "") + line_end;
      if (kind == Obj::normals) text += "vn 0 0 1" + std::string(line_end);
    }
    const auto shift = static_cast<std::int64_t>(mesh_.position.size());
    for (const Triangle& t : mesh_.triangle) {
      text += "f " +
              numbers(t, kind == Obj::negative ? -shift : 1, kind == Obj::normals ? "//" : "") +
              line_end;
    }
    return text;
  }
  enum class Ply { plain, doubles_and_colours, faces_first, short_indices };
  std::string ply(std::string_view format, Ply kind, const char* line_end = "\n") const {
    const bool wide = kind == Ply::doubles_and_colours;
    const std::string type = wide ? "double" : "float";
    std::string vertex = "element vertex " + std::to_string(mesh_.position.size()) + line_end;
    for (const char* axis : {"x", "y", "z"}) vertex += "property " + type + " " + axis + line_end;
    if (wide) {
      for (const char* name : {"red", "nx"})
        vertex += std::string("property uchar ") + name + line_end;
    }
    const std::string face = "element face " + std::to_string(mesh_.triangle.size()) + line_end +
                             "property list uchar " +
                             (kind == Ply::short_indices ? "ushort" : "int") + " vertex_indices" +
                             line_end;
    std::string head =
        "ply" + std::string(line_end) + "format " + std::string(format) + " 1.0" + line_end;
    const bool faces_first = kind == Ply::faces_first;
    head += (faces_first ? face + vertex : vertex + face) + "end_header" + line_end;
    const bool text = format == "ascii";
    const std::endian order =
        format == "binary_big_endian" ? std::endian::big : std::endian::little;
    std::string vertices;
    for (const Vec3& p : mesh_.position) {
      if (text) {
        vertices += words(p) + line_end;
      } else if (wide) {
        append_point<double>(vertices, p, order);
        vertices += "\x7f\x01";
      } else {
        append_point<float>(vertices, p, order);
      }
    }
    std::string faces;
    for (const Triangle& t : mesh_.triangle) {
      if (text) {
        faces += "3 " + numbers(t, 0, "") + line_end;
        continue;
      }
      faces += '\3';
      for (const VertexId v : t) {
        kind == Ply::short_indices ? append(faces, static_cast<std::uint16_t>(v), order)
                                   : append(faces, static_cast<std::int32_t>(v), order);
      }
    }
    return head + (faces_first ? faces + vertices : vertices + faces);
  }

  MeshLists read(std::string_view bytes) {
    Progress progress;
    MemoryBudget budget(std::uint64_t{64} << 20);
    const auto path = make_file("mesh", bytes);
    std::filesystem::create_directory(directory() / "temp");
    const InputMesh input = open_input_mesh(
        path, {directory() / "temp", std::uint64_t{32} << 20, {}}, budget, progress);
    MeshLists result;
    input.reader->read_positions([&](std::span<const Vec3> chunk) {
      result.position.insert(result.position.end(), chunk.begin(), chunk.end());
    });
    input.reader->read_triangles([&](std::span<const Triangle> chunk) {
      result.triangle.insert(result.triangle.end(), chunk.begin(), chunk.end());
    });
    return result;
  }

 private:
  template <class T>
  static void append_point(std::string& bytes, const Vec3& p,
                           std::endian order = std::endian::little) {
    for (const double x : {p.x, p.y, p.z}) append(bytes, static_cast<T>(x), order);
  }
  static std::string words(const Vec3& p) {
    char text[128];
    std::snprintf(text, sizeof text, "%.17g %.17g %.17g", p.x, p.y, p.z);
    return text;
  }
  static std::string numbers(const Triangle& t, std::int64_t shift, std::string_view between) {
    std::string text;
    for (const VertexId v : t) {
      const std::string number = std::to_string(static_cast<std::int64_t>(v) + shift);
      text += (text.empty() ? "" : " ") + number;
      if (!between.empty()) text += std::string(between) + number;
    }
    return text;
  }

  MeshLists mesh_;
};

TEST_F(Encodings, GiveOneSurface) {
  const std::string le = "binary_little_endian";
  const std::string be = "binary_big_endian";
  const std::vector<std::string> files = {ply("ascii", Ply::plain),
                                          ply("ascii", Ply::plain, "\r\n"),
                                          ply(le, Ply::plain),
                                          ply(be, Ply::plain),
                                          ply(be, Ply::doubles_and_colours),
                                          ply(le, Ply::faces_first),
                                          ply("ascii", Ply::faces_first),
                                          ply(le, Ply::short_indices),
                                          obj(Obj::plain),
                                          obj(Obj::negative),
                                          obj(Obj::colours),
                                          obj(Obj::normals, "\r\n"),
                                          off()};
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (const std::string& bytes : {files[i], test::gzip(files[i]), test::zstd(files[i])}) {
      const MeshLists read_mesh = read(bytes);
      EXPECT_EQ(read_mesh.position, mesh().position) << i;
      EXPECT_EQ(read_mesh.triangle, mesh().triangle) << i;
    }
  }
  // STL numbers vertices anew.
  const MeshLists soup = soup_of(mesh());
  const MeshLists expected = expected_of(soup, equal_roots(soup));
  ASSERT_EQ(expected.position.size(), mesh().position.size());
  for (const std::string& stl : {binary_stl(""), binary_stl("solid "), ascii_stl()}) {
    for (const std::string& bytes : {stl, test::gzip(stl), test::zstd(stl)}) {
      const MeshLists read_mesh = read(bytes);
      EXPECT_EQ(read_mesh.position, expected.position);
      EXPECT_EQ(read_mesh.triangle, expected.triangle);
    }
  }
}

TEST_F(Encodings, StlIsRemeshedAsWell) {
  const auto path = make_file("in.stl", binary_stl("solid"));
  RemeshOptions options = test::remesh_options(directory(), path);
  Progress progress;
  const Report report = remesh(options, progress);
  EXPECT_EQ(report.input_vertices, mesh().position.size());
  EXPECT_EQ(report.input_faces, mesh().triangle.size());
  EXPECT_EQ(report.boundary_loops, 0U);
  EXPECT_EQ(report.repairs.welded_vertices, 3 * mesh().triangle.size() - mesh().position.size());
  EXPECT_NE(to_json(report).find("\"welded_vertices\": " +
                                 std::to_string(report.repairs.welded_vertices)),
            std::string::npos);
  EXPECT_EQ(entries_in(directory()), 3U) << "in.stl, out.ply, out.remaps";
}

}  // namespace
}  // namespace remaps::pipeline
