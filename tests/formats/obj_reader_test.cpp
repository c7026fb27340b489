#include "formats/mesh_files.h"

namespace remaps {
namespace {

using Obj = MeshFiles;

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const std::vector<Triangle> kSquareFan = {{0, 1, 2}, {0, 2, 3}};

TEST_F(Obj, ReadsCornersInEveryNotation) {
  for (const std::string_view face :
       {"f 1 2 3 4\n", "f 1/1 2/2 3/3 4/4\n", "f 1//1 2//1 3//1 4//1\n",
        "f 1/1/1 2/2/1 3/3/1 4/4/1\n", "f 1// 2/ 3/1/ 4\n", "f -4 -3 -2 -1\n", "f\t1  2 3\t4 \n",
        "f 1 2 3 4 # a square\n", "f 1 2 3 4", "  f +1 2 3 4\r\n"}) {
    const MeshContent mesh = read_bytes("a.obj", kSquare + std::string(face));
    EXPECT_EQ(mesh.positions.size(), 4U) << face;
    EXPECT_EQ(mesh.triangles, kSquareFan) << face;
  }
}

TEST_F(Obj, CountsNegativeIndicesFromTheLineTheyAreOn) {
  const MeshContent mesh = read_bytes(
      "a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 6 1 0\nf -1 -2 -3\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {5, 4, 3}}));
}

TEST_F(Obj, ReadsFacesBeforeTheirVertices) {
  EXPECT_EQ(read_bytes("a.obj", "f 1 2 3 4\n" + kSquare).triangles, kSquareFan);
}

TEST_F(Obj, CountsVerticesWhenFacesAreReadFirst) {
  const auto reader = open_mesh_reader(make_file("a.obj", kSquare + "f 1 2 3 4\n"));
  std::size_t triangles = 0;
  reader->read_triangles([&](std::span<const Triangle> chunk) { triangles += chunk.size(); });
  EXPECT_EQ(triangles, 2U);
}

TEST_F(Obj, IgnoresEverythingButVerticesAndFaces) {
  const MeshContent mesh = read_bytes(
      "a.obj",
      "# C:\\models\\\nmtllib a b.mtl\no thing\nv 0 0 0 0.5 0.5 0.5\nvt 0 0\nv 1 0 0 1.0\nvn 0 0 "
      "1\n"
      "vp 1\nv 1 1 0 # corner\n\n   \ng f\nusemtl v\ns 1\nl 1 2\np 3\nfoo 1 2 3\nv 0 1 0\n"
      "f 1 2 3 4\nend");
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, kSquareFan);
}

TEST_F(Obj, JoinsLinesAtABackslash) {
  for (const std::string_view line_end : {"\n", "\r\n"}) {
    std::string bytes;
    for (const std::string_view line :
         {"v 0 \\", "0 0", "v 1 0 0", "v 1 1 0 \\", "f 9 9 9", "v 0 1 0", "# no \\", "f 1 2\\",
          "3 \\", "4", "g x \\", "f 1 2 9"}) {
      bytes += std::string(line) + std::string(line_end);
    }
    const MeshContent mesh = read_bytes("a.obj", bytes);
    EXPECT_EQ(mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.triangles, kSquareFan);
  }
  EXPECT_EQ(read_bytes("a.obj", kSquare + "f 1 2 3 4 \\").triangles, kSquareFan);
}

TEST_F(Obj, ReadsNumbersExactly) {
  const MeshContent mesh =
      read_bytes("a.obj",
                 "v 0.1 +2. -.5\nv 1e2 -1E-2 3.4028234663852886e38\n"
                 "v 9007199254740993 0.1000000000000000055511151231257827 4.9e-324\n");
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0.1, 2, -0.5},
                                               {100, -0.01, 3.4028234663852886e38},
                                               {9007199254740992, 0.1, 4.9e-324}}));
  EXPECT_FALSE(mesh.positions_are_float);
}

TEST_F(Obj, KnowsWhetherPositionsAreFloats) {
  EXPECT_TRUE(read_bytes("a.obj", "v 0.5 -1.25 3e9\n").positions_are_float);
  EXPECT_FALSE(read_bytes("a.obj", "v 0.5 -1.25 0.1\n").positions_are_float);
  EXPECT_FALSE(read_bytes("a.obj", "v 1e-60 0 0\n").positions_are_float);
}

/// The pass over the faces begins at the first one; vertices may still follow it.
TEST_F(Obj, ReadsTheFacesFromTheFirstOne) {
  std::string bytes;
  for (int i = 0; i < 300'000; ++i) bytes += "v 0 1 2\n";
  const std::uint64_t vertices = bytes.size();
  bytes += "f -1 1 -2\nv 3 4 5\nf -1 300001 2\n";
  for (const bool positions_first : {true, false}) {
    const auto reader = open_mesh_reader(make_file("a.obj", bytes));
    for (int pass = 0; pass < 2; ++pass) {
      if (positions_first) reader->read_positions([](std::span<const Vec3>) {});
      std::vector<Triangle> triangles;
      reader->read_triangles([&](std::span<const Triangle> chunk) {
        triangles.insert(triangles.end(), chunk.begin(), chunk.end());
      });
      EXPECT_EQ(triangles, (std::vector<Triangle>{{299'999, 0, 299'998}, {300'000, 300'000, 1}}));
      const std::uint64_t whole_passes = positions_first && pass == 1 ? 2 : 1;
      EXPECT_LT(reader->bytes_read_total(), whole_passes * vertices + (std::uint64_t{2} << 20));
    }
  }
}

TEST_F(Obj, RefusesMalformedLinesByNumber) {
  expect_refused("a.obj", kSquare + "f 1 2\n", {"line 5:", "at least 3 corners", "found 2"});
  expect_refused("a.obj", kSquare + "f\n", {"line 5:", "found 0"});
  expect_refused("a.obj", kSquare + "f 1 2 5\n", {"line 5:", "from 1 to 4", "found 5"});
  expect_refused("a.obj", kSquare + "f 1 2 0\n", {"line 5:", "found 0"});
  expect_refused("a.obj", "v 0 0 0\nf -1 -1 -2\n" + kSquare, {"line 2:", "found -2"});
  expect_refused("a.obj", kSquare + "f 1 2 x\n", {"line 5:", "'x'"});
  expect_refused("a.obj", kSquare + "f 1 2 3.5\n", {"line 5:", "'3.5'"});
  expect_refused("a.obj", kSquare + "f 1 2 99999999999999999999\n", {"line 5:", "range"});
  expect_refused("a.obj", "v 0 0 0\r\nv 1 0\r\n",
                 {"line 2:", "three coordinates", "found two", "need a z"});
  expect_refused("a.obj", "v 0 0 0\nv", {"line 2:", "three coordinates"});
  expect_refused("a.obj", "v 0,5 0,5 0,5\n", {"line 1:", "'0,5'"});
  expect_refused("a.obj", "v 0 1.#INFO 0\n", {"line 1:", "'1.#INFO'"});
  expect_refused("a.obj", "v 0 1e400x 0\n", {"line 1:", "'1e400x'"});
  expect_refused("a.obj", "v 0 +-1 0\n", {"line 1:", "'+-1'"});
}

TEST_F(Obj, RefusesTruncationWithinALine) {
  const std::string whole = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3";
  for (std::size_t size = 0; size < whole.size(); ++size) {
    try {
      EXPECT_TRUE(read_bytes("cut.obj", whole.substr(0, size)).triangles.empty());
    } catch (const InputError&) {
    }
  }
}

TEST_F(Obj, PassesOverIndicesOfNormalsAndTexturesThatAreNotThere) {
  const auto reader =
      open_mesh_reader(make_file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2/2/2 3/3/3\n"));
  EXPECT_TRUE(reader->attributes().empty());
}

TEST_F(Obj, RefusesFilesWithoutVertices) {
  expect_refused("a.obj", "# nothing\n", {"byte 10:", "no vertex"});
  expect_refused("a.obj", "f 1 2 3\n", {"no vertex"});
  expect_refused("a.obj", "v 0 0 0\rv 1 0 0\r", {"CR"});
}

TEST_F(Obj, ReadsLinesLongerThanTheBuffer) {
  const std::string blanks(std::size_t{3} << 20, ' ');
  std::string polygon = "f";
  for (int i = 0; i < 150'000; ++i) polygon += " 1 2 3 4";
  const MeshContent mesh =
      read_bytes("a.obj", "#" + blanks + "\nv 0" + blanks + "0 0\nv 1 0 0\nv 1 1 0" + blanks +
                              "\nv 0 1 0\n" + blanks + "f 1 2 3 4\n" + polygon);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles.size(), 2U + 600'000U - 2U);
}

}  // namespace
}  // namespace remaps
