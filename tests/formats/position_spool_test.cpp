#include "remaps/formats/position_spool.h"

#include <random>

#include "formats/mesh_files.h"

namespace remaps {
namespace {

class PositionSpoolTest : public MeshFiles {
 protected:
  static Vec3 position(std::uint64_t v) {
    return {static_cast<double>(v), -static_cast<double>(v), 0.5};
  }
  static void fill(PositionSpool& spool, std::uint64_t n, std::size_t chunk) {
    std::vector<Vec3> part;
    for (std::uint64_t v = 0; v < n; ++v) {
      part.push_back(position(v));
      if (part.size() < chunk && v + 1 < n) continue;
      spool.append(part);
      part.clear();
    }
  }
};

TEST_F(PositionSpoolTest, FindsPositionsInAnyOrder) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  // Around a block, what is written at a time, and more than the cache has.
  for (const std::uint64_t n : {1U, 63U, 64U, 65U, 16'383U, 16'384U, 16'385U, 200'000U}) {
    PositionSpool spool(directory() / "a.stl");
    fill(spool, n, 1 + random() % 20'000);
    for (int i = 0; i < 50'000; ++i) {
      const std::uint64_t v = random() % n;
      ASSERT_EQ(spool.at(v), to_float(position(v))) << v << " of " << n;
    }
    ASSERT_EQ(spool.at(n - 1), to_float(position(n - 1)));
  }
}

/// A grid of 1024 x 1024 vertices, its faces in quadtree order.
TEST_F(PositionSpoolTest, ReadsABlockAboutOnceInQuadtreeOrder) {
  constexpr std::uint64_t kSide = 1024;
  PositionSpool spool(directory() / "a.stl");
  fill(spool, kSide * kSide, 8192);
  for (std::uint64_t code = 0; code < kSide * kSide; ++code) {
    std::uint64_t x = 0, y = 0;
    for (unsigned bit = 0; bit < 10; ++bit) {
      x |= (code >> (2 * bit) & 1) << bit;
      y |= (code >> (2 * bit + 1) & 1) << bit;
    }
    for (const std::uint64_t v : {y * kSide + x, std::min(y + 1, kSide - 1) * kSide + x}) {
      ASSERT_EQ(spool.at(v), to_float(position(v)));
    }
  }
  constexpr std::uint64_t kBlocks = kSide * kSide / PositionSpool::kBlock;
  EXPECT_LE(spool.blocks_read(), kBlocks + kBlocks / 8);
}

TEST_F(PositionSpoolTest, LeavesNoFile) {
  PositionSpool spool(directory() / "a.stl");
  fill(spool, 100'000, 8192);
  EXPECT_TRUE(std::filesystem::is_empty(directory()));
  EXPECT_THROW(PositionSpool(directory() / "absent" / "a.stl"), IoError);
}

}  // namespace
}  // namespace remaps
