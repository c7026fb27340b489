#include "formats/mesh_files.h"

namespace remaps {
namespace {

using MeshReader = MeshFiles;

const std::string kVertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const std::vector<Triangle> kSquareFan = {{0, 1, 2}, {0, 2, 3}};

std::string binary_stl(std::string header, std::uint32_t triangles) {
  header.resize(80, ' ');
  append(header, triangles);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    for (int value = 0; value < 12; ++value) append(header, static_cast<float>(value * value));
    append(header, std::uint16_t{0});
  }
  return header;
}

TEST_F(MeshReader, DecidesByContentWhateverTheExtension) {
  const std::string off = "OFF\n4 1 0\n" + kVertices + "4 0 1 2 3\n";
  const std::string obj = "# by hand\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
      kVertices + "4 0 1 2 3\n";
  const std::string stl =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid\n";
  for (const char* name : {"a.off", "a.ply", "a.obj", "a.stl", "a.glb", "a", "a.txt"}) {
    EXPECT_EQ(read_bytes(name, off).triangles, kSquareFan) << name;
    EXPECT_EQ(read_bytes(name, obj).triangles, kSquareFan) << name;
    EXPECT_EQ(read_bytes(name, "wings 2\n" + obj).triangles, kSquareFan) << name;
    EXPECT_EQ(read_bytes(name, "\xef\xbb\xbf" + obj).triangles, kSquareFan) << name;
    EXPECT_EQ(read_bytes(name, "\xef\xbb\xbf" + obj.substr(10)).positions.size(), 4U) << name;
    EXPECT_EQ(read_bytes(name, "\xef\xbb\xbf" + off).triangles, kSquareFan) << name;
    EXPECT_EQ(read_bytes(name, ply).triangles, kSquareFan) << name;
    EXPECT_EQ(read_bytes(name, stl).triangles.size(), 1U) << name;
    EXPECT_EQ(read_bytes(name, "\xef\xbb\xbf" + stl).triangles.size(), 1U) << name;
    for (const char* header : {"", "solid a", "solid facet normal 0 0 1"}) {
      EXPECT_EQ(read_bytes(name, binary_stl(header, 3)).triangles.size(), 3U) << name << header;
      EXPECT_EQ(read_bytes(name, binary_stl(header, 3) + "more").triangles.size(), 3U)
          << name << header;
    }
  }
}

TEST_F(MeshReader, AsksTheExtensionWhereTheContentHasNoMark) {
  EXPECT_EQ(read_bytes("a.off", "4 1 0\n" + kVertices + "4 0 1 2 3\n").triangles, kSquareFan);
  expect_refused("a.ply", "once upon a time", {"'ply'"});
  expect_refused("a.obj", "once upon a time", {"no vertex"});
  expect_refused("a.off", "once upon a time", {"expected OFF", "'once'"});
  expect_refused("a.stl", "once upon a time", {"'solid'", "'once'"});
  expect_refused("a.stl", std::string(40, '\0'), {"header of 80 bytes"});
}

TEST_F(MeshReader, RefusesOtherFormatsByName) {
  constexpr std::string_view kFormats = "PLY, OBJ, OFF or STL";
  expect_refused("a.3mf", "PK\x03\x04....", {"3MF", kFormats});
  expect_refused("a.ply.bz2", "BZh91AY", {"bzip2", kFormats});
  expect_refused("a.vtk", "# vtk DataFile Version 3.0\n", {"VTK", kFormats});
  expect_refused("a.txt", "once upon a time there was a mesh",
                 {"'once upon a time there was a m...'", kFormats, "byte 0"});
  expect_refused("a.bin", std::string_view("\x01\x02\x00\xff", 4), {"the bytes 01 02 00 ff"});
  expect_refused("empty.obj", "", {"empty file"});
}

TEST_F(MeshReader, RefusesWhatIsNoFile) {
  EXPECT_THROW(open_mesh_reader(directory()), InputError);
  try {
    open_mesh_reader(directory() / "absent.ply");
    ADD_FAILURE();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("absent.ply"), std::string::npos);
    EXPECT_NE(message.find("No such file"), std::string::npos);
  }
}

}  // namespace
}  // namespace remaps
