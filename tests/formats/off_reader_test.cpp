#include "formats/mesh_files.h"

namespace remaps {
namespace {

using Off = MeshFiles;

const std::string kVertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const std::vector<Triangle> kSquareFan = {{0, 1, 2}, {0, 2, 3}};

TEST_F(Off, ReadsCountsWhereverTheyStand) {
  for (const std::string_view header :
       {"OFF\n4 1 0\n", "OFF 4 1 0\n", "OFF 4 1\n", "OFF\n# made by hand\n\n4 1 4 # counts\n",
        "# first\nOFF\n4\n1\n", "4 1 0\n", "\n \tOFF\r\n4 1 0\r\n"}) {
    const MeshContent mesh = read_bytes("a.off", std::string(header) + kVertices + "4 0 1 2 3\n");
    EXPECT_EQ(mesh.positions.size(), 4U) << header;
    EXPECT_EQ(mesh.triangles, kSquareFan) << header;
    EXPECT_TRUE(mesh.positions_are_float);
  }
}

TEST_F(Off, IgnoresWhatFollowsPositionsAndCorners) {
  for (const std::string_view keyword : {"OFF", "COFF", "NOFF", "STOFF", "CNOFF", "STCNOFF"}) {
    const MeshContent mesh = read_bytes(
        "a.off",
        std::string(keyword) +
            "\n4 2 0\n0 0 0 255 0 0 255\n1 0 0 0.5 #red\n# between\n1 1 0 1\n\n0 1 0 1 2 3\n"
            "3 0 1 2 0.1 0.2 0.3\n\n3 0 2 3 7 # last\nand more");
    EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    EXPECT_EQ(mesh.triangles, kSquareFan);
  }
}

TEST_F(Off, ReadsFacesFirstAndAgain) {
  const auto reader = open_mesh_reader(make_file("a.off", "OFF 4 1 0\n" + kVertices + "4 0 1 2 3"));
  for (int pass = 0; pass < 2; ++pass) {
    std::size_t triangles = 0;
    reader->read_triangles([&](std::span<const Triangle> chunk) { triangles += chunk.size(); });
    EXPECT_EQ(triangles, 2U);
    std::size_t positions = 0;
    reader->read_positions([&](std::span<const Vec3> chunk) { positions += chunk.size(); });
    EXPECT_EQ(positions, 4U);
  }
}

TEST_F(Off, ReadsAnEmptyMesh) {
  const MeshContent mesh = read_bytes("a.off", "OFF\n0 0 0\n");
  EXPECT_TRUE(mesh.positions.empty());
  EXPECT_TRUE(mesh.triangles.empty());
}

TEST_F(Off, RefusesOtherVariantsByName) {
  expect_refused("a.off", "OFF BINARY\n\0\0\0\4", {"line 1:", "binary OFF is not supported"});
  expect_refused("a.off", "4OFF\n4 1 0\n", {"line 1:", "4OFF"});
  expect_refused("a.off", "nOFF\n2\n4 1 0\n", {"line 1:", "nOFF"});
  expect_refused("a.off", "ROFF\n4 1 0\n", {"line 1:", "expected OFF", "'ROFF'"});
  expect_refused("a.off", "OFF four 1 0\n", {"line 1:", "'four'"});
}

TEST_F(Off, RefusesMalformedLinesByNumber) {
  const std::string head = "OFF\n4 1 0\n";
  expect_refused("a.off", "OFF\n-4 1 0\n" + kVertices, {"line 2:"});
  expect_refused("a.off", "OFF\n4 100 0\n" + kVertices, {"100 faces", "bytes left"});
  expect_refused("a.off", "OFF\n9000000000000000000 1 0\n", {"9000000000000000000 vertices"});
  expect_refused("a.off", head + "0 0\n1 0 0 1\n1 1 0 1\n0 1 0\n3 0 1 2\n",
                 {"line 3:", "three coordinates"});
  expect_refused("a.off", head + kVertices + "3 0 1 4\n", {"line 7:", "below 4", "found 4"});
  expect_refused("a.off", head + kVertices + "3 0 1 -1\n", {"line 7:", "found -1"});
  expect_refused("a.off", head + kVertices + "2 0 1    \n", {"line 7:", "found 2"});
  expect_refused("a.off", head + kVertices + "4 0 1 2\n3\n", {"line 7:", "expected 4", "found 3"});
  expect_refused("a.off", head + kVertices + "# no faces\n", {"line 8:", "face 0 of 1"});
}

TEST_F(Off, ReadsACountRightBehindTheKeyword) {
  for (const std::string head : {"\t  OFF4 1 0 # or nah\n", "OFF4\n1 0\n", "OFF4 1\n"}) {
    const MeshContent mesh = read_bytes("a.off", head + kVertices + "4 0 1 2 3\n");
    EXPECT_EQ(mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.triangles, kSquareFan);
  }
  expect_refused("a.off", "OFFX4 1 0\n" + kVertices, {"line 1:", "'OFFX4'"});
  expect_refused("a.off", "OFF4x 1 0\n" + kVertices, {"line 1:", "'4x'"});
}

TEST_F(Off, RefusesEveryTruncation) {
  const std::string whole = "OFF\n4 1 0\n" + kVertices + "4 0 1 2 3";
  for (std::size_t size = 0; size < whole.size(); ++size) {
    expect_refused("cut.off", whole.substr(0, size));
  }
  EXPECT_EQ(read_bytes("whole.off", whole).triangles, kSquareFan);
}

}  // namespace
}  // namespace remaps
