#include <functional>
#include <random>

#include "formats/gltf_files.h"

namespace remaps {
namespace {

using Json = nlohmann::json;

class GltfRefusal : public MeshFiles {
 protected:
  struct Case {
    std::function<void(Json&)> damage;
    std::vector<std::string_view> says;
  };

  /// Expects that the square is refused once its JSON is damaged so.
  void expect_damage_refused(const std::vector<Case>& cases) const {
    for (const Case& c : cases) {
      GltfSketch sketch = square_sketch();
      sketch.glb();
      c.damage(sketch.json);
      const std::string text = sketch.json.dump();
      try {
        read_bytes("a.glb", glb_of(text, sketch.bin));
        ADD_FAILURE() << text;
      } catch (const InputError& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find("a.glb: "), std::string::npos) << message;
        for (const std::string_view part : c.says) {
          EXPECT_NE(message.find(part), std::string::npos) << message << "\nlacks: " << part;
        }
      }
    }
  }
};

TEST_F(GltfRefusal, NamesTheValueThatDoesNotFitItsBuffer) {
  expect_damage_refused({
      {[](Json& j) { j["accessors"][0]["byteOffset"] = 4; },
       {"accessors[0]", "4 elements of 12 bytes", "byteOffset 4", "only 48 bytes"}},
      {[](Json& j) { j["accessors"][0]["byteOffset"] = 18446744073709551615U; }, {"accessors[0]"}},
      {[](Json& j) { j["accessors"][0]["count"] = 5; }, {"accessors[0]", "5 elements"}},
      {[](Json& j) { j["accessors"][0]["count"] = 18446744073709551615U; }, {"accessors[0]"}},
      {[](Json& j) { j["accessors"][1]["count"] = 7; }, {"accessors[1]", "7 elements of 2 bytes"}},
      {[](Json& j) { j["bufferViews"][0]["byteLength"] = 61; },
       {"bufferViews[0]", "61 bytes", "buffer has only 60"}},
      {[](Json& j) { j["bufferViews"][1]["byteOffset"] = 9007199254740993U; }, {"bufferViews[1]"}},
      {[](Json& j) { j["bufferViews"][0]["byteStride"] = 16; }, {"accessors[0]", "stride of 16"}},
      {[](Json& j) { j["bufferViews"][0]["byteStride"] = 8; },
       {"accessors[0].bufferView", "byteStride of 8"}},
      {[](Json& j) { j["bufferViews"][0]["byteStride"] = 0; },
       {"bufferViews[0].byteStride", "4 to 252"}},
      {[](Json& j) { j["bufferViews"][0]["byteStride"] = 4000000000U; },
       {"bufferViews[0].byteStride"}},
      {[](Json& j) { j["buffers"][0]["byteLength"] = 61; },
       {"buffers[0]", "61 bytes", "has only 60"}},
      {[](Json& j) { j["accessors"][1]["count"] = 0; }, {"accessors[1].count", "at least 1"}},
  });
}

TEST_F(GltfRefusal, NamesTheValueOfAWrongKind) {
  expect_damage_refused({
      {[](Json& j) { j["accessors"][0]["count"] = -4; }, {"accessors[0].count", "-4"}},
      {[](Json& j) { j["accessors"][0]["count"] = 4.5; }, {"accessors[0].count", "4.5"}},
      {[](Json& j) { j["accessors"][0]["count"] = 1e300; }, {"accessors[0].count"}},
      {[](Json& j) { j["accessors"][0]["count"] = "4"; }, {"accessors[0].count", "\"4\""}},
      {[](Json& j) { j["accessors"][0].erase("count"); }, {"accessors[0]", "expected count"}},
      {[](Json& j) { j["accessors"][0]["type"] = "VEC2"; }, {"accessors[0].type", "VEC3"}},
      {[](Json& j) { j["accessors"][1]["type"] = "VEC3"; }, {"accessors[1].type", "SCALAR"}},
      {[](Json& j) { j["accessors"][0]["componentType"] = 5124; },
       {"accessors[0].componentType", "5124"}},
      {[](Json& j) { j["accessors"][1]["componentType"] = 5122; },
       {"accessors[1].componentType", "unsigned"}},
      {[](Json& j) { j["accessors"][0]["normalized"] = 1; }, {"accessors[0].normalized"}},
      {[](Json& j) { j["accessors"] = Json::object(); }, {"accessors", "array"}},
      {[](Json& j) { j["accessors"][0] = 3; }, {"accessors[0]", "object"}},
      {[](Json& j) {
         j["nodes"][0]["matrix"] = {1, 2};
       },
       {"nodes[0].matrix", "16 numbers"}},
      {[](Json& j) { j["nodes"][0]["matrix"] = std::vector<int>(16, 1); },
       {"nodes[0].matrix", "last row"}},
      {[](Json& j) {
         j["nodes"][0]["scale"] = {1, "2", 3};
       },
       {"nodes[0].scale[1]", "number"}},
      {[](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 7; },
       {"meshes[0].primitives[0].mode", "7"}},
      {[](Json& j) { j["meshes"][0]["primitives"][0]["attributes"].erase("POSITION"); },
       {"meshes[0].primitives[0].attributes", "POSITION"}},
      {[](Json& j) { j["meshes"][0].erase("primitives"); }, {"meshes[0]", "primitives"}},
      {[](Json& j) { j["asset"]["version"] = "1.0"; }, {"asset.version", "1.0"}},
      {[](Json& j) { j.erase("asset"); }, {"asset"}},
      {[](Json& j) { j = Json::array(); }, {"object"}},
  });
}

TEST_F(GltfRefusal, NamesTheReferenceThatLeadsNowhere) {
  expect_damage_refused({
      {[](Json& j) { j["scene"] = 1; }, {"scene", "into 1 scenes", "found 1"}},
      {[](Json& j) { j["scenes"][0]["nodes"] = {1}; }, {"scenes[0].nodes[0]", "nodes"}},
      {[](Json& j) { j["nodes"][0]["mesh"] = 9; }, {"nodes[0].mesh", "found 9"}},
      {[](Json& j) { j["nodes"][0]["children"] = {-1}; }, {"nodes[0].children[0]", "-1"}},
      {[](Json& j) { j["meshes"][0]["primitives"][0]["indices"] = 2; },
       {"meshes[0].primitives[0].indices", "2 accessors"}},
      {[](Json& j) { j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 4; },
       {"meshes[0].primitives[0].attributes.POSITION"}},
      {[](Json& j) { j["accessors"][0]["bufferView"] = 2; }, {"accessors[0].bufferView"}},
      {[](Json& j) { j["accessors"][0].erase("bufferView"); }, {"accessors[0]", "bufferView"}},
      {[](Json& j) { j["bufferViews"][0]["buffer"] = 1; }, {"bufferViews[0].buffer"}},
      {[](Json& j) { j.erase("bufferViews"); }, {"accessors[0].bufferView", "0 bufferViews"}},
      {[](Json& j) { j["scenes"][0]["nodes"] = Json::array(); }, {"triangles"}},
      {[](Json& j) { j["meshes"][0]["primitives"] = Json::array(); }, {"triangles"}},
      {[](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 0; }, {"triangles"}},
  });
}

TEST_F(GltfRefusal, RefusesNodesThatFormNoTrees) {
  expect_damage_refused({
      {[](Json& j) { j["nodes"][0]["children"] = {0}; }, {"nodes[0].children[0]", "twice"}},
      {[](Json& j) {
         j["nodes"] = Json::parse(R"([{"children": [1]}, {"children": [2]}, {"children": [1]}])");
       },
       {"nodes[2].children[0]", "nodes[1] is reached twice"}},
      {[](Json& j) {
         j["nodes"] = Json::parse(R"([{"children": [1, 2]}, {"children": [3]}, {"children": [3]},
                                      {"mesh": 0}])");
       },
       {"nodes[3] is reached twice"}},
      {[](Json& j) {
         j["scenes"][0]["nodes"] = {0, 0};
       },
       {"scenes[0].nodes[1]", "twice"}},
  });
  // A circle that nothing leads to is not met.
  GltfSketch sketch = square_sketch();
  sketch.json["nodes"].push_back({{"children", {1}}});
  EXPECT_EQ(read_bytes("b.glb", sketch.glb()).triangles.size(), 2U);
}

TEST_F(GltfRefusal, NamesExtensionsThatItDoesNotRead) {
  expect_damage_refused({
      {[](Json& j) { j["extensionsRequired"] = {"VENDOR_shape"}; },
       {"extensionsRequired[0]", "VENDOR_shape"}},
      {[](Json& j) { j["extensionsRequired"] = {"KHR_draco_mesh_compression"}; },
       {"KHR_draco_mesh_compression", "decompress"}},
      {[](Json& j) { j["extensionsRequired"] = {"EXT_meshopt_compression"}; },
       {"EXT_meshopt_compression", "decompress"}},
      {[](Json& j) {
         j["accessors"][0].erase("bufferView");
         j["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] =
             Json::object();
       },
       {"meshes[0].primitives[0].extensions.KHR_draco_mesh_compression", "Draco"}},
      {[](Json& j) {
         j["buffers"].push_back({{"byteLength", 48}});
         j["bufferViews"][0]["buffer"] = 1;
         j["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0}};
       },
       {"bufferViews[0].extensions.EXT_meshopt_compression", "meshopt"}},
      {[](Json& j) { j["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = Json::object(); },
       {"nodes[0].extensions.EXT_mesh_gpu_instancing"}},
      {[](Json& j) { j["accessors"][0]["componentType"] = 5120; },
       {"accessors[0].componentType", "KHR_mesh_quantization"}},
  });
}

TEST_F(GltfRefusal, RefusesReplacementsOutOfOrderOrRange) {
  const auto sparse = [](std::vector<std::uint8_t> numbers, std::size_t count) {
    GltfSketch sketch;
    sketch.positions(std::vector<float>(9, 0));
    const std::string bytes(numbers.begin(), numbers.end());
    sketch.json["accessors"][0]["sparse"] = {
        {"count", count},
        {"indices", {{"bufferView", sketch.view(bytes)}, {"componentType", 5121}}},
        {"values", {{"bufferView", sketch.view(std::string(24, '\0'))}}}};
    sketch.primitive(0);
    return sketch.glb();
  };
  EXPECT_EQ(read_bytes("a.glb", sparse({0, 2}, 2)).positions.size(), 3U);
  expect_refused("a.glb", sparse({1, 1}, 2), {"accessors[0].sparse.indices", "rising", "found 1"});
  expect_refused("a.glb", sparse({2, 0}, 2), {"accessors[0].sparse.indices", "found 0 at 1"});
  expect_refused("a.glb", sparse({0, 3}, 2), {"below 3", "found 3"});
  expect_refused("a.glb", sparse({0, 1, 2}, 3), {"accessors[0].sparse.values", "3 elements"});
  expect_refused("a.glb", sparse({0, 1, 2}, 4), {"accessors[0].sparse.count"});
}

TEST_F(GltfRefusal, RefusesBadNumbersInTheData) {
  GltfSketch range;
  const std::size_t at = range.positions(kGltfSquare);
  range.primitive(at, range.indices({0, 1, 2, 0, 2, 4}));
  expect_refused(
      "a.glb", range.glb(),
      {"meshes[0].primitives[0].indices: accessors[1], element 5", "below 4", "found 4"});
}

TEST_F(GltfRefusal, RefusesDataThatIsNotThere) {
  GltfSketch sketch = square_sketch();
  expect_refused("a.gltf", sketch.gltf("absent.bin"), {"buffers[0].uri", "absent.bin", "No such"});
  make_file("short.bin", sketch.bin.substr(0, 59));
  expect_refused("a.gltf", sketch.gltf("short.bin"), {"buffers[0].uri", "60 bytes", "only 59"});
  expect_refused("a.gltf", sketch.gltf("https://example.org/a.bin"), {"buffers[0].uri", "https:"});
  expect_refused("a.gltf", sketch.gltf("/etc/passwd"), {"buffers[0].uri", "relative"});
  expect_refused("a.gltf", sketch.gltf("a%0.bin"), {"buffers[0].uri", "hexadecimal"});
  expect_refused("a.gltf", sketch.gltf("a%00.bin"), {"buffers[0].uri", "zero"});
  expect_refused("a.gltf", sketch.gltf(""), {"buffers[0].uri"});
  const std::string data = "data:application/octet-stream;base64,";
  const std::string text = base64_of(sketch.bin);
  expect_refused("a.gltf", sketch.gltf("data:text/plain,abc"), {"buffers[0].uri", "base64"});
  expect_refused("a.gltf", sketch.gltf(data + text.substr(4)), {"buffers[0].uri", "only 57"});
  expect_refused("a.gltf", sketch.gltf(data + "!" + text.substr(1)), {"byte", "expected base64"});
  expect_refused("a.gltf", sketch.gltf(data + "\\" + text.substr(1)), {"backslash"});
  // A comma that only shows once the text is understood, with what looks like a mark behind it.
  std::string hidden = sketch.gltf("data:;base64#@7");
  hidden.replace(hidden.find('#'), 1, "\\u002c");
  expect_refused("a.gltf", hidden, {"buffers[0].uri", "backslash"});
  sketch.json["buffers"][0].erase("uri");
  expect_refused("a.gltf", sketch.json.dump(), {"buffers[0]", "expected a uri"});
}

TEST_F(GltfRefusal, SaysWhereTextIsNoJson) {
  expect_refused("a.gltf", "{\"asset\": }", {"byte 10", "JSON"});
  expect_refused("a.gltf",
                 R"({"images": [{"uri": "data:a;base64,AAAAAAAAAAAAAAAAAAAA"}], "asset": })",
                 {"byte 69", "JSON"});
  expect_refused("a.gltf", "{\"asset\": {\"version\": \"2.0\"", {"JSON"});
  expect_refused("a.gltf", "{\"nodes\": " + std::string(200, '[') + std::string(200, ']') + "}",
                 {"levels"});
  expect_refused("a.gltf", "{\"nodes\": [" + std::string(9 << 20, ' ') + "]}", {"MiB of JSON"});
  expect_refused("a.gltf", "{\"asset\": {\"version\": \"\xff\"}}", {"JSON"});
}

TEST_F(GltfRefusal, ChecksTheChunksOfAGlb) {
  GltfSketch sketch = square_sketch();
  const std::string good = sketch.glb();
  EXPECT_EQ(read_bytes("a.glb", good + "more").triangles.size(), 2U);
  const auto with_word = [&](std::size_t at, std::uint32_t word) {
    std::string bytes = good;
    std::memcpy(bytes.data() + at, &word, sizeof word);
    return bytes;
  };
  expect_refused("a.glb", with_word(4, 1), {"byte 4", "version 1"});
  expect_refused("a.glb", with_word(8, 4'000'000'000), {"byte 8", "4000000000"});
  expect_refused("a.glb", with_word(8, 16), {"byte 8", "JSON"});
  expect_refused("a.glb", with_word(12, 100'000'000), {"byte 12", "100000000"});
  expect_refused("a.glb", with_word(16, 1), {"byte 16", "JSON"});
  const std::size_t bin = good.size() - sketch.bin.size() - 8;
  expect_refused("a.glb", with_word(bin, 1000), {"1000 bytes"});
  expect_refused("a.glb", with_word(bin + 4, 1), {"buffers[0]", "expected a uri"});
}

TEST_F(GltfRefusal, RefusesEveryTruncation) {
  const std::string good = square_sketch().glb();
  for (std::size_t n = 1; n < good.size(); ++n) {
    EXPECT_THROW(read_bytes("a.glb", good.substr(0, n)), InputError) << n;
  }
}

TEST_F(GltfRefusal, ReadsOrRefusesWhateverTheBytes) {
  const std::string good = square_sketch().glb();
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes = good;
    for (auto n = 1 + random() % 3; n > 0; --n) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    try {
      read_bytes("a.glb", bytes);
    } catch (const InputError&) {
    }
  }
}

/// 700 nodes with a mesh of 2000 primitives.
TEST_F(GltfRefusal, RefusesMoreInstancesThanItCanList) {
  GltfSketch sketch = square_sketch();
  Json& primitives = sketch.json["meshes"][0]["primitives"];
  for (int i = 1; i < 2000; ++i) primitives.push_back(primitives[0]);
  for (int i = 1; i < 700; ++i) {
    sketch.json["nodes"].push_back({{"mesh", 0}});
    sketch.json["scenes"][0]["nodes"].push_back(i);
  }
  expect_refused("a.glb", sketch.glb(), {"meshes[0]", "1048576"});
}

}  // namespace
}  // namespace remaps
