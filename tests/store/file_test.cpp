#include "remaps/store/file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "support/temp_files.h"

namespace remaps::store {
namespace {

class FileTest : public test::TempFiles {};

ByteSpan bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

TEST_F(FileTest, ReadsBackWhatWasWrittenAnywhere) {
  File file = File::create(directory() / "f");
  file.write_at(6, bytes("world"));
  file.write_at(0, bytes("hello "));
  EXPECT_EQ(file.size(), 11u);
  std::string part(7, ' ');
  file.read_at(3, std::as_writable_bytes(std::span(part)));
  EXPECT_EQ(part, "lo worl");
  file.close();
  EXPECT_EQ(read_whole_file(directory() / "f"), "hello world");
}

TEST_F(FileTest, CountsTheBytesThatWentThrough) {
  const IoCounts before = io_counts();
  write_file_atomically(directory() / "f", std::string(1000, 'x'));
  read_whole_file(directory() / "f");
  const IoCounts after = io_counts();
  EXPECT_EQ(after.written - before.written, 1000u);
  EXPECT_EQ(after.read - before.read, 1000u);
}

TEST_F(FileTest, ThrowsCorruptionWhenTheFileEndsTooEarly) {
  const File file = File::open_read(make_file("short", "12345"));
  std::string part(4, ' ');
  EXPECT_NO_THROW(file.read_at(1, std::as_writable_bytes(std::span(part))));
  EXPECT_THROW(file.read_at(2, std::as_writable_bytes(std::span(part))), CorruptionError);
  EXPECT_THROW(file.read_at(50, std::as_writable_bytes(std::span(part))), CorruptionError);
  EXPECT_NO_THROW(file.read_at(50, {}));
}

TEST_F(FileTest, NamesThePathWhenItCannotOpen) {
  try {
    File::open_read(directory() / "absent");
    FAIL() << "opened";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("absent"), std::string::npos) << error.what();
  }
  EXPECT_THROW(File::create(directory() / "no" / "such" / "place"), IoError);
}

TEST_F(FileTest, ThrowsWhenTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  File file = File::create("/dev/full");
  EXPECT_THROW(file.write_at(0, bytes("x")), IoError);
}

TEST_F(FileTest, MovesWithoutClosingWhatIsOpen) {
  File a = File::create(directory() / "a");
  File b = std::move(a);
  a = File::create(directory() / "other");
  b.write_at(0, bytes("kept"));
  File c;
  c = std::move(b);
  c.write_at(4, bytes("!"));
  c.close();
  EXPECT_EQ(read_whole_file(directory() / "a"), "kept!");
}

TEST_F(FileTest, WritesAtomicallyOverAnOldFileAndLeavesNoOther) {
  const auto path = make_file("f", "old content that is longer");
  write_file_atomically(path, "new");
  EXPECT_EQ(read_whole_file(path), "new");
  EXPECT_EQ(entries_in(directory()), 1u);
}

TEST_F(FileTest, LeavesNothingWhenAnAtomicWriteFails) {
  std::filesystem::create_directories(directory() / "taken" / "by a directory");
  EXPECT_THROW(write_file_atomically(directory() / "taken", "new"), std::exception);
  EXPECT_EQ(entries_in(directory()), 1u);
  EXPECT_THROW(write_file_atomically(directory() / "absent" / "f", "new"), IoError);
}

TEST_F(FileTest, WritesToAHiddenNeighbourFirst) {
  const auto partial = partial_name(directory() / "f.bin");
  EXPECT_EQ(partial.parent_path(), directory());
  EXPECT_EQ(partial.filename().string().front(), '.');
  EXPECT_NE(partial.filename().string().find("f.bin"), std::string::npos);
}

TEST_F(FileTest, RemovesATempDirWithEverythingInIt) {
  std::filesystem::path path;
  {
    const TempDir temp(directory());
    const TempDir other(directory());
    path = temp.path();
    EXPECT_NE(path, other.path());
    EXPECT_TRUE(std::filesystem::is_directory(path));
    std::filesystem::create_directories(path / "a" / "b");
    write_file_atomically(path / "a" / "b" / "file", "x");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_EQ(entries_in(directory()), 0u);
}

TEST_F(FileTest, RefusesATempDirWhereNoneCanBe) {
  EXPECT_THROW(TempDir(directory() / "absent"), IoError);
  EXPECT_THROW(TempDir(make_file("file", "x")), IoError);
}

}  // namespace
}  // namespace remaps::store
