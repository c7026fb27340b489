#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstring>
#include <functional>

#include "codec/semi_regular_shapes.h"
#include "remaps/base/errors.h"

namespace remaps::codec {
namespace {

constexpr std::size_t kHeaderBytes = 68;  // without its checksum

/// A small archive with signals and a table.
store::Bytes small_archive() {
  SemiRegularMesh mesh = test::rough_mesh(test::base_of(test::cone(5)), 2, 0.05, 3);
  test::add_signals(mesh);
  const store::Bytes bytes = test::encode(mesh);
  const RatePoint points[] = {{500, 30.5f}, {900, 41.25f}};
  return seal_archive(Archive(bytes, "archive"), bytes.size(), bytes.size(), points);
}

/// Reads and decodes at several lengths.
void read(store::ByteSpan bytes, std::uint64_t memory = test::kCodecMemory) {
  const Archive archive(bytes, "archive");
  MemoryBudget budget(memory);
  for (const std::uint64_t size : {archive.least_bytes(), std::uint64_t{bytes.size()}}) {
    archive.decode(size, archive.header().levels, budget);
  }
}

void seal(store::Bytes& bytes, std::size_t at, std::size_t size) {
  const auto sum = static_cast<std::uint32_t>(XXH3_64bits(bytes.data() + at, size));
  std::memcpy(bytes.data() + at + size, &sum, sizeof sum);
}

template <class T>
void put(store::Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

TEST(ArchiveDamage, EveryChangedByteIsFound) {
  const store::Bytes bytes = small_archive();
  EXPECT_NO_THROW(read(bytes));
  EXPECT_EQ(Archive(bytes, "archive").rate_points().size(), 2u);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const unsigned flip : {0x01u, 0x80u, 0xFFu}) {
      store::Bytes changed = bytes;
      changed[at] ^= static_cast<std::byte>(flip);
      bool refused = false;
      try {
        read(changed);
      } catch (const InputError&) {
        refused = at < 9;  // no archive, or of another version
      } catch (const CorruptionError&) {
        refused = true;
      }
      EXPECT_TRUE(refused) << "byte " << at << " xor " << flip;
    }
  }
}

TEST(ArchiveDamage, BytesBehindTheEndAreFound) {
  store::Bytes bytes = small_archive();
  bytes.push_back(std::byte{0});
  EXPECT_THROW(read(bytes), CorruptionError);
}

/// An attacker computes checksums.
TEST(ArchiveDamage, LyingHeadersAreRefusedWithoutTakingMemory) {
  const store::Bytes bytes = small_archive();
  const std::uint32_t counts[] = {0, 1, 2, 3, 100, 10'000, 1u << 20, 1u << 26, 0x7FFFFFFF, ~0u};
  for (const std::size_t field : {48u, 52u, 56u, 60u, 64u}) {
    for (const std::uint32_t count : counts) {
      store::Bytes lying = bytes;
      put(lying, field, count);
      seal(lying, 0, kHeaderBytes);
      try {
        read(lying, 16 << 20);
      } catch (const InputError&) {
      } catch (const CorruptionError&) {
      } catch (const BudgetError&) {
      }
    }
  }
  // Many faces of a base whose code ends at once.
  for (const std::uint32_t faces : {1000u, 1u << 16, 1u << 20, 1u << 28}) {
    store::Bytes lying = bytes;
    put(lying, 48, faces);
    put(lying, 52, faces);
    put(lying, 10, std::uint8_t{0});
    seal(lying, 0, kHeaderBytes);
    EXPECT_ANY_THROW(read(lying, 64 << 20)) << faces;
  }
}

TEST(ArchiveDamage, ValuesOutsideTheirRangeAreRefused) {
  const store::Bytes bytes = small_archive();
  const auto refused = [&](const std::function<void(store::Bytes&)>& change) {
    store::Bytes changed = bytes;
    change(changed);
    seal(changed, 0, kHeaderBytes);
    EXPECT_THROW(read(changed), CorruptionError);
  };
  refused([](store::Bytes& b) { put(b, 9, std::uint8_t{3}); });
  refused([](store::Bytes& b) { put(b, 10, std::uint8_t{15}); });
  refused([](store::Bytes& b) { put(b, 11, std::uint8_t{0}); });
  refused([](store::Bytes& b) { put(b, 11, std::uint8_t{31}); });
  refused([](store::Bytes& b) { put(b, 12, std::uint8_t{0}); });
  refused([](store::Bytes& b) { put(b, 13, std::uint8_t{0}); });
  refused([](store::Bytes& b) { put(b, 14, std::uint8_t{13}); });
  refused([](store::Bytes& b) { put(b, 15, std::uint8_t{49}); });
  for (const double bad : {HUGE_VAL, double(NAN)}) {
    refused([&](store::Bytes& b) { put(b, 16, bad); });
    refused([&](store::Bytes& b) { put(b, 40, bad); });
  }
  refused([](store::Bytes& b) { put(b, 40, 0.0); });
  refused([](store::Bytes& b) { put(b, 40, -1.0); });
}

/// Any bytes are a code of details; what a base's code must be is checked.
TEST(ArchiveDamage, WrongCodesWithRightChecksumsAreDecodedOrRefused) {
  const store::Bytes bytes = small_archive();
  std::uint32_t base_bytes = 0;
  std::memcpy(&base_bytes, bytes.data() + 56, sizeof base_bytes);
  const std::size_t base = kHeaderBytes + 4, code = base + base_bytes + 4;
  for (std::size_t at = base; at < base + base_bytes; ++at) {
    for (unsigned value = 0; value < 256; value += 5) {
      store::Bytes wrong = bytes;
      wrong[at] = static_cast<std::byte>(value);
      seal(wrong, base, base_bytes);
      try {
        read(wrong);
      } catch (const CorruptionError&) {
      }
    }
  }
  std::uint32_t code_bytes = 0;
  std::memcpy(&code_bytes, bytes.data() + 60, sizeof code_bytes);
  ASSERT_LT(code_bytes, 4096u);
  for (std::size_t at = code; at < code + code_bytes; at += 3) {
    store::Bytes wrong = bytes;
    wrong[at] ^= std::byte{0x55};
    seal(wrong, code, code_bytes);
    EXPECT_NO_THROW(read(wrong)) << at;
  }
}

}  // namespace
}  // namespace remaps::codec
