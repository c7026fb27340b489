#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "formats/gltf_files.h"
#include "formats/mesh_files.h"

/// Vertices with coordinates that are not finite are read, whatever the format, as NaN.
namespace remaps {
namespace {

using Nonfinite = MeshFiles;

/// What programs write, and numbers that no float is near.
const std::vector<std::string> kWritten = {
    "nan",     "NaN",     "-nan",    "nan(ind)", "inf",     "-Infinity", "+inf",       "1.#INF",
    "-1.#IND", "1.#QNAN", "-1.#INF", "1.#SNAN",  "1.#IND0", "1.#QNAN00", "1e999",      "-1e999",
    "1e39",    "3.5e38",  "-1e308",  "+1e999",   "1.#J",    "1.#R",      "1e99999999", "INF"};

bool is_left_out(const Vec3& p) {
  return std::isnan(p.x) && std::isnan(p.y) && std::isnan(p.z);
}

/// Four vertices of a square, of which those listed are not finite, and its two triangles.
void expect_square(const MeshContent& mesh, const std::vector<std::size_t>& left_out) {
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}};
  ASSERT_EQ(mesh.positions.size(), square.size());
  for (std::size_t v = 0; v < square.size(); ++v) {
    if (std::count(left_out.begin(), left_out.end(), v) > 0) {
      EXPECT_TRUE(is_left_out(mesh.positions[v])) << v;
    } else {
      EXPECT_EQ(mesh.positions[v], square[v]);
    }
  }
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_TRUE(mesh.positions_are_float);
}

TEST_F(Nonfinite, AreReadInTextWhateverTheyAreWrittenAs) {
  for (const std::string& wild : kWritten) {
    SCOPED_TRACE(wild);
    for (const std::string type : {"float", "double"}) {
      const std::string head =
          "ply\nformat ascii 1.0\nelement vertex 4\nproperty uchar q\n"
          "property " +
          type + " x\nproperty " + type + " y\nproperty " + type +
          " z\nelement face 2\n"
          "property list uchar int vertex_indices\nend_header\n";
      expect_square(read_bytes("a.ply", head + "7 0 0 0\n7 1 " + wild + " 0\n7 1 1 0\n7 0.1 1 " +
                                            wild + "\n3 0 1 2\n3 0 2 3\n"),
                    {1, 3});
    }
    expect_square(read_bytes("a.obj", "v 0 0 0\nv " + wild + " 0.1 0\nv 1 1 0\nv 0 1 " + wild +
                                          "\nf 1 2 3\nf 1 3 4\n"),
                  {1, 3});
    expect_square(read_bytes("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 " + wild +
                                          "\\\n 0.5 0.3 0.3 0.3\nf 1 2 3\nf 1 3 4\n"),
                  {3});
    expect_square(read_bytes("a.off", "OFF\n4 2 0\n0 0 0\n" + wild + " " + wild +
                                          " 0\n1 1 0\n0 1 " + wild + "\n3 0 1 2\n3 0 2 3\n"),
                  {1, 3});
  }
}

TEST_F(Nonfinite, AreRefusedWhereTheyAreNoNumbers) {
  for (const std::string word :
       {"nano", "1.#", "1.#INDIA", "in", "--inf", "1e999e", "#1.IND", "0x1p2000", "1,5"}) {
    expect_refused("a.obj", "v 0 0 0\nv 1 " + word + " 0\nf 1 2 2\n", {"line 2:"});
  }
}

/// The largest float in its usual six digits is larger than it.
TEST_F(Nonfinite, BeginWhereFloatsEnd) {
  const MeshContent mesh = read_bytes("a.obj",
                                      "v 3.4028235e38 0 0\nv -3.4028235e38 0 0\n"
                                      "v 3.4028236e38 0 0\nf 1 2 3\n");
  EXPECT_FALSE(is_left_out(mesh.positions[0]));
  EXPECT_FALSE(is_left_out(mesh.positions[1]));
  EXPECT_TRUE(is_left_out(mesh.positions[2]));
  EXPECT_TRUE(std::isfinite(static_cast<float>(mesh.positions[0].x)));
}

TEST_F(Nonfinite, DoNotDisturbAttributes) {
  for (const std::string& bytes : {std::string("v 0 0 0 0.1 0.2 0.3\nv 1 1.#QNAN 0 0.4 0.5 0.6\n"
                                               "v 1e999 1 0 0.7 0.8 0.9\nf 1 2 3\n"),
                                   std::string("COFF\n3 1 0\n0 0 0 0.1 0.2 0.3\n"
                                               "1 1.#QNAN 0 0.4 0.5 0.6\n1e999 1 0 0.7 0.8 0.9\n"
                                               "3 0 1 2\n")}) {
    const auto reader = open_mesh_reader(make_file("a.mesh", bytes));
    reader->read_positions([](std::span<const Vec3>) {});
    ASSERT_EQ(reader->attributes().size(), 1U);
    std::vector<double> rows;
    reader->read_attributes(AttributePer::vertex, [&](std::span<const double> chunk) {
      rows.insert(rows.end(), chunk.begin(), chunk.end());
    });
    EXPECT_EQ(rows, (std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}));
  }
}

TEST_F(Nonfinite, TakeTheWholeFacetOfAnStl) {
  std::string binary(80, ' ');
  append(binary, std::uint32_t{3});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::string text = "solid s\n";
  for (const float wild : {1.0F, nan, -std::numeric_limits<float>::infinity()}) {
    const std::vector<float> corners = {0, 0, 0, 1, wild, 0, 1, 1, 0};
    for (int i = 0; i < 3; ++i) append(binary, nan);
    for (const float x : corners) append(binary, x);
    append(binary, std::uint16_t{0});
    text += "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 " +
            std::string(wild == 1 ? "1" : "-1.#IND") + " 0\nvertex 1 1 0\nendloop\nendfacet\n";
  }
  text += "endsolid s\n";
  for (const std::string& bytes : {binary, text}) {
    const MeshContent mesh = read_bytes("a.stl", bytes);
    ASSERT_EQ(mesh.positions.size(), 9U);
    EXPECT_EQ(mesh.positions[1], (Vec3{1, 1, 0}));
    for (std::size_t v = 0; v < 9; ++v) EXPECT_EQ(is_left_out(mesh.positions[v]), v >= 3) << v;
    EXPECT_EQ(mesh.triangles.size(), 3U);
    EXPECT_TRUE(mesh.positions_are_float);
  }
}

TEST_F(Nonfinite, AreReadInGltfBeforeAndBehindTransforms) {
  for (const float wild :
       {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    GltfSketch sketch;
    sketch.primitive(sketch.positions({0, 0, 0, 1, 0, wild, 0, 1, 0}));
    const MeshContent mesh = read_bytes("a.glb", sketch.glb());
    ASSERT_EQ(mesh.positions.size(), 3U);
    for (std::size_t v = 0; v < 3; ++v) EXPECT_EQ(is_left_out(mesh.positions[v]), v == 1);
  }
  // Finite in the file, but not behind its transform.
  GltfSketch far = square_sketch();
  far.json["nodes"][0]["scale"] = {1e308, 1e308, 1};
  far.json["nodes"][0]["children"] = {1};
  far.json["nodes"].push_back({{"mesh", 0}, {"scale", {1e308, 1, 1}}});
  for (const Vec3& p : read_bytes("a.glb", far.glb()).positions)
    EXPECT_TRUE(is_left_out(p) || p == Vec3{}) << p.x;
}

TEST_F(Nonfinite, AreFoundInTheArrayThatIsReadInPlace) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
      "y\nproperty float z\nend_header\n";
  const std::size_t head = bytes.size();
  for (const float x :
       {0.0F, 1.0F, 2.0F, 3.0F, std::numeric_limits<float>::infinity(), 5.0F, 6.0F, 7.0F, 8.0F})
    append(bytes, x);
  const auto reader = open_mesh_reader(make_file("a.ply", bytes));
  ASSERT_TRUE(reader->position_array());
  EXPECT_EQ(reader->position_array()->offset, head);
  std::vector<Vec3> positions;
  reader->read_positions([&](std::span<const Vec3> chunk) {
    positions.insert(positions.end(), chunk.begin(), chunk.end());
  });
  EXPECT_EQ(positions[0], (Vec3{0, 1, 2}));
  EXPECT_TRUE(is_left_out(positions[1]));
  EXPECT_EQ(positions[2], (Vec3{6, 7, 8}));
}

}  // namespace
}  // namespace remaps
