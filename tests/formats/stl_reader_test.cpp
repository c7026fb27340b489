#include "formats/mesh_files.h"

namespace remaps {
namespace {

using Stl = MeshFiles;

const std::vector<Vec3> kTwo = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0.5}};

std::string binary(const std::vector<Vec3>& corners) {
  std::string bytes(80, '\0');
  append(bytes, static_cast<std::uint32_t>(corners.size() / 3));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i % 3 == 0) {
      for (int k = 0; k < 3; ++k) append(bytes, std::numeric_limits<float>::quiet_NaN());
    }
    for (const double x : {corners[i].x, corners[i].y, corners[i].z})
      append(bytes, static_cast<float>(x));
    if (i % 3 == 2) append(bytes, std::uint16_t{0xffff});
  }
  return bytes;
}

const std::string kAscii =
    "solid two triangles\n  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n"
    "      vertex 1 0 0\n      vertex 1 1 0\n    endloop\n  endfacet\n"
    "  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n"
    "      vertex 1 1 0\n      vertex 0 1 0.5\n    endloop\n  endfacet\nendsolid two triangles\n";

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  text.replace(text.find(what), what.size(), by);
  return text;
}

TEST_F(Stl, DeliversCornersAndTheirTriangles) {
  for (const std::string& bytes : {binary(kTwo), kAscii}) {
    const MeshContent mesh = read_bytes("a.stl", bytes);
    EXPECT_EQ(mesh.positions, kTwo);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
    EXPECT_TRUE(mesh.positions_are_float);
    EXPECT_EQ(open_mesh_reader(make_file("a.stl", bytes))->vertex_sharing(), VertexSharing::none);
  }
}

/// Chunks of 8192 positions and buffers of 1 MiB do not divide by triangles.
TEST_F(Stl, ReadsManyTriangles) {
  for (const std::size_t triangles : {0UL, 1UL, 2730UL, 2731UL, 8191UL, 8192UL, 50'000UL}) {
    std::vector<Vec3> corners;
    for (std::size_t i = 0; i < 3 * triangles; ++i)
      corners.push_back({double(i), double(i % 7), -double(i)});
    const MeshContent mesh = read_bytes("a.stl", binary(corners));
    EXPECT_EQ(mesh.positions, corners);
    ASSERT_EQ(mesh.triangles.size(), triangles);
    if (triangles > 0) {
      EXPECT_EQ(mesh.triangles.back(),
                (Triangle{3 * triangles - 3, 3 * triangles - 2, 3 * triangles - 1}));
    }
  }
}

TEST_F(Stl, ReadsTextAsItIsFound) {
  std::string upper;
  for (const char c : kAscii) upper += static_cast<char>(std::toupper(c));
  std::string crlf;
  for (const char c : kAscii) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  for (const std::string& bytes :
       {upper, crlf, replaced(kAscii, " normal 0 0 1", ""),
        replaced(kAscii, "normal 0 0 1", "normal nan -nan(ind) 1.#QNAN"),
        replaced(kAscii, "endsolid two triangles\n", "endsolid"),
        replaced(kAscii, "  facet", "endsolid\nsolid facet and other\n  facet"),
        replaced(kAscii, "0 0 1\n    outer loop", "0 0 1 outer\nloop"), "\n\n " + kAscii,
        kAscii + "solid none\nendsolid none\n\n"}) {
    const MeshContent mesh = read_bytes("a.stl", bytes);
    EXPECT_EQ(mesh.positions, kTwo) << bytes;
    EXPECT_EQ(mesh.triangles.size(), 2U);
  }
  EXPECT_TRUE(read_bytes("a.stl", "solid\nendsolid").positions.empty());
}

TEST_F(Stl, CountsFacesOfTextWhenTheyAreReadFirst) {
  const auto reader = open_mesh_reader(make_file("a.stl", kAscii));
  std::size_t triangles = 0;
  reader->read_triangles([&](std::span<const Triangle> chunk) { triangles += chunk.size(); });
  EXPECT_EQ(triangles, 2U);
}

TEST_F(Stl, RefusesMalformedData) {
  std::string lying = binary(kTwo);
  lying[82] = 1;
  expect_refused("a.stl", lying, {"byte 80:", "65538 triangles", "only 100 bytes left"});
  expect_refused("a.stl", replaced(kAscii, "1 1 0", "1 1"), {"line 6:", "three coordinates"});
  expect_refused("a.stl", replaced(kAscii, "1 1 0", "1 1,5 0"), {"line 6:", "'1,5'"});
  expect_refused("a.stl", replaced(kAscii, "endloop", "vertex 0 1 0"),
                 {"line 7:", "'endloop'", "'vertex'"});
  expect_refused("a.stl", replaced(kAscii, "endfacet", "facet"), {"line 8:", "'endfacet'"});
  expect_refused("a.stl", replaced(kAscii, "outer loop", "inner loop"), {"line 3:", "'outer'"});
  expect_refused("a.stl", kAscii + "facet", {"line 17:", "'solid'"});
}

TEST_F(Stl, RefusesEveryTruncation) {
  const std::string bytes = binary(kTwo);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    expect_refused("cut.stl", bytes.substr(0, size));
  const std::size_t end = kAscii.find("endsolid") + std::string_view("endsolid").size();
  for (std::size_t size = 0; size < end; ++size) expect_refused("cut.stl", kAscii.substr(0, size));
  for (std::size_t size = end; size <= kAscii.size(); ++size)
    EXPECT_EQ(read_bytes("whole.stl", kAscii.substr(0, size)).positions, kTwo);
}

}  // namespace
}  // namespace remaps
