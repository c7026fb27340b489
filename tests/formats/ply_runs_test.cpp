#include "remaps/formats/ply_runs.h"

#include <cmath>
#include <limits>

#include "formats/mesh_files.h"

namespace remaps {
namespace {

using PlyRuns = MeshFiles;

constexpr std::size_t kVertices = 20'000;  // some chunks of 8192

/// What surrounds the values of a record in a file.
struct Shape {
  std::string_view coordinate, index;
  std::size_t vertex_before, vertex_after, face_before, face_after;
  std::endian order;
};

std::string properties(std::size_t n, std::string_view name) {
  std::string text;
  for (std::size_t i = 0; i < n; ++i) {
    text += "property uchar " + std::string(name) + std::to_string(i) + "\n";
  }
  return text;
}

std::string header(const Shape& shape, std::size_t faces) {
  const std::string order = shape.order == std::endian::little ? "little" : "big";
  std::string text = "ply\nformat binary_" + order + "_endian 1.0\nelement vertex " +
                     std::to_string(kVertices) + "\n" + properties(shape.vertex_before, "a");
  for (const char axis : {'x', 'y', 'z'}) {
    text += "property " + std::string(shape.coordinate) + " " + axis + "\n";
  }
  return text + properties(shape.vertex_after, "b") + "element face " + std::to_string(faces) +
         "\n" + properties(shape.face_before, "c") + "property list uchar " +
         std::string(shape.index) + " vertex_indices\n" + properties(shape.face_after, "d") +
         "end_header\n";
}

void append_vertex(std::string& bytes, const Shape& shape, const Vec3& p) {
  bytes.append(shape.vertex_before, '\x03');
  for (const double c : {p.x, p.y, p.z}) {
    if (shape.coordinate == "float") {
      append(bytes, static_cast<float>(c), shape.order);
    } else {
      append(bytes, c, shape.order);
    }
  }
  bytes.append(shape.vertex_after, '\xff');
}

void append_face(std::string& bytes, const Shape& shape, const std::vector<std::int64_t>& corners) {
  bytes.append(shape.face_before, '\x03');
  append(bytes, static_cast<std::uint8_t>(corners.size()));
  for (const std::int64_t v : corners) {
    if (shape.index.ends_with("64")) {
      append(bytes, v, shape.order);
    } else {
      append(bytes, static_cast<std::int32_t>(v), shape.order);
    }
  }
  bytes.append(shape.face_after, '\x03');
}

Vec3 position(std::size_t i) {
  const auto t = static_cast<float>(i);
  return widen({t, -t / 7, 1e30F / (1 + t)});
}

std::string vertices(const Shape& shape) {
  std::string bytes;
  for (std::size_t i = 0; i < kVertices; ++i) append_vertex(bytes, shape, position(i));
  return bytes;
}

std::vector<Shape> shapes() {
  std::vector<Shape> all;
  for (const std::string_view coordinate : {"float", "double"}) {
    for (const std::string_view index : {"int", "uint", "int64", "uint64"}) {
      for (const std::endian order : {std::endian::little, std::endian::big}) {
        all.push_back({coordinate, index, 0, 0, 0, 0, order});
        all.push_back({coordinate, index, 3, 1, 1, 4, order});
      }
    }
  }
  return all;
}

/// Triangles with a quadrangle or a pentagon here and there, on both sides of borders of chunks.
TEST_F(PlyRuns, GiveWayToPolygonsAndGoOnBehindThem) {
  for (const Shape& shape : shapes()) {
    std::string bytes;
    std::vector<Triangle> expected;
    std::size_t faces = 0;
    for (std::int64_t i = 0; i + 4 < std::int64_t{kVertices}; ++i, ++faces) {
      std::vector<std::int64_t> corners = {i, i + 2, i + 1};
      if (i % 4096 == 5) corners.push_back(i + 3);
      if (i % 8192 > 8185) corners.push_back(i + 4);
      append_face(bytes, shape, corners);
      for (std::size_t k = 2; k < corners.size(); ++k) {
        expected.push_back({static_cast<VertexId>(corners[0]),
                            static_cast<VertexId>(corners[k - 1]),
                            static_cast<VertexId>(corners[k])});
      }
    }
    const MeshContent mesh = read_bytes("b.ply", header(shape, faces) + vertices(shape) + bytes);
    ASSERT_EQ(mesh.positions.size(), kVertices);
    for (std::size_t i = 0; i < kVertices; ++i) ASSERT_EQ(mesh.positions[i], position(i));
    EXPECT_TRUE(mesh.triangles == expected) << shape.index;
    EXPECT_TRUE(mesh.positions_are_float);
  }
}

/// The place in the message is that of the value, however far into a run it lies.
TEST_F(PlyRuns, NameTheByteOfWhatTheyRefuse) {
  constexpr std::int64_t kFar = 10'000;
  for (const Shape& shape : shapes()) {
    const std::size_t index_bytes = shape.index.ends_with("64") ? 8 : 4;
    const std::size_t record = shape.face_before + 1 + 3 * index_bytes + shape.face_after;
    const std::string head = header(shape, kVertices - 2) + vertices(shape);
    for (const std::int64_t wrong : {std::int64_t{kVertices}, std::int64_t{-1}}) {
      std::string bytes = head;
      for (std::int64_t i = 0; i + 2 < std::int64_t{kVertices}; ++i) {
        append_face(bytes, shape, {i, i + 1, i == kFar ? wrong : i + 2});
      }
      const std::size_t at = head.size() + kFar * record + shape.face_before + 1 + 2 * index_bytes;
      const bool unsigned_word = shape.index == "uint" && wrong < 0;
      expect_refused("b.ply", bytes,
                     {"byte " + std::to_string(at) + ":", "face 10000 of 19998",
                      "found " + (unsigned_word ? "4294967295" : std::to_string(wrong))});
    }
  }
}

TEST_F(PlyRuns, GoOnBehindVerticesThatAreNotFinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const Shape& shape : shapes()) {
    const std::size_t width = shape.coordinate == "float" ? 4 : 8;
    const std::size_t record = shape.vertex_before + 3 * width + shape.vertex_after;
    const std::string head = header(shape, 0);
    const std::vector<Vec3> expected = read_bytes("b.ply", head + vertices(shape)).positions;
    std::vector<double> wild = {std::nan(""), -std::nan(""), kInfinity, -kInfinity};
    if (width == 8) wild.insert(wild.end(), {1e39, -1e300, 0x1.ffffffp127});
    for (const double wrong : wild) {
      std::string bytes = head + vertices(shape);
      for (const std::size_t at : {0U, 1U, 8191U, 10'000U, 19'999U}) {
        std::string vertex;
        append_vertex(vertex, shape, at == 1 ? Vec3{wrong, 1, 2} : Vec3{1, wrong, 2});
        bytes.replace(head.size() + at * record, record, vertex);
      }
      const MeshContent mesh = read_bytes("b.ply", bytes);
      ASSERT_EQ(mesh.positions.size(), expected.size());
      for (std::size_t v = 0; v < expected.size(); ++v) {
        const Vec3& p = mesh.positions[v];
        if (v == 0 || v == 1 || v == 8191 || v == 10'000 || v == 19'999) {
          ASSERT_TRUE(std::isnan(p.x) && std::isnan(p.y) && std::isnan(p.z)) << v;
        } else {
          ASSERT_EQ(p, expected[v]) << v;
        }
      }
      EXPECT_TRUE(mesh.positions_are_float) << "but for those that are not finite";
    }
  }
}

TEST_F(PlyRuns, NoticeTheOneDoubleThatIsNoFloat) {
  const Shape shape{"double", "int", 0, 0, 0, 0, std::endian::little};
  const std::string head = header(shape, 0);
  std::string bytes = head + vertices(shape);
  std::string vertex;
  append_vertex(vertex, shape, {1, 0.1, 2});
  bytes.replace(head.size() + 9'000 * vertex.size(), vertex.size(), vertex);
  EXPECT_FALSE(read_bytes("b.ply", bytes).positions_are_float);
}

TEST_F(PlyRuns, AreOfNoOtherShape) {
  using enum PlyType;
  const PlyProperty x{"x", float32, {}}, y{"y", float32, {}}, z{"z", float32, {}};
  const PlyProperty wide_y{"y", float64, {}}, list{"l", int32, uint8}, other{"o", uint16, {}};
  const auto points = [](std::vector<PlyProperty> properties) {
    return PlyPointRuns::of({"vertex", 1, std::move(properties)}, false);
  };
  EXPECT_TRUE(points({x, y, z}));
  EXPECT_EQ(points({other, x, y, z, other})->record_bytes(), 16U);
  EXPECT_FALSE(points({x, y}));
  EXPECT_FALSE(points({x, z, y}));
  EXPECT_FALSE(points({x, other, y, z}));
  EXPECT_FALSE(points({x, wide_y, z}));
  EXPECT_FALSE(points({x, y, z, list}));
  EXPECT_FALSE(points({list, x, y, z}));
  EXPECT_FALSE(points({{"x", int32, {}}, {"y", int32, {}}, {"z", int32, {}}}));

  const auto corners = [&](const PlyProperty& property, bool second_list) {
    PlyElement element{"face", 1, {other, property}};
    if (second_list) element.properties.push_back(list);
    return PlyTriangleRuns::of(element, element.properties[1], false);
  };
  EXPECT_EQ(corners({"v", int32, uint8}, false)->record_bytes(), 15U);
  EXPECT_EQ(corners({"v", uint64, int8}, false)->record_bytes(), 27U);
  EXPECT_FALSE(corners({"v", int32, uint8}, true));
  EXPECT_FALSE(corners({"v", int32, uint32}, false));
  EXPECT_FALSE(corners({"v", int16, uint8}, false));
}

}  // namespace
}  // namespace remaps
