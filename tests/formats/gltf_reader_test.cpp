#include "formats/gltf_files.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

class GltfReader : public MeshFiles {
 protected:
  MeshContent read(GltfSketch& sketch) const { return read_bytes("a.glb", sketch.glb()); }

  static void expect_points(const MeshContent& mesh, const std::vector<Vec3>& expected) {
    ASSERT_EQ(mesh.positions.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_LT(norm(mesh.positions[i] - expected[i]), 1e-12) << i;
    }
  }
};

const std::vector<Vec3> kSquarePoints = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

TEST_F(GltfReader, ReadsEveryTypeOfIndex) {
  for (const int type : {5121, 5123, 5125}) {
    GltfSketch sketch;
    const std::size_t at = sketch.positions(kGltfSquare);
    const std::size_t indices =
        type == 5121   ? sketch.accessor<std::uint8_t>({0, 1, 2, 0, 2, 3}, type, "SCALAR")
        : type == 5123 ? sketch.accessor<std::uint16_t>({0, 1, 2, 0, 2, 3}, type, "SCALAR")
                       : sketch.accessor<std::uint32_t>({0, 1, 2, 0, 2, 3}, type, "SCALAR");
    sketch.primitive(at, indices);
    const MeshContent mesh = read(sketch);
    EXPECT_EQ(mesh.positions, kSquarePoints) << type;
    EXPECT_EQ(mesh.triangles, kGltfSquareTriangles) << type;
    EXPECT_TRUE(mesh.positions_are_float);
  }
}

TEST_F(GltfReader, IsASoupWithAnArrayOfPositions) {
  GltfSketch sketch = square_sketch();
  const auto path = make_file("a.glb", sketch.glb());
  const auto reader = open_mesh_reader(path);
  EXPECT_EQ(reader->vertex_sharing(), VertexSharing::split);
  const std::optional<PositionArray> array = reader->position_array();
  ASSERT_TRUE(array);
  EXPECT_EQ(array->path, path);
  float corner[12];
  std::memcpy(corner, bytes_of(path).data() + array->offset, sizeof corner);
  EXPECT_TRUE(std::equal(kGltfSquare.begin(), kGltfSquare.end(), corner));
  EXPECT_EQ(open_mesh_reader(make_file("a.obj", "v 0 0 0\n"))->vertex_sharing(),
            VertexSharing::shared);
}

TEST_F(GltfReader, MakesTrianglesOfStripsFansAndPlainRuns) {
  const std::vector<float> points(15, 0);
  const std::pair<int, std::vector<Triangle>> cases[] = {
      {4, {{0, 1, 2}}},  // the two corners left over make no triangle
      {5, {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}},
      {6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}}};
  for (const auto& [mode, triangles] : cases) {
    GltfSketch plain;
    plain.primitive(plain.positions(points))["mode"] = mode;
    EXPECT_EQ(read(plain).triangles, triangles) << mode;
    GltfSketch indexed;
    const std::size_t at = indexed.positions(points);
    indexed.primitive(at, indexed.indices({0, 1, 2, 3, 4}))["mode"] = mode;
    EXPECT_EQ(read(indexed).triangles, triangles) << mode;
  }
  // A strip repeats corners to turn.
  GltfSketch turning;
  const std::size_t at = turning.positions(points);
  turning.primitive(at, turning.indices({0, 1, 2, 2, 3, 3, 4, 0}))["mode"] = 5;
  EXPECT_EQ(read(turning).triangles, (std::vector<Triangle>{{0, 1, 2}, {4, 3, 0}}));
}

TEST_F(GltfReader, LabelsFacesWithPrimitivesAndMaterials) {
  GltfSketch sketch = square_sketch();
  sketch.primitive(0, sketch.indices({0, 1, 2}))["material"] = 0;
  sketch.primitive(0, sketch.indices({0, 1, 2}))["material"] = 0;
  const auto reader = open_mesh_reader(make_file("a.glb", sketch.glb()));
  const std::vector<std::string> names{"primitive", "material"};
  ASSERT_EQ(reader->face_labels(), names);
  const auto read = [&](std::size_t name) {
    std::vector<FaceLabel> labels;
    reader->read_face_labels(std::span(names).subspan(name, 1),
                             [&](std::span<const FaceLabel> part) {
                               labels.insert(labels.end(), part.begin(), part.end());
                             });
    EXPECT_EQ(labels.size(), 4u);
    EXPECT_EQ(labels[0], labels[1]);
    EXPECT_NE(labels[1], labels[2]);
    return labels;
  };
  EXPECT_NE(read(0)[2], read(0)[3]);
  EXPECT_EQ(read(1)[2], read(1)[3]);
}

TEST_F(GltfReader, PassesOverPointsAndLines) {
  GltfSketch sketch;
  const std::size_t other = sketch.positions({7, 7, 7, 8, 8, 8});
  for (const int mode : {0, 1, 2, 3}) sketch.primitive(other)["mode"] = mode;
  const std::size_t at = sketch.positions(kGltfSquare);
  sketch.primitive(at, sketch.indices({0, 1, 2, 0, 2, 3}));
  const MeshContent mesh = read(sketch);
  EXPECT_EQ(mesh.positions, kSquarePoints);
  EXPECT_EQ(mesh.triangles, kGltfSquareTriangles);
}

TEST_F(GltfReader, SendsPositionsOnceThatPrimitivesShare) {
  GltfSketch sketch;
  const std::size_t at = sketch.positions(kGltfSquare);
  sketch.primitive(at, sketch.indices({0, 1, 2}));
  sketch.primitive(sketch.positions({0, 0, 5, 1, 0, 5, 1, 1, 5}));
  sketch.primitive(at, sketch.indices({0, 2, 3}));
  const MeshContent mesh = read(sketch);
  EXPECT_EQ(mesh.positions.size(), 7U);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {4, 5, 6}, {0, 2, 3}}));
}

TEST_F(GltfReader, AppliesTheTransformsAboveAMesh) {
  GltfSketch sketch;
  sketch.primitive(sketch.positions({1, 0, 0, 0, 1, 0, 0, 0, 1}));
  // Scale, then a quarter turn about z, then a shift; above it a matrix that shifts.
  sketch.json["scenes"][0]["nodes"] = {1};
  sketch.json["nodes"] = Json::parse(R"([
    {"mesh": 0, "scale": [2, 3, 4], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476],
     "translation": [10, 20, 30]},
    {"children": [0, 2], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 100, 0, 0, 1]},
    {"mesh": 0}])");
  const MeshContent mesh = read(sketch);
  expect_points(
      mesh, {{110, 22, 30}, {107, 20, 30}, {110, 20, 34}, {101, 0, 0}, {100, 1, 0}, {100, 0, 1}});
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_FALSE(mesh.positions_are_float);
  // A mirror turns triangles inside out; they are turned back.
  sketch.json["nodes"][1]["matrix"][0] = -1;
  EXPECT_EQ(read(sketch).triangles, (std::vector<Triangle>{{0, 2, 1}, {3, 5, 4}}));
}

TEST_F(GltfReader, ReadsInterleavedVertices) {
  for (const std::size_t stride : {16UL, 24UL, 252UL}) {
    constexpr std::size_t kVertices = 20'000;
    std::string bytes;
    for (std::size_t v = 0; v < kVertices; ++v) {
      append(bytes, 99.0F);
      for (const float c : {1.0F, 2.0F, 3.0F}) append(bytes, c * static_cast<float>(v));
      bytes.resize((v + 1) * stride);
    }
    GltfSketch sketch;
    const std::size_t view = sketch.view(bytes);
    sketch.json["bufferViews"][view]["byteStride"] = stride;
    sketch.json["accessors"].push_back({{"bufferView", view},
                                        {"byteOffset", 4},
                                        {"componentType", 5126},
                                        {"count", kVertices},
                                        {"type", "VEC3"}});
    sketch.primitive(0);
    const MeshContent mesh = read(sketch);
    ASSERT_EQ(mesh.positions.size(), kVertices);
    for (std::size_t v = 0; v < kVertices; ++v) {
      const auto at = static_cast<double>(v);
      ASSERT_EQ(mesh.positions[v], (Vec3{at, 2 * at, 3 * at}));
    }
    EXPECT_EQ(mesh.triangles.size(), kVertices / 3);
  }
}

TEST_F(GltfReader, PutsReplacedElementsIn) {
  constexpr std::size_t kVertices = 30'000;
  const std::size_t at = 0;
  GltfSketch sketch;
  sketch.positions(std::vector<float>(3 * kVertices, 1));
  std::string numbers, values;
  std::size_t count = 0;
  // Runs across the borders of pieces of 8192 elements and of 4096 replacements.
  const auto replaced = [](std::size_t v) { return v % 3 == 0 || (v > 8000 && v < 8400); };
  for (std::size_t v = 0; v < kVertices; ++v) {
    if (!replaced(v)) continue;
    append(numbers, static_cast<std::uint16_t>(v));
    for (int k = 0; k < 3; ++k) append(values, static_cast<float>(v));
    ++count;
  }
  sketch.json["accessors"][at]["sparse"] = {
      {"count", count},
      {"indices", {{"bufferView", sketch.view(numbers)}, {"componentType", 5123}}},
      {"values", {{"bufferView", sketch.view(values)}}}};
  sketch.primitive(at);
  const MeshContent mesh = read(sketch);
  ASSERT_EQ(mesh.positions.size(), kVertices);
  for (std::size_t v = 0; v < kVertices; ++v) {
    ASSERT_EQ(mesh.positions[v].y, replaced(v) ? static_cast<double>(v) : 1) << v;
  }
  EXPECT_FALSE(open_mesh_reader(make_file("a.glb", sketch.glb()))->position_array());
}

TEST_F(GltfReader, ReadsQuantizedPositions) {
  GltfSketch sketch;
  sketch.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  sketch.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const std::size_t at =
      sketch.accessor<std::int16_t>({-32768, -32767, 0, 32767, 16384, 1, 5, 6, 7}, 5122, "VEC3");
  sketch.primitive(at);
  MeshContent mesh = read(sketch);
  expect_points(mesh, {{-32768, -32767, 0}, {32767, 16384, 1}, {5, 6, 7}});
  EXPECT_TRUE(mesh.positions_are_float);
  sketch.json["accessors"][at]["normalized"] = true;
  mesh = read(sketch);
  expect_points(
      mesh,
      {{-1, -1, 0}, {1, 16384 / 32767.0, 1 / 32767.0}, {5 / 32767.0, 6 / 32767.0, 7 / 32767.0}});
  EXPECT_FALSE(mesh.positions_are_float);

  GltfSketch bytes;
  bytes.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  bytes.primitive(bytes.accessor<std::uint8_t>({255, 0, 51, 1, 2, 3, 4, 5, 6}, 5121, "VEC3"));
  bytes.json["accessors"][0]["normalized"] = true;
  EXPECT_LT(norm(read(bytes).positions[0] - Vec3{1, 0, 0.2}), 1e-12);
}

TEST_F(GltfReader, ReadsDataBesideTheFileOrInIt) {
  GltfSketch sketch = square_sketch();
  make_file("my data.bin", sketch.bin + "what follows is ignored");
  std::filesystem::create_directory(directory() / "sub");
  make_file("sub/b.bin", sketch.bin);
  const std::string data = "data:application/octet-stream;base64,";
  for (const std::string& uri :
       {std::string("my%20data.bin"), std::string("my data.bin"), std::string("sub/b.bin"),
        data + base64_of(sketch.bin), data + base64_of(sketch.bin, false),
        data + base64_of(sketch.bin + "x"), "data:;base64," + base64_of(sketch.bin + "xy")}) {
    const MeshContent mesh = read_bytes("a.gltf", sketch.gltf(uri));
    EXPECT_EQ(mesh.positions, kSquarePoints) << uri;
    EXPECT_EQ(mesh.triangles, kGltfSquareTriangles) << uri;
  }
  EXPECT_EQ(read_bytes("b.gltf", "\xef\xbb\xbf \n" + sketch.gltf("sub/b.bin")).positions,
            kSquarePoints);
}

/// Text with data of 12 MB is no larger in memory than without.
TEST_F(GltfReader, LeavesDataInTheFile) {
  constexpr std::size_t kVertices = 900'001;
  std::vector<float> coordinates(3 * kVertices);
  for (std::size_t i = 0; i < coordinates.size(); ++i) coordinates[i] = static_cast<float>(i);
  GltfSketch sketch;
  sketch.primitive(sketch.positions(coordinates));
  sketch.json["images"] = {{{"uri", "data:image/png;base64," + std::string(100'000, 'A')}}};
  const MeshContent mesh = read_bytes(
      "a.gltf", sketch.gltf("data:application/gltf-buffer;base64," + base64_of(sketch.bin)));
  ASSERT_EQ(mesh.positions.size(), kVertices);
  for (std::size_t v = 0; v < kVertices; ++v) {
    ASSERT_EQ(mesh.positions[v].x, static_cast<double>(coordinates[3 * v]));
    ASSERT_EQ(mesh.positions[v].z, static_cast<double>(coordinates[3 * v + 2]));
  }
}

TEST_F(GltfReader, TakesTheFirstSceneOrAllRootsWithoutADefault) {
  GltfSketch sketch = square_sketch();
  sketch.json["nodes"] =
      Json::parse(R"([{"children": [1]}, {"mesh": 0, "translation": [0, 0, 5]}, {"mesh": 0}])");
  sketch.json["scenes"] = Json::parse(R"([{"nodes": [2]}, {"nodes": [0, 2]}, {}])");
  sketch.json["scene"] = 1;
  EXPECT_EQ(read(sketch).positions.size(), 8U);
  sketch.json.erase("scene");
  EXPECT_EQ(read(sketch).positions, kSquarePoints);
  sketch.json.erase("scenes");
  EXPECT_EQ(read(sketch).positions.size(), 8U);
  EXPECT_EQ(read(sketch).positions[0], (Vec3{0, 0, 5}));
  sketch.json.erase("nodes");
  EXPECT_EQ(read(sketch).positions, kSquarePoints);
}

TEST_F(GltfReader, IgnoresWhatTellsNoGeometry) {
  GltfSketch sketch = square_sketch();
  sketch.json["extensionsUsed"] = {"KHR_texture_transform", "VENDOR_unknown"};
  sketch.json["extensionsRequired"] = {"KHR_materials_unlit"};
  sketch.json["materials"] = {{{"name", 17}}};
  sketch.json["nodes"][0]["extras"] = {{"name", {1, 2}}};
  sketch.json["nodes"][0]["name"] = {{"no", "string"}};
  sketch.json["accessors"].push_back("nobody asks for this one");
  EXPECT_EQ(read(sketch).triangles, kGltfSquareTriangles);
  // Numbers of a writer that knows one kind only; zeros behind the JSON.
  sketch.json["accessors"][0]["count"] = 4.0;
  sketch.glb();
  std::string json = sketch.json.dump();
  while (json.size() % 4 != 3) json += ' ';
  json += '\0';
  EXPECT_EQ(read_bytes("z.glb", glb_of(json, sketch.bin)).triangles, kGltfSquareTriangles);
}

/// A hierarchy of three nodes with scales, as Blender exports it. The box was found by another
/// reader (tests/data/README.md).
TEST_F(GltfReader, ReadsWhatBlenderWrites) {
  const MeshContent mesh = read_mesh(std::filesystem::path(REMAPS_TEST_DATA) / "nested.glb");
  EXPECT_EQ(mesh.positions.size(), 72U);
  EXPECT_EQ(mesh.triangles.size(), 36U);
  Box3 box;
  for (const Vec3& p : mesh.positions) box.add(p);
  EXPECT_LT(norm(box.low - Vec3{-1.16701332, -2.33659525, -0.269381493}), 1e-6);
  EXPECT_LT(norm(box.high - Vec3{0.269381475, 0.999999937, 0.269381493}), 1e-6);
}

}  // namespace
}  // namespace remaps
