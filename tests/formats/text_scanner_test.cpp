#include "remaps/formats/text_scanner.h"

#include "formats/mesh_files.h"

namespace remaps {
namespace {

using TextScannerFiles = MeshFiles;

/// The smallest buffer: every few hundred words meet its border.
ByteSource open_small(const std::filesystem::path& path) {
  return ByteSource(path, 2 * TextScanner::kLongestWord);
}

TEST_F(TextScannerFiles, ReadsNumbersAcrossBufferBorders) {
  for (std::size_t shift = 0; shift < 9; ++shift) {
    std::string text(shift, ' ');
    for (int i = 0; i < 5000; ++i) text += std::to_string(i) + (i % 10 == 9 ? ".5\r\n" : ".5 ");
    ByteSource source = open_small(make_file("numbers", text));
    TextScanner scanner(source);
    for (int i = 0; i < 5000; ++i) {
      scanner.skip_space();
      ASSERT_EQ(scanner.real(), i + 0.5);
    }
    scanner.skip_space();
    EXPECT_TRUE(scanner.at_end());
  }
}

TEST_F(TextScannerFiles, KnowsHowALineEndedAcrossBufferBorders) {
  for (std::size_t length = 8180; length < 8200; ++length) {
    const std::string text = std::string(length, 'x') + "\\\r\nnext\n\r\nlast";
    ByteSource source = open_small(make_file("lines", text));
    TextScanner scanner(source);
    EXPECT_EQ(scanner.skip_line(), '\\');
    scanner.skip_blanks();
    EXPECT_EQ(scanner.peek(0), 'n');
    EXPECT_EQ(scanner.skip_line(), 't');
    EXPECT_EQ(scanner.skip_line(), 0);
    EXPECT_EQ(scanner.skip_line(), 't');
    EXPECT_TRUE(scanner.at_end());
  }
}

TEST_F(TextScannerFiles, RefusesWordsBeyondTheLimit) {
  ByteSource source = open_small(make_file("word", std::string(9000, '1') + " 2"));
  TextScanner scanner(source);
  scanner.skip_blanks();
  EXPECT_THROW(scanner.word(), InputError);
  EXPECT_THROW(scanner.real(), InputError);
}

TEST_F(TextScannerFiles, RoundsOnceToFloat) {
  // Halfway between two floats plus a little that a double cannot hold.
  ByteSource source = open_small(make_file("float", "1.00000005960464477539062500000001"));
  TextScanner scanner(source);
  scanner.skip_blanks();
  EXPECT_EQ(scanner.real_float(), 0x1.000002p0F);
}

}  // namespace
}  // namespace remaps
