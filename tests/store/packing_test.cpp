#include "remaps/store/packing.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace remaps::store {
namespace {

/// Values about all powers of two, and random ones of all lengths.
std::vector<std::uint64_t> numbers(std::uint64_t seed) {
  std::vector<std::uint64_t> result{0, std::numeric_limits<std::uint64_t>::max()};
  for (unsigned bit = 0; bit < 64; ++bit) {
    for (const int d : {-1, 0, 1})
      result.push_back((std::uint64_t{1} << bit) + static_cast<std::uint64_t>(d));
  }
  std::mt19937_64 random(seed);
  for (int i = 0; i < 500; ++i) result.push_back(random() >> (random() % 64));
  return result;
}

TEST(Packing, ReadsBackVarints) {
  constexpr std::uint64_t kSeed = 11;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  for (const std::uint64_t value : numbers(kSeed)) {
    Bytes bytes;
    Packer packer(bytes);
    packer.put_varint(value);
    packer.put_signed(static_cast<std::int64_t>(value));
    Unpacker unpacker(bytes, "varints");
    EXPECT_EQ(unpacker.get_varint(), value);
    EXPECT_EQ(unpacker.get_signed(), static_cast<std::int64_t>(value));
    EXPECT_TRUE(unpacker.done());
  }
}

TEST(Packing, TakesOneByteForSmallNumbersOfEitherSign) {
  for (std::int64_t value = -64; value < 64; ++value) {
    Bytes bytes;
    Packer(bytes).put_signed(value);
    EXPECT_EQ(bytes.size(), 1u) << value;
  }
  Bytes bytes;
  Packer(bytes).put_varint(127);
  EXPECT_EQ(bytes.size(), 1u);
  Packer(bytes).put_varint(128);
  EXPECT_EQ(bytes.size(), 3u);
}

TEST(Packing, IsLittleEndian) {
  Bytes bytes;
  Packer packer(bytes);
  packer.put(std::uint32_t{0x04030201});
  packer.put40(0x0908070605);
  ASSERT_EQ(bytes.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(bytes[i], static_cast<std::byte>(i + 1));
}

TEST(Packing, ReadsBackIdsArraysAndStructs) {
  struct Pair {
    float a;
    std::uint32_t b;
  };
  const std::vector<std::uint16_t> array{1, 2, 65535};
  Bytes bytes;
  Packer packer(bytes);
  packer.put40(kMaxId40);
  packer.put(Pair{1.5f, 7});
  packer.put_array(std::span<const std::uint16_t>(array));
  packer.put_array(std::span<const std::uint16_t>());
  Unpacker unpacker(bytes, "things");
  EXPECT_EQ(unpacker.get40(), kMaxId40);
  const auto pair = unpacker.get<Pair>();
  EXPECT_EQ(pair.a, 1.5f);
  EXPECT_EQ(pair.b, 7u);
  EXPECT_EQ(unpacker.left(), 6u);
  std::vector<std::uint16_t> back;
  unpacker.get_vector(3, back);
  EXPECT_EQ(back, array);
  EXPECT_TRUE(unpacker.done());
}

TEST(Packing, ThrowsAtEveryTruncation) {
  Bytes bytes;
  Packer packer(bytes);
  packer.put(std::uint32_t{5});
  packer.put40(123456789012);
  packer.put_varint(std::uint64_t{1} << 60);
  packer.put_signed(-1'000'000);
  const std::vector<double> array{1, 2, 3};
  packer.put_array(std::span<const double>(array));
  const auto read_all = [](ByteSpan data) {
    Unpacker unpacker(data, "the record");
    unpacker.get<std::uint32_t>();
    unpacker.get40();
    unpacker.get_varint();
    unpacker.get_signed();
    std::vector<double> back;
    unpacker.get_vector(3, back);
  };
  EXPECT_NO_THROW(read_all(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    // A copy of its own, so that a read past the end is one that the sanitizer sees.
    const Bytes part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    try {
      read_all(part);
      ADD_FAILURE() << "read from " << size << " bytes";
    } catch (const CorruptionError& error) {
      EXPECT_NE(std::string(error.what()).find("the record"), std::string::npos) << error.what();
    }
  }
}

TEST(Packing, ChecksACountBeforeTakingMemoryForIt) {
  const Bytes bytes(64);
  for (const std::uint64_t count :
       {std::uint64_t{9}, std::uint64_t{1} << 61, std::numeric_limits<std::uint64_t>::max()}) {
    Unpacker unpacker(bytes, "counts");
    std::vector<double> values;
    EXPECT_THROW(unpacker.get_vector(count, values), CorruptionError) << count;
    EXPECT_EQ(values.capacity(), 0u);
  }
}

TEST(Packing, RefusesAVarintThatNeverEnds) {
  const Bytes bytes(20, std::byte{0x80});
  Unpacker unpacker(bytes, "varints");
  EXPECT_THROW(unpacker.get_varint(), CorruptionError);
}

}  // namespace
}  // namespace remaps::store
