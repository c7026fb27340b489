#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "formats/mesh_files.h"
#include "remaps/formats/column_spool.h"
#include "remaps/formats/corner_splitter.h"
#include "remaps/formats/record_spool.h"
#include "support/attribute_files.h"

namespace remaps {
namespace {

using test::AttributeLists;
using test::MeshLists;
using List = std::vector<double>;

AttributeSpec spec_of(const std::string& name, AttributeKind kind, AttributePer per,
                      std::initializer_list<const char*> components, ScalarType type) {
  AttributeSpec spec{name, kind, per, {}, false};
  for (const char* component : components) spec.components.push_back({component, type});
  return spec;
}
AttributeSpec colour(ScalarType type, AttributePer per = AttributePer::vertex) {
  return spec_of("colour", AttributeKind::colour, per, {"red", "green", "blue"}, type);
}
AttributeSpec normal() {
  return spec_of("normal", AttributeKind::normal, AttributePer::vertex, {"nx", "ny", "nz"},
                 ScalarType::float32);
}
AttributeSpec uv(AttributePer per) {
  return spec_of("uv", AttributeKind::uv, per, {"u", "v"}, ScalarType::float32);
}
AttributeSpec label(AttributePer per) {
  return spec_of("part", AttributeKind::label, per, {"part"}, ScalarType::int32);
}

class WrittenAttributes : public MeshFiles {
 protected:
  /// A strip of squares, two triangles each.
  static MeshLists strip(std::size_t squares) {
    MeshLists mesh;
    for (std::size_t i = 0; i <= squares; ++i) {
      mesh.position.push_back({double(i), 0, 0.5});
      mesh.position.push_back({double(i), 1, 0.25});
    }
    for (std::size_t i = 0; i < squares; ++i) {
      mesh.triangle.push_back({2 * i, 2 * i + 2, 2 * i + 1});
      mesh.triangle.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
    }
    return mesh;
  }
  AttributeLists round_trip(const std::string& name, const MeshLists& mesh,
                            const std::vector<AttributeSpec>& specs,
                            const test::AttributeValues& values) const {
    write_with_attributes(mesh, specs, values, directory() / name);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory()), {}), 1);
    return test::read_attributes(directory() / name);
  }
};

TEST_F(WrittenAttributes, OffHasNormalsAndColoursAsItsKeywordSays) {
  const MeshLists mesh = strip(3);
  const auto value = [](std::size_t v, std::size_t c) {
    return c < 3 ? (c == v % 3 ? 1.0 : 0.0) : double(20 * v + c);
  };
  const AttributeLists bytes =
      round_trip("a.off", mesh, {normal(), colour(ScalarType::uint8)}, {value, {}, {}});
  EXPECT_EQ(bytes_of(directory() / "a.off").substr(0, 6), "CNOFF\n");
  ASSERT_EQ(bytes.specs.size(), 2u);
  EXPECT_EQ(bytes.find("colour")->components[0].type, ScalarType::uint8);
  EXPECT_EQ(bytes.column("colour", 1), (List{4, 24, 44, 64, 84, 104, 124, 144}));
  EXPECT_EQ(bytes.column("normal", 1), (List{0, 1, 0, 0, 1, 0, 0, 1}));
  EXPECT_EQ(test::read_lists(directory() / "a.off").triangle, mesh.triangle);
}

TEST_F(WrittenAttributes, OffColoursOfFloatsAreNeverTakenForBytes) {
  const MeshLists mesh = strip(3);
  for (const bool textured : {false, true}) {
    std::vector<AttributeSpec> specs = {colour(ScalarType::uint16)};
    if (textured) specs.push_back(uv(AttributePer::vertex));
    const AttributeLists found = round_trip(
        "a.off", mesh, specs,
        {[](std::size_t v, std::size_t c) { return c < 3 ? double(v % 2 * 65535) : double(c); },
         {},
         {}});
    EXPECT_EQ(found.find("colour")->components[0].type, ScalarType::float32);
    EXPECT_EQ(found.column("colour", 2), (List{0, 1, 0, 1, 0, 1, 0, 1}));
    if (textured) {
      EXPECT_EQ(found.column("uv", 1), List(8, 4));
    }
  }
  const AttributeLists faces =
      round_trip("a.off", mesh, {colour(ScalarType::uint8, AttributePer::face)},
                 {{}, [](std::size_t f, std::size_t c) { return double(10 * f + c); }, {}});
  EXPECT_EQ(faces.find("colour")->per, AttributePer::face);
  EXPECT_EQ(faces.column("colour", 1), (List{1, 11, 21, 31, 41, 51}));
}

TEST_F(WrittenAttributes, GlbHasColoursNormalsAndTextureCoordinatesOfVertices) {
  const MeshLists mesh = strip(3);
  const auto value = [](std::size_t v, std::size_t c) {
    // Normals of any length, or none.
    if (c < 3) return v == 5 ? 0.0 : c == v % 3 ? 2.0 : 0.0;
    return c < 6 ? double(20 * v + c) : c == 6 ? 0.125 * double(v) : 0.75;
  };
  const AttributeLists found = round_trip(
      "a.glb", mesh,
      {normal(), colour(ScalarType::uint8), uv(AttributePer::vertex), label(AttributePer::vertex)},
      {value, {}, {}});
  EXPECT_EQ(found.specs.size(), 3u);
  EXPECT_EQ(found.column("colour", 0), (List{3, 23, 43, 63, 83, 103, 123, 143}));
  EXPECT_EQ(found.find("colour")->components[0].type, ScalarType::uint8);
  EXPECT_EQ(found.column("normal", 0), (List{1, 0, 0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(found.column("normal", 2), (List{0, 0, 1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(found.column("uv", 0), (List{0, .125, .25, .375, .5, .625, .75, .875}));
  EXPECT_EQ(found.column("uv", 1), List(8, 0.75));
  const MeshLists read = test::read_lists(directory() / "a.glb");
  EXPECT_EQ(read.position, mesh.position);
  EXPECT_EQ(read.triangle, mesh.triangle);
}

/// The texture is cut between two squares, and cut to pieces in the last one.
TEST_F(WrittenAttributes, GlbSplitsVerticesAlongSeamsAndNowhereElse) {
  constexpr std::size_t kSquares = 5'000, kCut = 1'000;
  const MeshLists mesh = strip(kSquares);
  const auto corner = [&](std::size_t c, std::size_t channel) {
    const std::size_t square = c / 6;
    const Vec3& p = mesh.position[mesh.triangle[c / 3][c % 3]];
    if (square == kSquares - 1) return double(c % 6) + 10;
    const double rounding = 1e-6 * double(c % 3);
    return channel == 0 ? p.x / kSquares + (square >= kCut ? 4 : 0) + rounding : p.y;
  };
  AttributeLists found =
      round_trip("a.glb", mesh,
                 {label(AttributePer::face), colour(ScalarType::float32), uv(AttributePer::corner)},
                 {[&](std::size_t v, std::size_t) { return double(v % 2); },
                  [](std::size_t, std::size_t) { return 0.0; }, corner});
  const MeshLists read = test::read_lists(directory() / "a.glb");
  // Two at the cut. In the last square six corners with a value of their own, of which the two
  // vertices behind it take one each, once.
  EXPECT_EQ(read.position.size(), mesh.position.size() + 2 + 4);
  ASSERT_EQ(read.triangle.size(), mesh.triangle.size());
  const List u = found.column("uv", 0), v = found.column("uv", 1), red = found.column("colour");
  for (std::size_t c = 0; c < 3 * mesh.triangle.size(); ++c) {
    const VertexId at = read.triangle[c / 3][c % 3];
    const VertexId before = mesh.triangle[c / 3][c % 3];
    EXPECT_EQ(read.position[at], mesh.position[before]);
    EXPECT_NEAR(u[at], corner(c, 0), 1e-5);
    EXPECT_NEAR(v[at], corner(c, 1), 1e-5);
    EXPECT_EQ(red[at], double(before % 2));
    if (at < mesh.position.size()) {
      EXPECT_EQ(at, before);
    }
  }
}

TEST_F(WrittenAttributes, PlacesOfAFormatGoToTheFirstThatFit) {
  const std::vector<AttributeSpec> specs = {label(AttributePer::vertex), colour(ScalarType::uint8),
                                            colour(ScalarType::float32), uv(AttributePer::vertex),
                                            uv(AttributePer::corner),    uv(AttributePer::corner),
                                            label(AttributePer::face),   normal()};
  using Held = std::vector<bool>;
  EXPECT_EQ(held_attributes("a.ply", specs), (Held{1, 1, 1, 1, 1, 0, 1, 1}));
  EXPECT_EQ(held_attributes("a.vtp", specs), Held(8, true));
  EXPECT_EQ(held_attributes("a.obj", specs), (Held{0, 1, 0, 0, 1, 0, 0, 1}));
  EXPECT_EQ(held_attributes("a.off", specs), (Held{0, 1, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(held_attributes("a.glb", specs), (Held{0, 1, 0, 1, 1, 1, 0, 1}));
  EXPECT_EQ(held_attributes("a.stl", specs), Held(8, false));
}

TEST_F(WrittenAttributes, RecordsPutAsideAreFoundAgain) {
  constexpr std::uint64_t kRecords = 50'000;
  for (const std::size_t bytes : {4U, 20U, 1000U}) {
    RecordSpool spool(directory() / "a.glb", bytes);
    const auto number_of = [](std::uint64_t i) { return (i * 7919) % kRecords; };
    for (std::uint64_t i = 0; i < kRecords; i += 2) {
      const auto number = static_cast<std::uint32_t>(number_of(i));
      std::memcpy(spool.change(number), &number, sizeof number);
    }
    for (std::uint64_t i = 0; i < kRecords; ++i) {
      std::uint32_t found = 0;
      std::memcpy(&found, spool.at(number_of(i)), sizeof found);
      ASSERT_EQ(found, i % 2 == 0 ? number_of(i) : 0) << i;
    }
  }
}

TEST_F(WrittenAttributes, CornersGetACopyForEachValueInTheOrderInWhichTheyCome) {
  CornerSplitter splitter(directory() / "a.glb", 3, 2);
  const auto split = [&](std::uint64_t v, float a, float b) {
    return splitter.split(v, std::vector<float>{a, b});
  };
  EXPECT_EQ(split(1, .5F, 0), 1u);
  EXPECT_EQ(split(2, .5F, 0), 2u);
  EXPECT_EQ(split(1, .5F, 1), 3u);
  EXPECT_EQ(split(2, .25F, 0), 4u);
  EXPECT_EQ(split(1, .5F + CornerSplitter::kSame / 2, 0), 1u);
  EXPECT_EQ(split(1, .75F, 0), 5u);
  EXPECT_EQ(split(1, .5F, 1), 3u);
  EXPECT_EQ(splitter.copies(), 3u);
  std::vector<float> value(2);
  EXPECT_EQ(splitter.read(5, value), 1u);
  EXPECT_EQ(value[0], .75F);
  EXPECT_EQ(splitter.read(0, value), 0u);  // no corner
  EXPECT_EQ(value[0], 0);
}

TEST_F(WrittenAttributes, ColumnsAreTheRowsTurned) {
  std::string expected;
  {
    constexpr std::size_t kRows = 100'000;
    ColumnSpool spool(directory() / "a.vtp", kRows, {1, 3, 8});
    std::vector<std::byte> rows;
    std::string columns[3];
    for (std::size_t i = 0; i < kRows; ++i) {
      for (std::size_t k = 0; k < 12; ++k) {
        const char c = static_cast<char>(i * 31 + k * 7 + i / 256);
        rows.push_back(static_cast<std::byte>(c));
        columns[k < 1 ? 0 : k < 4 ? 1 : 2] += c;
      }
      if (i % 1000 != 999) continue;
      spool.append(rows);
      rows.clear();
    }
    ByteSink sink(directory() / "columns");
    for (const std::size_t c : {2U, 0U, 1U}) {
      spool.copy(c, sink);
      expected += columns[c];
    }
    sink.commit();
  }
  EXPECT_EQ(bytes_of(directory() / "columns"), expected);
}

}  // namespace
}  // namespace remaps
