#include "formats/mesh_files.h"

namespace remaps {
namespace {

using Ply = MeshFiles;

constexpr std::string_view kPositions = "property float x\nproperty float y\nproperty float z\n";

std::string header(std::string_view format, std::string_view body) {
  return "ply\nformat " + std::string(format) + " 1.0\n" + std::string(body) + "end_header\n";
}

std::string tetrahedron_header(std::string_view format) {
  return header(format, "element vertex 4\n" + std::string(kPositions) +
                            "element face 4\nproperty list uchar int vertex_indices\n");
}

const std::vector<Vec3> kTetrahedronPositions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<Triangle> kTetrahedronFaces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

TEST_F(Ply, ReadsAscii) {
  const MeshContent mesh =
      read_bytes("a.ply", tetrahedron_header("ascii") +
                              "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
  EXPECT_EQ(mesh.positions, kTetrahedronPositions);
  EXPECT_EQ(mesh.triangles, kTetrahedronFaces);
  EXPECT_TRUE(mesh.positions_are_float);
}

TEST_F(Ply, ReadsAsciiWithoutLastLineEndAndWithStrayBlanks) {
  const MeshContent mesh = read_bytes(
      "a.ply", tetrahedron_header("ascii") +
                   "  0 0\t0 \n1 0 0\n\n0 1 0 0 0 1\n3 0 2 1\n3 0\n1 3\n3 1 2 3\n3 2 0 3");
  EXPECT_EQ(mesh.positions, kTetrahedronPositions);
  EXPECT_EQ(mesh.triangles, kTetrahedronFaces);
}

TEST_F(Ply, ReadsBothByteOrders) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    std::string bytes = tetrahedron_header(order == std::endian::little ? "binary_little_endian"
                                                                        : "binary_big_endian");
    for (const Vec3& p : kTetrahedronPositions) {
      for (const double c : {p.x, p.y, p.z}) append(bytes, static_cast<float>(c), order);
    }
    for (const Triangle& t : kTetrahedronFaces) {
      append(bytes, std::uint8_t{3}, order);
      for (const VertexId v : t) append(bytes, static_cast<std::int32_t>(v), order);
    }
    const MeshContent mesh = read_bytes("b.ply", bytes + "anything may follow");
    EXPECT_EQ(mesh.positions, kTetrahedronPositions);
    EXPECT_EQ(mesh.triangles, kTetrahedronFaces);
    EXPECT_TRUE(mesh.positions_are_float);
  }
}

TEST_F(Ply, SaysWherePositionsAreAnArrayInTheFile) {
  const auto array_of = [&](std::string_view format, std::string_view properties) {
    const std::string bytes =
        header(format, "element vertex 4\n" + std::string(properties)) + std::string(200, '\0');
    return open_mesh_reader(make_file("p.ply", bytes))->position_array();
  };
  const std::string start =
      header("binary_little_endian", "element vertex 4\n" + std::string(kPositions));
  const auto array = array_of("binary_little_endian", kPositions);
  ASSERT_EQ(array.has_value(), std::endian::native == std::endian::little);
  if (array) {
    EXPECT_EQ(array->path, directory() / "p.ply");
    EXPECT_EQ(array->offset, start.size());
  }
  for (const std::string_view other :
       {"property float x\nproperty float z\nproperty float y\n",
        "property double x\nproperty double y\nproperty double z\n",
        "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"}) {
    EXPECT_FALSE(array_of("binary_little_endian", other)) << other;
  }
  EXPECT_FALSE(array_of("binary_big_endian", kPositions));
  EXPECT_FALSE(array_of("ascii", kPositions));
}

TEST_F(Ply, ReadsBigEndianDoubles) {
  std::string bytes = header("binary_big_endian",
                             "element vertex 1\nproperty double x\nproperty float64 y\n"
                             "property double z\n");
  for (const double c : {0.1, -2.5, 1e-300}) append(bytes, c, std::endian::big);
  const MeshContent mesh = read_bytes("b.ply", bytes);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0.1, -2.5, 1e-300}}));
  EXPECT_FALSE(mesh.positions_are_float);
}

TEST_F(Ply, KnowsThatDoublesAreFloatsOnceRead) {
  std::string bytes = header("binary_little_endian",
                             "element vertex 1\nproperty double x\nproperty double y\n"
                             "property double z\n");
  for (const double c : {0.5, -2.5, 1e30})
    append(bytes, static_cast<double>(static_cast<float>(c)));
  EXPECT_TRUE(read_bytes("b.ply", bytes).positions_are_float);
}

TEST_F(Ply, RoundsTextOfFloatPropertiesToFloat) {
  const MeshContent mesh =
      read_bytes("a.ply", header("ascii", "element vertex 1\n" + std::string(kPositions)) +
                              "0.1 1e-60 -1e-60");
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0.1F, 0, 0}}));
  EXPECT_TRUE(mesh.positions_are_float);
}

template <class T>
void append_as(std::string& bytes, std::string_view type, double value) {
  static_cast<void>(type);
  append(bytes, static_cast<T>(value));
}

TEST_F(Ply, ReadsCoordinatesAndIndicesOfEveryType) {
  using Append = void (*)(std::string&, std::string_view, double);
  const std::pair<std::string, Append> types[] = {
      {"char", append_as<std::int8_t>},     {"int8", append_as<std::int8_t>},
      {"uchar", append_as<std::uint8_t>},   {"uint8", append_as<std::uint8_t>},
      {"short", append_as<std::int16_t>},   {"int16", append_as<std::int16_t>},
      {"ushort", append_as<std::uint16_t>}, {"uint16", append_as<std::uint16_t>},
      {"int", append_as<std::int32_t>},     {"int32", append_as<std::int32_t>},
      {"uint", append_as<std::uint32_t>},   {"uint32", append_as<std::uint32_t>},
      {"int64", append_as<std::int64_t>},   {"uint64", append_as<std::uint64_t>},
      {"float", append_as<float>},          {"float32", append_as<float>},
      {"double", append_as<double>},        {"float64", append_as<double>}};
  for (const auto& [type, append_value] : types) {
    const bool integer = type.find("float") == std::string::npos && type != "double";
    const std::string index = integer ? type : "int";
    std::string head = "element vertex 3\nproperty " + type + " x\nproperty " + type +
                       " y\nproperty " + type + " z\nelement face 1\nproperty list " + index + " " +
                       index + " vertex_index\n";
    std::string bytes = header("binary_little_endian", head);
    for (int i = 0; i < 9; ++i) append_value(bytes, type, i * 10);
    for (const int i : {3, 2, 0, 1}) {
      (integer ? append_value : Append{append_as<std::int32_t>})(bytes, index, i);
    }
    const MeshContent mesh = read_bytes("b.ply", bytes);
    EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 10, 20}, {30, 40, 50}, {60, 70, 80}})) << type;
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{2, 0, 1}})) << type;
    EXPECT_TRUE(mesh.positions_are_float) << type;
  }
}

TEST_F(Ply, SkipsOtherElementsAndPropertiesAnywhere) {
  const std::string body =
      "element camera 2\nproperty uchar id\nproperty list uchar double view\n"
      "element face 2\nproperty uchar red\nproperty list uchar float texcoord\n"
      "property list uchar ushort vertex_indices\nproperty int flags\n"
      "element material 3\nproperty float shine\n"
      "element vertex 4\nproperty uchar red\nproperty float z\nproperty list int short marks\n"
      "property float x\nproperty double quality\nproperty float y\n"
      "element edge 1\nproperty int a\n";
  std::string binary = header("binary_little_endian", body);
  for (const std::uint8_t n : {std::uint8_t{0}, std::uint8_t{2}}) {
    append(binary, std::uint8_t{7});
    append(binary, n);
    for (int i = 0; i < n; ++i) append(binary, 0.5);
  }
  const std::vector<std::vector<std::uint16_t>> faces = {{0, 1, 2}, {0, 1, 2, 3}};
  for (const auto& face : faces) {
    append(binary, std::uint8_t{255});
    append(binary, std::uint8_t{1});
    append(binary, 0.25F);
    append(binary, static_cast<std::uint8_t>(face.size()));
    for (const std::uint16_t v : face) append(binary, v);
    append(binary, std::int32_t{-1});
  }
  for (int i = 0; i < 3; ++i) append(binary, 1.0F);
  for (std::int32_t i = 0; i < 4; ++i) {
    append(binary, std::uint8_t{9});
    append(binary, 3.0F);
    append(binary, i);
    for (std::int16_t k = 0; k < i; ++k) append(binary, k);
    append(binary, static_cast<float>(i));
    append(binary, 0.125);
    append(binary, 2.0F);
  }
  append(binary, std::int32_t{0});
  const std::string ascii = header("ascii", body) +
                            "7 0\n7 2 0.5 nan\n"
                            "255 1 0.25 3 0 1 2 -1\n255 1 0.25 4 0 1 2 3 -1\n"
                            "1\n1\n1\n"
                            "9 3 0 0 0.125 2\n9 3 1 0 1 0.125 2\n9 3 2 0 1 2 0.125 2\n"
                            "9 3 3 0 1 2 3 0.125 2\n0\n";
  for (const std::string& bytes : {binary, ascii}) {
    const MeshContent mesh = read_bytes("c.ply", bytes);
    EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 2, 3}, {1, 2, 3}, {2, 2, 3}, {3, 2, 3}}));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}}));
  }
}

TEST_F(Ply, ReadsEachPassAgainInAnyOrder) {
  const auto reader = open_mesh_reader(make_file(
      "a.ply",
      tetrahedron_header("ascii") + "0 0 0 1 0 0 0 1 0 0 0 1 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3"));
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<Triangle> triangles;
    reader->read_triangles([&](std::span<const Triangle> chunk) {
      triangles.insert(triangles.end(), chunk.begin(), chunk.end());
    });
    EXPECT_EQ(triangles, kTetrahedronFaces);
    EXPECT_EQ(reader->bytes_read(), reader->bytes_total());
    std::size_t positions = 0;
    reader->read_positions([&](std::span<const Vec3> chunk) { positions += chunk.size(); });
    EXPECT_EQ(positions, 4U);
  }
}

TEST_F(Ply, ReadsABinaryFileOnce) {
  constexpr std::size_t kVertices = 200'000;
  std::string bytes =
      header("binary_little_endian", "element vertex " + std::to_string(kVertices) + "\n" +
                                         std::string(kPositions) + "element face 100000\n" +
                                         "property list uchar int vertex_indices\n");
  bytes.append(kVertices * 12, '\0');
  for (int i = 0; i < 100'000; ++i) bytes.append("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
  const auto reader = open_mesh_reader(make_file("b.ply", bytes));
  reader->read_positions([](std::span<const Vec3>) {});
  EXPECT_GE(reader->bytes_read_total(), reader->bytes_read());
  reader->read_triangles([](std::span<const Triangle>) {});
  // What the buffer held at the seam of the passes is not read again.
  EXPECT_EQ(reader->bytes_read_total(), reader->bytes_total());
}

TEST_F(Ply, FansPolygonsFromTheirFirstCorner) {
  const MeshContent mesh = read_bytes(
      "a.ply", header("ascii", "element vertex 5\n" + std::string(kPositions) +
                                   "element face 1\nproperty list uchar int vertex_index\n") +
                   "0 0 0 1 0 0 2 1 0 1 2 0 0 1 0\n5 4 0 1 2 3\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{4, 0, 1}, {4, 1, 2}, {4, 2, 3}}));
}

TEST_F(Ply, UnrollsTriangleStrips) {
  const MeshContent mesh = read_bytes(
      "a.ply", header("ascii", "element vertex 6\n" + std::string(kPositions) +
                                   "element tristrips 2\nproperty list int int vertex_indices\n") +
                   "0 0 0 1 0 0 0 1 0 1 1 0 0 2 0 1 2 0\n"
                   "8 0 1 2 3 -1 3 4 5\n"
                   // 0 1 2 | stitch 2 3 3 | 3 4 5: four triangles of the stitch have no area.
                   "8 0 1 2 2 3 3 4 5\n");
  EXPECT_EQ(mesh.triangles,
            (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {3, 4, 5}, {0, 1, 2}, {4, 3, 5}}));
}

TEST_F(Ply, KeepsDegenerateTrianglesOfFaces) {
  const MeshContent mesh = read_bytes(
      "a.ply", header("ascii", "element vertex 2\n" + std::string(kPositions) +
                                   "element face 1\nproperty list uchar int vertex_index\n") +
                   "0 0 0 1 0 0\n3 0 1 1\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 1}}));
}

TEST_F(Ply, ReadsHeadersWithAnyLineEnd) {
  const std::string unix_header =
      "ply\nformat binary_little_endian 1.0\ncomment made by hand\nobj_info num_cols 3\n"
      "element vertex 1\nproperty float x\nproperty float y  \nproperty\tfloat z\nend_header\n";
  for (const std::string_view line_end : {"\n", "\r\n", "\r"}) {
    std::string bytes;
    for (const char c : unix_header) {
      if (c == '\n') {
        bytes += line_end;
      } else {
        bytes += c;
      }
    }
    // The data begins with the bytes of both line ends.
    bytes += "\n\r\n\r";
    append(bytes, 1.0F);
    append(bytes, 2.0F);
    const MeshContent mesh = read_bytes("b.ply", bytes);
    ASSERT_EQ(mesh.positions.size(), 1U);
    EXPECT_EQ(mesh.positions[0].y, 1);
    EXPECT_EQ(mesh.positions[0].z, 2);
  }
}

TEST_F(Ply, PassesOverARemarkWithoutTheWordComment) {
  const MeshContent mesh = read_bytes("a.ply",
                                      "ply\nformat ascii 1.0\nCreated by Blender3D 247\n"
                                      "element vertex 0\n" +
                                          std::string(kPositions) + "end_header\n");
  EXPECT_TRUE(mesh.positions.empty());
  EXPECT_TRUE(mesh.triangles.empty());
}

TEST_F(Ply, ReadsPointCloudsAsMeshesWithoutTriangles) {
  const MeshContent mesh = read_bytes(
      "a.ply", header("ascii", "element vertex 1\n" + std::string(kPositions)) + "1 2 3\n");
  EXPECT_EQ(mesh.positions.size(), 1U);
  EXPECT_TRUE(mesh.triangles.empty());
}

/// Enough records for several buffers and chunks, shifted byte by byte against their borders.
TEST_F(Ply, ReadsRecordsAcrossBufferBorders) {
  constexpr std::size_t kVertices = 100'000;
  for (std::size_t shift = 0; shift < 13; ++shift) {
    const std::string remark = "comment " + std::string(shift, '-') + "\n";
    const std::string body = "element vertex " + std::to_string(kVertices) + "\n" +
                             std::string(kPositions) + "element face " + std::to_string(kVertices) +
                             "\nproperty list uchar int vertex_indices\n";
    std::string binary = header("binary_little_endian", remark + body);
    std::string ascii = header("ascii", remark + body);
    for (std::size_t i = 0; i < kVertices; ++i) {
      for (const std::size_t c : {i, i % 7, i % 11}) {
        append(binary, static_cast<float>(c));
        ascii += std::to_string(c) + ' ';
      }
    }
    for (std::size_t i = 0; i < kVertices; ++i) {
      append(binary, std::uint8_t{3});
      ascii += "3 ";
      for (const std::size_t v : {i, (i + 1) % kVertices, (i + 2) % kVertices}) {
        append(binary, static_cast<std::uint32_t>(v));
        ascii += std::to_string(v) + '\n';
      }
    }
    for (const std::string& bytes : {binary, ascii}) {
      const MeshContent mesh = read_bytes("c.ply", bytes);
      ASSERT_EQ(mesh.positions.size(), kVertices);
      ASSERT_EQ(mesh.triangles.size(), kVertices);
      for (std::size_t i = 0; i < kVertices; ++i) {
        const Vec3 expected = {static_cast<double>(i), static_cast<double>(i % 7),
                               static_cast<double>(i % 11)};
        ASSERT_EQ(mesh.positions[i], expected);
        ASSERT_EQ(mesh.triangles[i], (Triangle{i, (i + 1) % kVertices, (i + 2) % kVertices}));
      }
    }
  }
}

/// One list of several megabytes: neither a strip nor a skipped list needs to fit the buffer.
TEST_F(Ply, ReadsListsLongerThanTheBuffer) {
  constexpr std::int32_t kLength = 1'000'000;
  std::string bytes =
      header("binary_little_endian", "element vertex 3\n" + std::string(kPositions) +
                                         "property list int int marks\nelement tristrips 1\n"
                                         "property list int int vertex_indices\n");
  for (std::int32_t i = 0; i < 3; ++i) {
    for (int c = 0; c < 3; ++c) append(bytes, static_cast<float>(i));
    append(bytes, i == 1 ? kLength : 0);
    if (i == 1) bytes.append(4 * std::size_t{kLength}, 'x');
  }
  append(bytes, kLength);
  for (std::int32_t i = 0; i < kLength; ++i) append(bytes, i % 3);
  const MeshContent mesh = read_bytes("b.ply", bytes);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}));
  EXPECT_EQ(mesh.triangles.size(), std::size_t{kLength} - 2);
}

}  // namespace
}  // namespace remaps
