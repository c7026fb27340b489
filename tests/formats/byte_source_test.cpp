#include "remaps/formats/byte_source.h"

#include "formats/mesh_files.h"

namespace remaps {
namespace {

using ByteSourceFiles = MeshFiles;

std::string counting_bytes(std::size_t n) {
  std::string bytes;
  for (std::size_t i = 0; i < n; ++i) bytes += static_cast<char>(i % 251);
  return bytes;
}

TEST_F(ByteSourceFiles, DeliversEveryByteAtSizesAroundTheBuffer) {
  constexpr std::size_t kBuffer = 64;
  for (const std::size_t size : {0UL, 1UL, 63UL, 64UL, 65UL, 127UL, 128UL, 129UL}) {
    const std::string bytes = counting_bytes(size);
    ByteSource source(make_file("bytes", bytes), kBuffer);
    for (const std::size_t step : {1UL, 7UL, 64UL}) {
      source.seek(0);
      std::string read;
      while (const std::size_t n = std::min(source.require(step), step)) {
        EXPECT_EQ(source.offset(), read.size());
        EXPECT_EQ(source.data()[source.available()], '\n');
        read.append(source.data(), n);
        source.consume(n);
      }
      EXPECT_EQ(read, bytes);
      EXPECT_EQ(source.remaining(), 0U);
    }
  }
}

TEST_F(ByteSourceFiles, SkipsWithinAndBeyondTheBuffer) {
  const std::string bytes = counting_bytes(1000);
  ByteSource source(make_file("bytes", bytes), 64);
  for (const std::size_t step : {10UL, 0UL, 300UL, 5UL, 600UL}) {
    source.skip(step);
    ASSERT_GE(source.require(1), 1U);
    EXPECT_EQ(source.data()[0], bytes[static_cast<std::size_t>(source.offset())]);
  }
  EXPECT_EQ(source.offset(), 915U);
  source.skip(85);
  EXPECT_EQ(source.require(1), 0U);
}

TEST_F(ByteSourceFiles, CountsWhatItReadAndReadsNothingTwiceThatItHolds) {
  const std::string bytes = counting_bytes(1000);
  ByteSource source(make_file("bytes", bytes), 64);
  EXPECT_EQ(source.bytes_read_total(), 0U);
  source.require(10);
  EXPECT_EQ(source.bytes_read_total(), 64U);
  source.consume(50);
  for (const std::uint64_t offset : {0UL, 64UL, 17UL}) {
    source.seek(offset);
    EXPECT_EQ(source.offset(), offset);
    EXPECT_EQ(source.available(), 64 - offset);
    EXPECT_EQ(std::string(source.data(), source.available()), bytes.substr(offset, 64 - offset));
  }
  EXPECT_EQ(source.bytes_read_total(), 64U);
  source.seek(500);
  source.require(64);
  source.seek(490);
  source.require(64);
  EXPECT_EQ(source.data()[0], bytes[490]);
  EXPECT_EQ(source.bytes_read_total(), 192U);
}

TEST_F(ByteSourceFiles, RefusesAFileThatShrinksWhileItIsRead) {
  const auto path = make_file("bytes", counting_bytes(1000));
  ByteSource source(path, 64);
  std::filesystem::resize_file(path, 100);
  source.seek(200);
  EXPECT_THROW(source.require(1), InputError);
}

}  // namespace
}  // namespace remaps
