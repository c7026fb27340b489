#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

#include "formats/mesh_files.h"
#include "support/attribute_files.h"

namespace remaps {
namespace {

using test::AttributeLists;
using test::read_attributes;
using List = std::vector<double>;

class AttributesReader : public MeshFiles {
 protected:
  AttributeLists read(std::string_view name, std::string_view bytes) const {
    return read_attributes(make_file(name, bytes));
  }
};

std::string described(const AttributeLists& lists) {
  std::string text;
  for (const AttributeSpec& spec : lists.specs) {
    text +=
        spec.name + ":" + std::string(name_of(spec.kind)) + ":" + std::string(name_of(spec.per));
    for (const AttributeComponent& c : spec.components) {
      text += " " + c.name + "=" + std::string(name_of(c.type));
    }
    text += spec.pooled ? " pooled; " : "; ";
  }
  return text;
}

TEST_F(AttributesReader, PlyKnowsThemByTheNamesOfTheirProperties) {
  const AttributeLists found = read("a.ply",
                                    "ply\nformat ascii 1.0\nelement vertex 3\nproperty uchar red\n"
                                    "property float x\nproperty uchar green\nproperty uchar blue\n"
                                    "property float y\nproperty float z\nproperty float quality\n"
                                    "property list uchar int rest\nproperty int part\n"
                                    "property double nx\nproperty double ny\nproperty double nz\n"
                                    "property float u\n"
                                    "element face 1\nproperty list uchar int vertex_indices\n"
                                    "property ushort part\nend_header\n"
                                    "1 0 2 3 0 0 0.5 2 8 9 -7 0 0 1 0.25\n"
                                    "4 1 5 6 0 0 1.5 0 8 0 1 0 0.5\n"
                                    "255 0 0 9 1 0 nan 1 3 9 1 0 0 0.75\n3 0 1 2 65535\n");
  EXPECT_EQ(described(found),
            "colour:colour:vertex red=uint8 green=uint8 blue=uint8; "
            "quality:scalar:vertex quality=float32; part:label:vertex part=int32; "
            "normal:normal:vertex nx=float64 ny=float64 nz=float64; u:scalar:vertex u=float32; "
            "face-part:label:face part=uint16; ");
  EXPECT_EQ(found.column("colour", 0), (List{1, 4, 255}));
  EXPECT_EQ(found.column("colour", 1), (List{2, 5, 0}));
  EXPECT_EQ(found.column("part"), (List{-7, 8, 9}));
  EXPECT_EQ(found.column("normal", 2), (List{1, 0, 0}));
  EXPECT_EQ(found.column("u"), (List{0.25, 0.5, 0.75}));
  EXPECT_EQ(found.column("face-part"), (List{65535}));
  EXPECT_TRUE(std::isnan(found.column("quality")[2]));
}

TEST_F(AttributesReader, PlyIsReadInBothByteOrdersWithPolygonsAndCorners) {
  for (const auto order : {std::endian::little, std::endian::big}) {
    std::string bytes =
        std::string("ply\nformat binary_") + (order == std::endian::little ? "little" : "big") +
        "_endian 1.0\nelement face 2\nproperty list uchar float texcoord\n"
        "property list uchar int vertex_index\nproperty char kind\n"
        "element vertex 5\nproperty double x\nproperty double y\nproperty double z\n"
        "property float s\nproperty float t\nend_header\n";
    const auto put_face = [&](std::vector<int> corners, std::vector<float> uv, std::int8_t kind) {
      append(bytes, static_cast<std::uint8_t>(uv.size()), order);
      for (const float x : uv) append(bytes, x, order);
      append(bytes, static_cast<std::uint8_t>(corners.size()), order);
      for (const int v : corners) append(bytes, static_cast<std::int32_t>(v), order);
      append(bytes, kind, order);
    };
    put_face({0, 1, 2, 3}, {0, 1, 2, 3, 4, 5, 6, 7}, -3);
    put_face({0, 3, 4}, {8, 9, 10, 11}, 5);
    for (int v = 0; v < 5; ++v) {
      for (int i = 0; i < 3; ++i) append(bytes, double(v * i), order);
      append(bytes, float(v) / 2, order);
      append(bytes, -float(v), order);
    }
    const AttributeLists found = read("a.ply", bytes);
    EXPECT_EQ(described(found),
              "uv:uv:vertex s=float32 t=float32; kind:label:face kind=int8; "
              "corner-uv:uv:corner u=float32 v=float32; ");
    EXPECT_EQ(found.column("uv", 0), (List{0, 0.5, 1, 1.5, 2}));
    EXPECT_EQ(found.column("kind"), (List{-3, -3, 5}));
    EXPECT_EQ(found.corner,
              (List{0, 1, 2, 3, 4, 5, /**/ 0, 1, 4, 5, 6, 7, /**/ 8, 9, 10, 11, 0, 0}));
  }
}

TEST_F(AttributesReader, PlyOfPositionsAloneHasNone) {
  const AttributeLists found = read("a.ply",
                                    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                    "property float y\nproperty float z\nend_header\n0 0 0\n");
  EXPECT_TRUE(found.specs.empty());
  EXPECT_TRUE(found.vertex.empty());
}

TEST_F(AttributesReader, PlyOfStripsHasNoneOfFaces) {
  const AttributeLists found = read(
      "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nproperty float w\nelement face 1\nproperty list uchar int vertex_indices\n"
      "property int kind\nelement tristrips 1\nproperty list int int vertex_indices\n"
      "end_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2 9\n3 0 1 2\n");
  EXPECT_EQ(described(found), "w:scalar:vertex w=float32; ");
  EXPECT_EQ(found.vertex, (List{1, 2, 3}));
}

TEST_F(AttributesReader, PlyOfAbsurdlyManyPropertiesIsReadInTime) {
  std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\n";
  std::string row = "1 2 3";
  for (int i = 0; i < 40'000; ++i) {
    header += fmt::format("property char a{}\n", i);
    row += fmt::format(" {}", i % 100);
  }
  const AttributeLists found = read("a.ply", header + "end_header\n" + row + "\n" + row + "\n");
  EXPECT_EQ(found.specs.size(), 256u);
  EXPECT_EQ(found.column("a255"), (List{55, 55}));
}

TEST_F(AttributesReader, PlyRefusesRowsThatAreCutOff) {
  const auto path =
      make_file("a.ply",
                "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float "
                "y\nproperty float z\n"
                "property float w\nproperty float q\nend_header\n0 0 0 1 2\n0 0 0 1 bad\n");
  const auto reader = open_mesh_reader(path);
  ASSERT_EQ(reader->attributes().size(), 2u);
  try {
    reader->read_attributes(AttributePer::vertex, [](std::span<const double>) {});
    ADD_FAILURE() << "was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("line 11"), std::string::npos) << error.what();
  }
}

struct Pools {
  std::vector<List> values;
  std::vector<std::vector<PoolUse>> uses;
};

Pools read_pools(IndexedMeshReader& reader) {
  Pools pools;
  const auto specs = reader.attributes();
  for (std::size_t i = 0; i < specs.size(); ++i) {
    pools.values.emplace_back();
    pools.uses.emplace_back();
    if (!specs[i].pooled) continue;
    reader.read_pool(i, [&](std::span<const double> rows) {
      pools.values[i].insert(pools.values[i].end(), rows.begin(), rows.end());
    });
    reader.read_pool_uses(i, [&](std::span<const PoolUse> uses) {
      pools.uses[i].insert(pools.uses[i].end(), uses.begin(), uses.end());
    });
  }
  return pools;
}

TEST_F(AttributesReader, ObjHasColoursBehindPositionsAndPoolsOfTheRest) {
  const auto path =
      make_file("a.obj",
                "v 0 0 0 0.5 0.25 1\nv 1 0 0 1 0 0 # red\nv 1 1 0 0 1\nv 0 1 0 0 0 1\n"
                "vt 0 0\nvt 1 0.5 0\nvt 0.25\nvn 0 0 1\nvn 1 0 0\n"
                "f 1/1/1 2/2/1 3/3/2 4/-1/-1\nf 1//2 2 -1/2\n");
  const AttributeLists found = read_attributes(path);
  EXPECT_EQ(described(found),
            "colour:colour:vertex red=float32 green=float32 blue=float32; "
            "normal:normal:vertex nx=float32 ny=float32 nz=float32 pooled; "
            "uv:uv:corner u=float32 v=float32 pooled; ");
  EXPECT_EQ(found.vertex, (List{0.5, 0.25, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1}));
  const auto reader = open_mesh_reader(path);
  const Pools pools = read_pools(*reader);
  EXPECT_EQ(pools.values[1], (List{0, 0, 1, 1, 0, 0}));
  EXPECT_EQ(pools.values[2], (List{0, 0, 1, 0.5, 0.25, 0}));
  const auto values = [](const std::vector<PoolUse>& uses) {
    std::vector<std::int64_t> list;
    for (const PoolUse& use : uses) list.push_back(static_cast<std::int64_t>(use.value));
    return list;
  };
  EXPECT_EQ(values(pools.uses[1]), (std::vector<std::int64_t>{0, 0, 1, 0, 1, 1, 1, -1, -1}));
  EXPECT_EQ(values(pools.uses[2]), (std::vector<std::int64_t>{0, 1, 2, 0, 2, 2, -1, -1, 1}));
  EXPECT_EQ(pools.uses[1][5].vertex, 3u);
  EXPECT_EQ(pools.uses[1][8].vertex, 3u);
}

TEST_F(AttributesReader, ObjRefusesNumbersThatAreInNoPool) {
  for (const std::string_view face : {"f 1/1 2/1 3/3", "f 1/1 2/-2 3/1", "f 1/1 2/x 3/1"}) {
    const auto path = make_file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n" + std::string(face));
    const auto reader = open_mesh_reader(path);
    try {
      read_pools(*reader);
      ADD_FAILURE() << face;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("line 5"), std::string::npos) << error.what();
    }
  }
}

TEST_F(AttributesReader, ObjOfPositionsAloneHasNone) {
  EXPECT_TRUE(read("b.obj", "v 0 0 0 a b c\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").specs.empty());
  EXPECT_TRUE(read("a.obj", "v 0 0 0\nv 1 0 0 1\nv 0 1 0\nf 1 2 3\n").specs.empty());
}

TEST_F(AttributesReader, OffHasWhatItsKeywordAnnounces) {
  AttributeLists found = read("a.off",
                              "STCNOFF\n3 2 0\n0 0 0 0 0 1 10 20 255 0.5 0.25\n"
                              "1 0 0 0 1 0 40 50 60 0 1\n0 1 0 1 0 0 70 80 90 1 0\n"
                              "3 0 1 2 255 0 7\n3 2 1 0 1\n");
  EXPECT_EQ(described(found),
            "normal:normal:vertex nx=float32 ny=float32 nz=float32; "
            "colour:colour:vertex red=float32 green=float32 blue=float32; "
            "uv:uv:vertex s=float32 t=float32; "
            "face-colour:colour:face red=uint8 green=uint8 blue=uint8; ");
  EXPECT_EQ(found.column("colour", 2), (List{255, 60, 90}));
  EXPECT_EQ(found.column("uv", 1), (List{0.25, 1, 0}));
  EXPECT_EQ(found.face, (List{255, 0, 7, 1, 0, 0}));
  found = read("b.off", "COFF\n1 0 0\n0 0 0 1 2 3 255\n");
  EXPECT_EQ(described(found),
            "colour:colour:vertex red=uint8 green=uint8 blue=uint8 alpha=uint8; ");
  found = read("c.off", "COFF\n1 0 0\n0 0 0 0.5 0 1\n");
  EXPECT_EQ(found.find("colour")->components[0].type, ScalarType::float32);
  found = read("e.off", "COFF\n2 0 0\n0 0 0 0.5 0 1#red\n0 0 0 +1 0 0.25 # blue\n");
  EXPECT_EQ(found.vertex, (List{0.5, 0, 1, 1, 0, 0.25}));
  EXPECT_TRUE(read("d.off", "OFF\n1 0 0\n0 0 0 1 2 3\n").specs.empty());
}

/// What is written comes back.
/// The labels of the faces as small numbers, in the order in which they come up.
List labels_of(const std::filesystem::path& path, const std::vector<std::string>& names) {
  const auto reader = open_mesh_reader(path);
  std::vector<FaceLabel> known;
  List result;
  reader->read_face_labels(names, [&](std::span<const FaceLabel> labels) {
    for (const FaceLabel label : labels) {
      EXPECT_NE(label, kNoLabel);
      const auto at = std::find(known.begin(), known.end(), label);
      result.push_back(double(at - known.begin()));
      if (at == known.end()) known.push_back(label);
    }
  });
  return result;
}

TEST_F(AttributesReader, ObjLabelsFacesWithObjectsGroupsAndMaterials) {
  const auto path = make_file("a.obj",
                              "o one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ngroup no\ns 1\nf 1 2 3\n"
                              "g a\\\n b\nusemtl C:\\red\nf 1// 2// 3// 4//\ng a b # the same\n"
                              "usemtl blue\nf 1 2 \\\n3\ng\nusemtl C:\\red\nf 3 4 1\n");
  EXPECT_EQ(open_mesh_reader(path)->face_labels(),
            (std::vector<std::string>{"object", "group", "material"}));
  EXPECT_EQ(labels_of(path, {"object"}), (List{0, 0, 0, 0, 0}));
  EXPECT_EQ(labels_of(path, {"group"}), (List{0, 1, 1, 1, 0}));
  EXPECT_EQ(labels_of(path, {"material"}), (List{0, 1, 1, 2, 1}));
  EXPECT_EQ(labels_of(path, {"group", "material"}), (List{0, 1, 1, 2, 3}));
  EXPECT_TRUE(open_mesh_reader(make_file("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"))
                  ->face_labels()
                  .empty());
}

TEST_F(AttributesReader, PlyLabelsFacesWithIntegersAndColours) {
  const auto path =
      make_file("a.ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                "property float z\nelement face 3\nproperty list uchar int vertex_indices\n"
                "property int part\nproperty float area\nproperty uchar red\n"
                "property uchar green\nproperty uchar blue\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
                "3 0 1 2 -5 1 9 9 9\n3 0 1 2 -5 2 9 9 8\n3 0 1 2 0 2 9 9 8\n");
  EXPECT_EQ(open_mesh_reader(path)->face_labels(), (std::vector<std::string>{"part", "colour"}));
  EXPECT_EQ(labels_of(path, {"part"}), (List{0, 0, 1}));
  EXPECT_EQ(labels_of(path, {"colour"}), (List{0, 1, 1}));
}

TEST_F(AttributesReader, ReadsWhatTheWriterOfPlyWrote) {
  std::vector<AttributeSpec> specs;
  for (const AttributePer per : {AttributePer::vertex, AttributePer::face}) {
    for (int type = 0; type < 10; ++type) {
      const std::string name = std::string(name_of(per)) + std::to_string(type);
      const bool label = is_integer(static_cast<ScalarType>(type));
      specs.push_back({name,
                       label ? AttributeKind::label : AttributeKind::scalar,
                       per,
                       {{name, static_cast<ScalarType>(type)}},
                       false});
    }
  }
  specs.push_back({"uv",
                   AttributeKind::uv,
                   AttributePer::corner,
                   {{"u", ScalarType::float64}, {"v", ScalarType::float64}},
                   false});
  test::MeshLists mesh;
  for (int v = 0; v < 3000; ++v) mesh.position.push_back({double(v), 0, 1});
  for (VertexId v = 2; v < 3000; ++v) mesh.triangle.push_back({v - 2, v - 1, v});
  const auto value = [](std::size_t i, std::size_t c) { return double((i * 7 + c) % 120); };
  const auto path = directory() / "a.ply";
  test::write_with_attributes(mesh, specs, {value, value, value}, path);
  const AttributeLists found = read_attributes(path);
  EXPECT_EQ(found.specs, specs);
  ASSERT_EQ(found.vertex.size(), 30'000u);
  ASSERT_EQ(found.face.size(), 29'980u);
  ASSERT_EQ(found.corner.size(), 6 * mesh.triangle.size());
  for (std::size_t i = 0; i < found.vertex.size(); ++i)
    ASSERT_EQ(found.vertex[i], value(i / 10, i % 10));
  for (std::size_t i = 0; i < found.face.size(); ++i)
    ASSERT_EQ(found.face[i], value(i / 10, i % 10));
  for (std::size_t i = 0; i < found.corner.size(); ++i)
    ASSERT_EQ(found.corner[i], value(i / 2, i % 2));
  EXPECT_EQ(read_mesh(path).triangles, mesh.triangle);
}

TEST_F(AttributesReader, TheWriterRefusesRowsThatDoNotFit) {
  const std::vector<AttributeSpec> specs = {
      {"w", AttributeKind::scalar, AttributePer::vertex, {{"w", ScalarType::float32}}, false}};
  const std::vector<Vec3> positions(2);
  const std::vector<std::byte> rows(8);
  {
    const auto writer = open_mesh_writer(directory() / "a.ply", 2, 0, {std::nullopt, specs});
    writer->write_positions(positions);
    EXPECT_THROW(writer->write_attributes(AttributePer::vertex, std::span(rows).first(4)), Error);
    EXPECT_THROW(writer->write_positions({}), Error);
    EXPECT_THROW(writer->close(), Error);
    writer->write_attributes(AttributePer::vertex, rows);
    writer->close();
  }
  const auto writer = open_mesh_writer(directory() / "b.ply", 2, 0);
  writer->write_positions(positions);
  EXPECT_THROW(writer->write_attributes(AttributePer::vertex, rows), Error);
}

}  // namespace
}  // namespace remaps
