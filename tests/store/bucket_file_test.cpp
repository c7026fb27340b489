#include "remaps/store/bucket_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/temp_files.h"

namespace remaps::store {
namespace {

constexpr std::size_t kOnDisk = 512;         // the least, and what few buffer bytes give
constexpr std::size_t kBlock = kOnDisk - 8;  // of them, without the checksum

class BucketFileTest : public test::TempFiles {
 protected:
  std::filesystem::path path() const { return directory() / "buckets"; }
  std::uint64_t size_on_disk() const { return std::filesystem::file_size(path()); }

  MemoryBudget budget_{std::uint64_t{64} << 20};
};

Bytes random_bytes(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Bytes bytes(size);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}

TEST_F(BucketFileTest, ReadsBackSizesAboutABlock) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, kBlock - 1, kBlock, kBlock + 1,
                                 2 * kBlock, 5 * kBlock + 77}) {
    SCOPED_TRACE(size);
    BucketFile file(path(), 3, 1, budget_);
    const Bytes data = random_bytes(size, size);
    file.append(1, data);
    EXPECT_EQ(file.bytes(1), size);
    EXPECT_EQ(file.total_bytes(), size);
    Bytes back{std::byte{1}};
    file.read(1, 0, size, back);
    EXPECT_EQ(back, data);
    file.read(0, 0, 0, back);
    EXPECT_TRUE(back.empty());
    file.take(1, back);
    EXPECT_EQ(back, data);
    EXPECT_EQ(file.bytes(1), 0u);
  }
}

TEST_F(BucketFileTest, NeverTouchesTheDiskForWhatFillsNoBlock) {
  BucketFile file(path(), 4, 1, budget_);
  for (std::size_t b = 0; b < 4; ++b) file.append(b, random_bytes(kBlock - 1, b));
  EXPECT_EQ(size_on_disk(), 0u);
  file.append(2, random_bytes(1, 9));
  EXPECT_EQ(size_on_disk(), kOnDisk);
}

TEST_F(BucketFileTest, KeepsManyBucketsApart) {
  constexpr std::uint64_t kSeed = 5;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  constexpr std::size_t kBuckets = 300;
  BucketFile file(path(), kBuckets, 1, budget_);
  std::vector<Bytes> model(kBuckets);
  for (int i = 0; i < 20'000; ++i) {
    const std::size_t b = random() % kBuckets;
    const Bytes record = random_bytes(random() % 40, random());
    file.append(b, record);
    model[b].insert(model[b].end(), record.begin(), record.end());
  }
  Bytes back;
  for (std::size_t b = 0; b < kBuckets; ++b) {
    ASSERT_EQ(file.bytes(b), model[b].size());
    for (int piece = 0; piece < 4; ++piece) {
      const std::size_t from = random() % (model[b].size() + 1);
      const std::size_t size = random() % (model[b].size() - from + 1);
      file.read(b, from, size, back);
      ASSERT_TRUE(std::equal(back.begin(), back.end(),
                             model[b].begin() + static_cast<std::ptrdiff_t>(from)));
      ASSERT_EQ(back.size(), size);
    }
    file.take(b, back);
    ASSERT_EQ(back, model[b]);
  }
}

TEST_F(BucketFileTest, UsesFreedSpaceAgain) {
  const std::uint64_t before = disk_usage().now;
  restart_disk_peak();
  BucketFile file(path(), 8, 1, budget_);
  const Bytes data = random_bytes(10 * kBlock, 1);
  Bytes back;
  for (int round = 0; round < 20; ++round) {
    for (std::size_t b = 0; b < 8; ++b) file.append(b, data);
    for (std::size_t b = 0; b < 8; ++b) {
      file.take(b, back);
      ASSERT_EQ(back, data);
    }
  }
  constexpr std::uint64_t kExtent = 64 << 10;
  EXPECT_LE(size_on_disk(), 8 * kExtent);
  EXPECT_EQ(disk_usage().now, before);
  EXPECT_EQ(disk_usage().peak, before + 8 * 10 * kOnDisk);
}

TEST_F(BucketFileTest, GivesSpaceBackToTheFileSystem) {
  BucketFile file(path(), 2, 1, budget_);
  const auto allocated = [&] {
    struct stat status {};
    EXPECT_EQ(::stat(path().c_str(), &status), 0);
    return static_cast<std::uint64_t>(status.st_blocks) * 512;
  };
  file.append(0, random_bytes(1 << 20, 1));
  file.append(1, random_bytes(1 << 20, 2));
  const std::uint64_t full = allocated();
  EXPECT_GE(full, 2u << 20);
  file.release(0);
  EXPECT_LT(allocated(), full / 2 + (64 << 10));
  Bytes back;
  file.take(1, back);
  EXPECT_EQ(back, random_bytes(1 << 20, 2));
}

TEST_F(BucketFileTest, GrowsOneBucketThroughAllSizesOfExtents) {
  BucketFile file(path(), 2, 1, budget_);
  const Bytes piece = random_bytes(10'007, 4);
  constexpr std::uint64_t kPieces = 8000;  // 80 MB; extents reach 16 MiB
  for (std::uint64_t i = 0; i < kPieces; ++i) file.append(0, piece);
  Bytes back;
  for (std::uint64_t i = 0; i < kPieces; i += 97) {
    file.read(0, i * piece.size(), piece.size(), back);
    ASSERT_EQ(back, piece) << i;
  }
  file.read(0, 31'000'000, 20'014, back);
  EXPECT_EQ(back.size(), 20'014u);
  EXPECT_EQ(back[5], piece[31'000'005 % piece.size()]);
  EXPECT_EQ(back[20'000], piece[31'020'000 % piece.size()]);
}

TEST_F(BucketFileTest, FindsAFlippedByteAnywhereOnDisk) {
  BucketFile file(path(), 2, 1, budget_);
  const Bytes data = random_bytes(3 * kBlock, 3);
  file.append(0, data);
  const File disk = File::open_read(path());
  for (std::uint64_t at = 0; at < 3 * kOnDisk; at += 61) {
    std::byte original{};
    disk.read_at(at, {&original, 1});
    const auto put = [&](std::byte value) {
      std::fstream stream(path(), std::ios::binary | std::ios::in | std::ios::out);
      stream.seekp(static_cast<std::streamoff>(at));
      stream.put(static_cast<char>(value));
    };
    put(original ^ std::byte{0x10});
    Bytes back;
    EXPECT_THROW(file.read(0, 0, data.size(), back), CorruptionError) << "byte " << at;
    put(original);
    EXPECT_NO_THROW(file.read(0, 0, data.size(), back));
  }
}

TEST_F(BucketFileTest, FindsATruncatedFile) {
  BucketFile file(path(), 1, 1, budget_);
  file.append(0, random_bytes(3 * kBlock, 3));
  std::filesystem::resize_file(path(), 2 * kOnDisk + 100);
  Bytes back;
  EXPECT_NO_THROW(file.read(0, 0, 2 * kBlock, back));
  EXPECT_THROW(file.read(0, 0, 3 * kBlock, back), CorruptionError);
}

TEST_F(BucketFileTest, ReadsBucketsOnSeveralThreads) {
  BucketFile file(path(), 16, 1, budget_);
  std::vector<Bytes> model;
  for (std::size_t b = 0; b < 16; ++b) {
    model.push_back(random_bytes(7 * kBlock + b, b));
    file.append(b, model.back());
  }
  std::vector<int> same(16, 0);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      Bytes back;
      for (std::size_t b = t; b < 16; b += 4) {
        file.take(b, back);
        same[b] = back == model[b];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(std::count(same.begin(), same.end(), 1), 16);
}

TEST_F(BucketFileTest, PacksRecordsOfAnySize) {
  BucketFile file(path(), 2, 1, budget_);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    file.append_record(i % 2, [&](Packer& packer) {
      packer.put_varint(i);
      packer.put(i * 0.5);
    });
  }
  Bytes back;
  file.take(1, back);
  Unpacker unpacker(back, "records");
  for (std::uint32_t i = 1; i < 1000; i += 2) {
    EXPECT_EQ(unpacker.get_varint(), i);
    EXPECT_EQ(unpacker.get<double>(), i * 0.5);
  }
  EXPECT_TRUE(unpacker.done());
}

TEST_F(BucketFileTest, HoldsAReservationAndRemovesItsFile) {
  {
    const BucketFile file(path(), 4, 4 * 2048, budget_);
    EXPECT_EQ(budget_.total() - budget_.available(), 4u * (2048 + BucketFile::kBucketOverhead));
    EXPECT_TRUE(std::filesystem::exists(path()));
  }
  EXPECT_EQ(budget_.total(), budget_.available());
  EXPECT_FALSE(std::filesystem::exists(path()));
  MemoryBudget small(1000);
  EXPECT_THROW(BucketFile(path(), 4, 1, small), BudgetError);
}

}  // namespace
}  // namespace remaps::store
