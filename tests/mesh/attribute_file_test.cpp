#include "remaps/mesh/attribute_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "remaps/base/errors.h"
#include "support/temp_files.h"

namespace remaps {
namespace {

using test::TempFiles;

AttributeSpec spec(const std::string& name, AttributePer per, std::vector<ScalarType> types) {
  AttributeSpec result{name, AttributeKind::scalar, per, {}, false};
  for (std::size_t i = 0; i < types.size(); ++i) {
    result.components.push_back({name + std::to_string(i), types[i]});
  }
  return result;
}

class AttributeFileTest : public TempFiles {};

TEST(Attributes, NumbersAreRoundedAndKeptInTheRangeOfTheirType) {
  const auto through = [](ScalarType type, double value) {
    std::byte bytes[8];
    store_scalar(type, value, bytes);
    return load_scalar(type, bytes);
  };
  EXPECT_EQ(through(ScalarType::uint8, 0.49), 0);
  EXPECT_EQ(through(ScalarType::uint8, 0.5), 1);
  EXPECT_EQ(through(ScalarType::uint8, 254.6), 255);
  EXPECT_EQ(through(ScalarType::uint8, 300), 255);
  EXPECT_EQ(through(ScalarType::uint8, -3), 0);
  EXPECT_EQ(through(ScalarType::uint8, std::nan("")), 0);
  EXPECT_EQ(through(ScalarType::int8, -128.4), -128);
  EXPECT_EQ(through(ScalarType::int16, -2.5), -3);
  EXPECT_EQ(through(ScalarType::int64, 1e300), 0x1p63);
  EXPECT_EQ(through(ScalarType::uint64, 1e300), 0x1p64);
  EXPECT_EQ(through(ScalarType::uint32, 4294967295.0), 4294967295.0);
  EXPECT_EQ(through(ScalarType::float32, 0.1), static_cast<double>(0.1F));
  EXPECT_EQ(through(ScalarType::float32, 1e300),
            static_cast<double>(std::numeric_limits<float>::max()));
  EXPECT_TRUE(std::isnan(through(ScalarType::float32, std::nan(""))));
  EXPECT_EQ(through(ScalarType::float64, 1e300), 1e300);
}

TEST(Attributes, NamesOfTypesKindsAndElementsAreReadBack) {
  for (int i = 0; i < 10; ++i) {
    const auto type = static_cast<ScalarType>(i);
    EXPECT_EQ(scalar_type_named(name_of(type)), type);
  }
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(attribute_kind_named(name_of(static_cast<AttributeKind>(i))),
              static_cast<AttributeKind>(i));
  }
  EXPECT_EQ(attribute_per_named("corner"), AttributePer::corner);
  EXPECT_EQ(attribute_per_named("corners"), std::nullopt);
}

TEST(Attributes, AChoiceIsAllNoneOrNames) {
  const std::vector<AttributeSpec> specs = {spec("a", AttributePer::vertex, {ScalarType::int8}),
                                            spec("b", AttributePer::face, {ScalarType::int8})};
  EXPECT_EQ(AttributeChoice().choose(specs, "f"), specs);
  EXPECT_EQ(AttributeChoice("all").choose(specs, "f"), specs);
  EXPECT_TRUE(AttributeChoice("none").choose(specs, "f").empty());
  EXPECT_TRUE(AttributeChoice("none").none());
  EXPECT_EQ(AttributeChoice("b").choose(specs, "f"), std::vector{specs[1]});
  EXPECT_EQ(AttributeChoice("b,a").choose(specs, "f"), specs);
  EXPECT_THROW(AttributeChoice("c").choose(specs, "f"), InputError);
  for (const char* text : {"", ",", "a,", ",a", "a,,b"}) {
    EXPECT_THROW(AttributeChoice{text}, InputError) << text;
  }
}

TEST_F(AttributeFileTest, GivesBackTheRowsAtAllSizes) {
  for (const std::uint64_t n : {0u, 1u, 16383u, 16384u, 16385u, 40'000u}) {
    AttributeLayout layout;
    layout.specs = {spec("v", AttributePer::vertex, {ScalarType::uint8, ScalarType::float32}),
                    spec("c", AttributePer::corner, {ScalarType::uint16}),
                    spec("f", AttributePer::face, {ScalarType::float64})};
    layout.vertices = n;
    layout.faces = n / 2;
    const auto path = directory() / "attributes.bin";
    const auto rows = [&](AttributePer per) {
      std::vector<std::byte> bytes(static_cast<std::size_t>(layout.rows(per)) *
                                   layout.row_bytes(per));
      for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::byte>(i * 31 + static_cast<std::size_t>(per));
      }
      return bytes;
    };
    EXPECT_EQ(layout.row_bytes(AttributePer::corner), 30u);
    AttributeFileWriter writer(path, layout);
    for (const AttributePer per :
         {AttributePer::vertex, AttributePer::face, AttributePer::corner}) {
      const auto bytes = rows(per);
      const std::size_t piece = layout.row_bytes(per) * 1000;
      for (std::size_t at = 0; at < bytes.size(); at += piece) {
        writer.add(per, std::span(bytes).subspan(at, std::min(piece, bytes.size() - at)));
      }
    }
    writer.seal();
    AttributeFile file(path, layout);
    for (const AttributePer per :
         {AttributePer::vertex, AttributePer::face, AttributePer::corner}) {
      const auto bytes = rows(per);
      std::vector<std::byte> out(bytes.size());
      file.read(per, 0, out);
      EXPECT_EQ(out, bytes) << n;
      if (bytes.empty()) continue;
      out.resize(layout.row_bytes(per));
      file.read(per, layout.rows(per) - 1, out);
      EXPECT_TRUE(std::equal(out.begin(), out.end(), bytes.end() - std::ssize(out)));
      EXPECT_THROW(file.read(per, layout.rows(per), out), CorruptionError);
    }
    AttributeLayout other = layout;
    other.vertices = n + 20'000;
    EXPECT_THROW(AttributeFile(path, other), CorruptionError);
  }
}

TEST_F(AttributeFileTest, ReadsSomeColumns) {
  AttributeLayout layout;
  layout.specs = {spec("a", AttributePer::corner, {ScalarType::uint8}),
                  spec("v", AttributePer::vertex, {ScalarType::uint8}),
                  spec("b", AttributePer::corner, {ScalarType::uint8, ScalarType::uint8})};
  layout.faces = 20'000;
  layout.vertices = 3;
  std::vector<std::byte> bytes(33 * layout.faces);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i % 251);
  AttributeFileWriter writer(directory() / "a", layout);
  writer.add(AttributePer::vertex, std::vector<std::byte>(3));
  writer.add(AttributePer::corner, bytes);
  writer.seal();
  AttributeFile file(directory() / "a", layout);
  AttributeColumns columns(file, AttributePer::corner, std::vector{layout.specs[2]});
  ASSERT_EQ(columns.row_bytes(), 30u);
  std::vector<std::byte> out(30 * 19'000);
  columns.read(500, out);
  for (std::size_t i = 0; i < out.size(); ++i) {
    // The vertex of each corner, and two of its three bytes.
    const std::size_t corner = 3 * 500 + i / 10, within = i % 10;
    ASSERT_EQ(out[i], bytes[11 * corner + within + (within < 8 ? 0 : 1)]) << i;
  }
  AttributeColumns none(file, AttributePer::corner, std::vector{layout.specs[1]});
  EXPECT_EQ(none.row_bytes(), 0u);
}

TEST_F(AttributeFileTest, IsNotSealedWithRowsMissing) {
  AttributeLayout layout;
  layout.specs = {spec("v", AttributePer::vertex, {ScalarType::uint8})};
  layout.vertices = 3;
  AttributeFileWriter writer(directory() / "a", layout);
  writer.add(AttributePer::vertex, std::vector<std::byte>(2));
  EXPECT_THROW(writer.seal(), CorruptionError);
}

}  // namespace
}  // namespace remaps
