#include "remaps/store/section_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "support/temp_files.h"

namespace remaps::store {
namespace {

constexpr std::array<char, 4> kKind{'t', 'e', 's', 't'};

class SectionFileTest : public test::TempFiles {
 protected:
  std::filesystem::path path() const { return directory() / "sections.bin"; }

  void write(const std::vector<Bytes>& sections) const {
    SectionFileWriter writer(path(), kKind);
    for (std::size_t i = 0; i < sections.size(); ++i) {
      EXPECT_EQ(writer.append(pack_section(sections[i])), i);
    }
    writer.seal();
  }
  /// Reads everything, as a user of the file would.
  std::vector<Bytes> read_all() const {
    const SectionFile file(path(), kKind);
    std::vector<Bytes> sections(file.sections());
    for (std::size_t i = 0; i < sections.size(); ++i) file.read(i, sections[i]);
    return sections;
  }
};

std::vector<Bytes> some_sections() {
  std::mt19937_64 random(7);
  std::vector<Bytes> sections;
  for (const std::size_t size : {0u, 1u, 50u, 0u, 300u}) {
    Bytes bytes(size);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random() % 7);
    sections.push_back(bytes);
  }
  return sections;
}

TEST_F(SectionFileTest, ReadsBackSections) {
  write(some_sections());
  EXPECT_EQ(read_all(), some_sections());
  const SectionFile file(path(), kKind);
  EXPECT_EQ(file.raw_bytes(2), 50u);
  EXPECT_EQ(file.raw_bytes(3), 0u);
  EXPECT_EQ(entries_in(directory()), 1u);
}

TEST_F(SectionFileTest, ReadsBackAFileWithoutSections) {
  write({});
  EXPECT_TRUE(read_all().empty());
}

TEST_F(SectionFileTest, ReadsBackALargeSection) {
  std::mt19937_64 random(8);
  Bytes bytes(3'000'000);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random() & 15);
  write({bytes});
  EXPECT_EQ(read_all(), std::vector<Bytes>{bytes});
  EXPECT_LT(std::filesystem::file_size(path()), bytes.size());
}

TEST_F(SectionFileTest, RefusesAFileCutAtAnyByte) {
  write(some_sections());
  const std::string whole = bytes_of(path());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    make_file("sections.bin", whole.substr(0, size));
    EXPECT_THROW(read_all(), CorruptionError) << size << " of " << whole.size() << " bytes";
  }
  make_file("sections.bin", whole + "x");
  EXPECT_THROW(read_all(), CorruptionError);
}

TEST_F(SectionFileTest, RefusesAFlippedBitAnywhere) {
  write(some_sections());
  const std::string whole = bytes_of(path());
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
    make_file("sections.bin", damaged);
    EXPECT_THROW(read_all(), CorruptionError) << "byte " << at;
  }
}

TEST_F(SectionFileTest, SurvivesGarbageOfAnySize) {
  constexpr std::uint64_t kSeed = 21;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  write(some_sections());
  const std::string whole = bytes_of(path());
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 300; ++i) {
    std::string damaged = whole;
    const std::size_t from = random() % damaged.size();
    const std::size_t size = 1 + random() % (damaged.size() - from);
    for (std::size_t k = from; k < from + size; ++k) damaged[k] = static_cast<char>(random());
    make_file("sections.bin", damaged);
    EXPECT_THROW(read_all(), CorruptionError);
  }
}

TEST_F(SectionFileTest, LeavesNothingUnlessSealed) {
  {
    SectionFileWriter writer(path(), kKind);
    writer.append(pack_section(Bytes(100)));
    EXPECT_FALSE(std::filesystem::exists(path()));
  }
  EXPECT_EQ(entries_in(directory()), 0u);
}

TEST_F(SectionFileTest, KeepsAnOldFileUntilTheNewOneIsSealed) {
  write(some_sections());
  {
    SectionFileWriter writer(path(), kKind);
    writer.append(pack_section(Bytes(100)));
    EXPECT_EQ(read_all(), some_sections());
  }
  EXPECT_EQ(read_all(), some_sections());
  write({});
  EXPECT_TRUE(read_all().empty());
}

TEST_F(SectionFileTest, RefusesAnotherKind) {
  write({});
  EXPECT_THROW(SectionFile(path(), {'l', 'o', 'g', '1'}), CorruptionError);
  EXPECT_THROW(SectionFile(directory() / "absent", kKind), IoError);
}

}  // namespace
}  // namespace remaps::store
