#include <gtest/gtest.h>

#include <cmath>

#include "formats/gltf_files.h"
#include "remaps/base/errors.h"
#include "support/attribute_files.h"

namespace remaps {
namespace {

using test::AttributeLists;
using List = std::vector<double>;

class GltfAttributesTest : public MeshFiles {
 protected:
  AttributeLists read(GltfSketch& sketch) const {
    return test::read_attributes(make_file("a.glb", sketch.glb()));
  }
  std::string refusal(GltfSketch& sketch) const {
    try {
      read(sketch);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

/// The square with an attribute of its vertices.
template <class T>
GltfSketch square_with(const char* name, const std::vector<T>& values, int component,
                       const char* type, bool normalized = false) {
  GltfSketch sketch = square_sketch();
  const std::size_t number = sketch.accessor(values, component, type);
  if (normalized) sketch.json["accessors"][number]["normalized"] = true;
  sketch.json["meshes"][0]["primitives"][0]["attributes"][name] = number;
  return sketch;
}

TEST_F(GltfAttributesTest, ColoursKeepTheTypeOfBytesWordsAndFloats) {
  auto bytes = square_with<std::uint8_t>("COLOR_0", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, 5121,
                                         "VEC3", true);
  AttributeLists found = read(bytes);
  ASSERT_EQ(found.specs.size(), 1u);
  EXPECT_EQ(found.specs[0].kind, AttributeKind::colour);
  ASSERT_EQ(found.specs[0].components.size(), 3u);
  EXPECT_EQ(found.specs[0].components[2], (AttributeComponent{"blue", ScalarType::uint8}));
  EXPECT_EQ(found.column("colour", 0), (List{1, 4, 7, 10}));
  EXPECT_EQ(found.column("colour", 2), (List{3, 6, 9, 12}));

  auto words = square_with<std::uint16_t>(
      "COLOR_0", {65535, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}, 5123, "VEC4", true);
  found = read(words);
  EXPECT_EQ(found.specs[0].components[3], (AttributeComponent{"alpha", ScalarType::uint16}));
  EXPECT_EQ(found.column("colour", 0), (List{65535, 5, 9, 13}));
  EXPECT_EQ(found.column("colour", 3), (List{4, 8, 12, 16}));

  auto floats =
      square_with<float>("COLOR_0", {0, .25F, .5F, 1, 0, 0, 0, 1, 0, 0, 0, 1}, 5126, "VEC3");
  found = read(floats);
  EXPECT_EQ(found.specs[0].components[0].type, ScalarType::float32);
  EXPECT_EQ(found.column("colour", 1), (List{.25, 0, 1, 0}));
}

TEST_F(GltfAttributesTest, NormalsTurnAsTheInverseTransposeOfTheirNodeDoes) {
  std::vector<float> normals;
  for (int v = 0; v < 4; ++v) normals.insert(normals.end(), {1, 1, 0});
  GltfSketch sketch = square_with<float>("NORMAL", normals, 5126, "VEC3");
  sketch.json["nodes"][0]["scale"] = {2, 1, 1};
  AttributeLists found = read(sketch);
  EXPECT_NEAR(found.column("normal", 0)[3], 1 / std::sqrt(5.0), 1e-7);
  EXPECT_NEAR(found.column("normal", 1)[3], 2 / std::sqrt(5.0), 1e-7);
  // A mirror keeps what is outside there: the surface is turned back.
  sketch.json["nodes"][0]["scale"] = {-2, 1, 1};
  found = read(sketch);
  EXPECT_NEAR(found.column("normal", 0)[0], -1 / std::sqrt(5.0), 1e-7);
  EXPECT_NEAR(found.column("normal", 1)[0], 2 / std::sqrt(5.0), 1e-7);
  // Zero has no direction.
  std::fill(normals.begin(), normals.end(), 0.0F);
  GltfSketch flat = square_with<float>("NORMAL", normals, 5126, "VEC3");
  EXPECT_EQ(read(flat).column("normal", 2), (List{0, 0, 0, 0}));
}

TEST_F(GltfAttributesTest, TextureCoordinatesCountFromBelow) {
  auto floats = square_with<float>("TEXCOORD_0", {0, 0, 1, .25F, 2, 1, -1, .5F}, 5126, "VEC2");
  AttributeLists found = read(floats);
  ASSERT_EQ(found.specs.size(), 1u);
  EXPECT_EQ(found.specs[0].name, "uv");
  EXPECT_EQ(found.column("uv", 0), (List{0, 1, 2, -1}));
  EXPECT_EQ(found.column("uv", 1), (List{1, .75, 0, .5}));
  auto words = square_with<std::uint16_t>("TEXCOORD_1", {0, 65535, 0, 0, 65535, 0, 0, 0}, 5123,
                                          "VEC2", true);
  found = read(words);
  EXPECT_EQ(found.specs[0].name, "uv1");
  EXPECT_EQ(found.column("uv1", 0), (List{0, 0, 1, 0}));
  EXPECT_EQ(found.column("uv1", 1), (List{0, 1, 1, 1}));
}

TEST_F(GltfAttributesTest, PrimitivesWithDifferentAttributesHaveTheUnion) {
  GltfSketch sketch = square_with<std::uint8_t>("COLOR_0", {9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9},
                                                5121, "VEC3", true);
  const std::size_t at = sketch.positions(kGltfSquare);
  const std::size_t uv =
      sketch.accessor(std::vector<float>{.5F, .5F, .5F, .5F, .5F, .5F, .5F, .5F}, 5126, "VEC2");
  sketch.primitive(at, sketch.indices({0, 1, 2}))["attributes"]["TEXCOORD_0"] = uv;
  AttributeLists found = read(sketch);
  EXPECT_EQ(found.column("colour", 1), (List{9, 9, 9, 9, 255, 255, 255, 255}));
  EXPECT_EQ(found.column("uv", 1), (List{0, 0, 0, 0, .5, .5, .5, .5}));

  // Positions that primitives share come once, but for those who colour them otherwise.
  const std::size_t other =
      sketch.accessor(std::vector<float>{0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1}, 5126, "VEC3");
  sketch.primitive(at, sketch.indices({0, 1, 2}))["attributes"]["COLOR_0"] = other;
  found = read(sketch);
  const AttributeSpec* const colour = found.find("colour");
  ASSERT_NE(colour, nullptr);
  EXPECT_EQ(colour->components[0].type, ScalarType::float32);
  const List red = found.column("colour", 0);
  ASSERT_EQ(red.size(), 12u);
  EXPECT_NEAR(red[0], 9 / 255.0, 1e-12);
  EXPECT_EQ(red[4], 1);
  EXPECT_EQ(red[8], 0);
  EXPECT_EQ(red[11], 1);
}

TEST_F(GltfAttributesTest, WhatDoesNotFitThePositionsIsRefusedByName) {
  auto few = square_with<float>("NORMAL", {0, 0, 1, 0, 0, 1}, 5126, "VEC3");
  EXPECT_NE(refusal(few).find("accessors[2].count: expected 4"), std::string::npos) << refusal(few);
  auto flat = square_with<float>("COLOR_0", {0, 0, 1, 0}, 5126, "SCALAR");
  EXPECT_NE(refusal(flat).find("expected VEC3 or VEC4"), std::string::npos) << refusal(flat);
  auto wide = square_with<std::uint32_t>("TEXCOORD_0", {0, 0, 1, 0, 0, 0, 0, 0}, 5125, "VEC2");
  EXPECT_NE(refusal(wide).find("of at most 16 bits"), std::string::npos) << refusal(wide);
  // An array of zeros alone says nothing.
  auto none = square_with<float>("NORMAL", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 5126, "VEC3");
  none.json["accessors"][2].erase("bufferView");
  EXPECT_TRUE(read(none).specs.empty());
}

}  // namespace
}  // namespace remaps
