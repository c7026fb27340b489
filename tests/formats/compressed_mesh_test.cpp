#include <random>

#include "formats/mesh_files.h"
#include "remaps/formats/byte_source.h"
#include "support/compress.h"

namespace remaps {
namespace {

using Compressed = MeshFiles;

const std::string kObj = "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const std::vector<Triangle> kSquareFan = {{0, 1, 2}, {0, 2, 3}};

/// More than the buffers hold, and hard to compress.
std::string random_vertices(std::size_t n) {
  std::mt19937_64 random(4);
  std::string text;
  for (std::size_t i = 0; i < n; ++i)
    text += "v " + std::to_string(random() % 1'000'000'007) + " 0 " + std::to_string(i) + "\n";
  return text;
}

/// Vertices that are more than a buffer: their end is not seen when the header is checked.
constexpr std::size_t kMany = 100'000;

std::string ply_of(std::size_t vertices, std::size_t announced) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(announced) +
                      "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (std::size_t i = 0; i < 3 * vertices; ++i) append(bytes, static_cast<float>(i));
  return bytes;
}

TEST_F(Compressed, ReadsWhatThePlainFileHolds) {
  const std::string skippable("\x50\x2a\x4d\x18\x03\x00\x00\x00...", 11);
  const std::string half = kObj.substr(0, 20);
  const std::string rest = kObj.substr(20);
  for (const std::string& bytes :
       {test::gzip(kObj), test::zstd(kObj), test::zstd(kObj, false),
        test::gzip(half) + test::gzip("") + test::gzip(rest),
        test::gzip(kObj) + std::string(700'000, '\0'), test::zstd(half) + test::zstd(rest),
        skippable + test::zstd(kObj) + skippable}) {
    for (const char* name : {"a.obj.gz", "a.obj.zst", "a"}) {
      const MeshContent mesh = read_bytes(name, bytes);
      EXPECT_EQ(mesh.positions.size(), 4U);
      EXPECT_EQ(mesh.triangles, kSquareFan);
    }
  }
}

TEST_F(Compressed, GoesBackAndForthInLargeContent) {
  const std::string text = random_vertices(160'000);
  ASSERT_GT(text.size(), std::size_t{3} << 20);
  for (const std::string& bytes : {test::gzip(text), test::zstd(text), test::zstd(text, false)}) {
    ByteSource source(make_file("a.gz", bytes), 1000);
    EXPECT_TRUE(source.is_compressed());
    for (const std::size_t at : {2'000'000UL, 1'999'900UL, 5UL, 1'000'000UL, 0UL}) {
      source.seek(at);
      ASSERT_EQ(source.offset(), at);
      ASSERT_EQ(source.require(1000), 1000U);
      EXPECT_EQ(std::string(source.data(), 1000), text.substr(at, 1000));
    }
    EXPECT_FALSE(source.size_is_known());
    source.skip(text.size());
    EXPECT_EQ(source.offset(), text.size());
    EXPECT_TRUE(source.size_is_known());
    EXPECT_EQ(source.size(), text.size());
    EXPECT_EQ(source.file_offset(), bytes.size());
    source.seek(text.size() - 10);
    EXPECT_EQ(source.require(1000), 10U);
    const MeshContent mesh = read_bytes("a.obj.gz", bytes);
    EXPECT_EQ(mesh.positions.size(), 160'000U);
  }
}

TEST_F(Compressed, TellsProgressByTheCompressedBytes) {
  const std::string text = random_vertices(300'000);
  for (const std::string& bytes : {test::gzip(text), test::zstd(text)}) {
    const auto reader = open_mesh_reader(make_file("a.obj.gz", bytes));
    EXPECT_EQ(reader->bytes_total(), bytes.size());
    double before = 0;
    reader->read_positions([&](std::span<const Vec3>) {
      EXPECT_GE(reader->pass_fraction(), before);
      before = reader->pass_fraction();
    });
    EXPECT_EQ(reader->pass_fraction(), 1);
    EXPECT_EQ(reader->bytes_read_total(), bytes.size());
    const std::uint64_t guess = guess_content_bytes(directory() / "a.obj.gz");
    EXPECT_NEAR(double(guess), double(text.size()), 0.3 * double(text.size()));
  }
  EXPECT_EQ(guess_content_bytes(make_file("a.obj", kObj)), kObj.size());
}

TEST_F(Compressed, DoesNotReadPositionsInPlace) {
  const std::string bytes = ply_of(10, 10);
  EXPECT_TRUE(open_mesh_reader(make_file("a.ply", bytes))->position_array());
  EXPECT_FALSE(open_mesh_reader(make_file("a.ply.gz", test::gzip(bytes)))->position_array());
}

TEST_F(Compressed, NamesPlacesInTheContent) {
  const std::string bad = kObj + "f 1 2 9\n";
  expect_refused("a.obj.gz", test::gzip(bad), {"line 7 of the decompressed content:", "found 9"});
  expect_refused("a.ply.zst", test::zstd(ply_of(kMany, kMany + 1)),
                 {"byte", "of the decompressed content", "vertex 100000 of 100001"});
  expect_refused("a.txt.gz", test::gzip("once upon a time"), {"'once upon", "decompressed"});
  expect_refused("a.gz.gz", test::gzip(test::gzip(kObj)), {"gzip data within"});
  expect_refused("a.obj.gz", test::gzip(""), {"empty"});
}

/// A list or an element that is larger than any file can be is refused, or found out at the end.
TEST_F(Compressed, BelievesNoAnnouncement) {
  expect_refused("a.ply.gz", test::gzip(ply_of(3, 1'000'000'000)), {"1000000000 'vertex'"});
  expect_refused("a.ply.gz", test::gzip(ply_of(3, 1000)), {"1000 'vertex'", "only 36 bytes left"});
  expect_refused("a.ply.gz", test::gzip(ply_of(kMany, 2 * kMany)), {"vertex 100000 of 200000"});
  std::string stl(80, '\0');
  append(stl, std::uint32_t{4'000'000'000});
  expect_refused("a.stl.gz", test::gzip(stl), {"4000000000 triangles"});
  constexpr std::size_t kItems = 400'000;
  std::string list =
      "ply\nformat binary_little_endian 1.0\nelement other 1\nproperty list uint int other\n"
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  append(list, static_cast<std::uint32_t>(kItems));
  std::mt19937_64 random(11);
  for (std::size_t i = 1; i < kItems; ++i) append(list, static_cast<std::uint32_t>(random()));
  expect_refused("a.ply.gz", test::gzip(list.substr(0, list.size() - 12)),
                 {"other 0 of 1", "ends within"});
}

TEST_F(Compressed, RefusesEveryTruncationAndEveryDamage) {
  for (const std::string& whole : {test::gzip(kObj), test::zstd(kObj), test::zstd(kObj, false)}) {
    ASSERT_EQ(read_bytes("whole.obj.gz", whole).triangles, kSquareFan);
    for (std::size_t size = 4; size < whole.size(); ++size)
      expect_refused("cut.obj.gz", whole.substr(0, size));
    // Not every bit counts: a header has a time, and flags that mean nothing here.
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
      try {
        EXPECT_EQ(read_bytes("damaged.obj.gz", damaged).triangles, kSquareFan) << at;
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("damaged.obj.gz"), std::string::npos);
      }
    }
  }
  expect_refused("cut.gz", test::gzip(kObj).substr(0, 40), {"byte 40:", "cut off"});
  expect_refused("cut.zst", test::zstd(kObj).substr(0, 40), {"byte 40:", "cut off"});
  expect_refused("more.gz", test::gzip(kObj) + "more", {"another member"});
  expect_refused("more.zst", test::zstd(kObj) + "more", {"damaged"});
}

TEST_F(Compressed, ReservesLargeWindows) {
  const std::string text = random_vertices(500'000);
  const auto path = make_file("a.obj.zst", test::zstd(text, false, 23));
  MemoryBudget budget(std::uint64_t{10} << 20);
  {
    const auto reader = open_mesh_reader(path, &budget);
    EXPECT_EQ(budget.available(), std::uint64_t{2} << 20);
    std::size_t vertices = 0;
    reader->read_positions([&](std::span<const Vec3> chunk) { vertices += chunk.size(); });
    EXPECT_EQ(vertices, 500'000U);
  }
  EXPECT_EQ(budget.available(), budget.total());
  MemoryBudget small(std::uint64_t{7} << 20);
  EXPECT_THROW(open_mesh_reader(path, &small), BudgetError);
  // A header that announces a window of 3.75 TiB.
  expect_refused("bomb.zst", std::string_view("\x28\xb5\x2f\xfd\x00\xff\x00\x00\x00", 9),
                 {"window", "128 MiB"});
}

/// 200 MB of blanks in 200 kB.
TEST_F(Compressed, ReadsBombsWithoutHoldingThem) {
  std::string blanks(std::size_t{10} << 20, ' ');
  std::string bytes = test::gzip(kObj);
  const std::string part = test::gzip(blanks);
  for (int i = 0; i < 20; ++i) bytes += part;
  EXPECT_EQ(read_bytes("bomb.obj.gz", bytes).triangles, kSquareFan);
}

}  // namespace
}  // namespace remaps
