#include "remaps/resample/attribute_sampler.h"

#include <gtest/gtest.h>

#include <vector>

#include "remaps/base/errors.h"
#include "support/temp_files.h"

namespace remaps::resample {
namespace {

class AttributeSamplerTest : public test::TempFiles {
 protected:
  /// Three vertices with a scalar 1, 10, 100, and with labels 1, 2, 3.
  AttributeLayout put(std::uint64_t copies = 0) const {
    AttributeLayout layout;
    layout.specs = {
        {"s", AttributeKind::scalar, AttributePer::vertex, {{"s", ScalarType::float64}}, false},
        {"l", AttributeKind::label, AttributePer::vertex, {{"l", ScalarType::int32}}, false}};
    layout.vertices = 3;
    layout.faces = 1;
    layout.copies = copies;
    AttributeFileWriter writer(directory() / "attributes.bin", layout);
    std::vector<std::byte> row(12);
    double scalar = 1;
    for (int label = 1; label <= 3; ++label, scalar *= 10) {
      pack_row(layout.specs, std::vector<double>{scalar, double(label)}, row);
      writer.add(AttributePer::vertex, row);
    }
    writer.seal();
    return layout;
  }
  /// Looks points up in one triangle of these vertices; (points, 2).
  std::vector<double> sample(const AttributeLayout& layout, std::vector<VertexId> vertex,
                             const std::vector<map::FacePoint>& points) const {
    AttributeFile file(directory() / "attributes.bin", layout, directory() / "copies.bin");
    MemoryBudget budget(64 << 20);
    Tile tile;
    tile.vertex_id = std::move(vertex);
    tile.position.resize(3);
    tile.triangle = {{0, 1, 2}};
    tile.face_id = {0};
    std::vector<map::TaggedPoint> tagged;
    for (const map::FacePoint& point : points) tagged.push_back({tagged.size(), point});
    VertexAttributeSampler sampler(file, layout.specs, points.size(), directory(), 1 << 16, budget);
    sampler.add(tile, tagged);
    store::RowSpool rows(directory() / "rows", 12);
    sampler.finish(rows, 1 << 16, nullptr);
    EXPECT_EQ(rows.rows(), points.size());
    std::vector<std::byte> row(12);
    std::vector<double> result;
    for (std::uint64_t i = 0; i < rows.rows(); ++i) {
      rows.read(i, row);
      std::vector<double> values(2);
      unpack_row(layout.specs, row, values);
      result.insert(result.end(), values.begin(), values.end());
    }
    return result;
  }
};

using List = std::vector<double>;

TEST_F(AttributeSamplerTest, InterpolatesScalarsAndTakesTheHeaviestLabel) {
  const AttributeLayout layout = put();
  EXPECT_EQ(
      sample(layout, {0, 1, 2}, {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0.25, 0.5}, {0, 0.5, 0}}),
      (List{1, 1, 10, 2, 100, 3, 52.75, 3, 5.5, 1}));
  EXPECT_EQ(sample(layout, {2, 0, 1}, {{0, 0.25, 0.5}}), (List{30.25, 2}));
  EXPECT_THROW(sample(layout, {0, 1, 3}, {{0, 0, 0.5}}), CorruptionError);
}

TEST_F(AttributeSamplerTest, CopiesHaveWhatTheirOriginalsHave) {
  const AttributeLayout layout = put(3);
  VertexCopiesWriter writer(directory() / "copies.bin");
  writer.add(std::vector<VertexId>{2, kNoVertex, 0});
  writer.seal();
  EXPECT_EQ(sample(layout, {0, 1, 3}, {{0, 0.25, 0.5}}), (List{52.75, 3}));
  EXPECT_EQ(sample(layout, {5, 1, 3}, {{0, 0.25, 0.5}}), (List{52.75, 3}));
  // A vertex of nothing has no weight.
  EXPECT_EQ(sample(layout, {0, 1, 4}, {{0, 0.25, 0.5}, {0, 0, 1}}), (List{5.5, 1, 0, 0}));
  EXPECT_THROW(sample(layout, {0, 1, 6}, {{0, 0, 0.5}}), CorruptionError);
}

TEST_F(AttributeSamplerTest, CopiesAreReadBackAtAllSizesAndChecked) {
  for (const std::uint64_t n : {1u, 16383u, 16384u, 16385u, 40'000u}) {
    const auto path = directory() / "copies.bin";
    VertexCopiesWriter writer(path);
    for (VertexId v = 0; v < n; ++v) writer.add(std::vector<VertexId>{(v * 7) % 100});
    writer.seal();
    VertexCopies copies(path, 100, n);
    EXPECT_EQ(copies.original(99), 99u);
    for (VertexId v = 0; v < n; v += 97) ASSERT_EQ(copies.original(100 + v), (v * 7) % 100);
    EXPECT_EQ(copies.original(100 + n - 1), ((n - 1) * 7) % 100);
    EXPECT_THROW(copies.original(100 + n), CorruptionError);
    EXPECT_THROW(VertexCopies(path, 100, n + 1), CorruptionError);
    EXPECT_THROW(VertexCopies(path, 100, n - 1), CorruptionError);
    if (n > 50) {
      EXPECT_THROW(VertexCopies(path, 50, n).original(50 + 14), CorruptionError);
    }
  }
}

TEST_F(AttributeSamplerTest, NoticesPointsThatWereLost) {
  const AttributeLayout layout = put();
  AttributeFile file(directory() / "attributes.bin", layout);
  MemoryBudget budget(64 << 20);
  VertexAttributeSampler sampler(file, layout.specs, 2, directory(), 1 << 16, budget);
  store::RowSpool rows(directory() / "rows", 12);
  EXPECT_THROW(sampler.finish(rows, 1 << 16, nullptr), CorruptionError);
}

}  // namespace
}  // namespace remaps::resample
