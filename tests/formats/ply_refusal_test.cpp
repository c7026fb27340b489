#include "formats/mesh_files.h"

namespace remaps {
namespace {

using PlyRefusal = MeshFiles;

const std::string kAscii = "ply\nformat ascii 1.0\n";
const std::string kBinary = "ply\nformat binary_little_endian 1.0\n";
const std::string kPositions = "property float x\nproperty float y\nproperty float z\n";
const std::string kCorners = "property list uchar int vertex_indices\n";
const std::string kEnd = "end_header\n";

std::string triangle_header(const std::string& format) {
  return format + "element vertex 3\n" + kPositions + "element face 1\n" + kCorners + kEnd;
}

std::string binary_triangle(std::array<std::int32_t, 3> corners, float x = 0) {
  std::string bytes = triangle_header(kBinary);
  append(bytes, x);
  for (int i = 1; i < 9; ++i) append(bytes, static_cast<float>(i));
  append(bytes, std::uint8_t{3});
  for (const std::int32_t v : corners) append(bytes, v);
  return bytes;
}

TEST_F(PlyRefusal, QuotesTheFileShortAndWithoutControlCharacters) {
  const auto message_of = [&](const std::string& bytes) -> std::string {
    try {
      read_bytes("a.ply", bytes);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string head = triangle_header(kAscii);
  const std::string number = "1" + std::string(3000, '0');
  const std::string name(100'000, 'n');
  for (const std::string& bytes : {head + number + " 0 0\n", head + "\x1b[31m\a\x7f 0 0\n",
                                   kAscii + "element a 1\nproperty int a\nele\x1b[31mment\n",
                                   kAscii + "element " + name + " 9999\nproperty int a\n" + kEnd,
                                   kAscii + "element a\x1b[2Jb 9999\nproperty int a\n" + kEnd}) {
    const std::string message = message_of(bytes);
    EXPECT_FALSE(message.empty());
    EXPECT_LT(message.size(), 1000u);
    for (const char c : message) EXPECT_TRUE(c >= ' ' || c < 0) << message;
    EXPECT_EQ(message.find('\x7f'), std::string::npos);
  }
}

TEST_F(PlyRefusal, NamesLineAndValueInText) {
  const std::string head = triangle_header(kAscii);
  expect_refused("a.ply", head + "0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n", {"line 11:", "'zero'"});
  expect_refused("a.ply", head + "0 0 0\n1 0 1.#TWO\n0 1 0\n3 0 1 2\n", {"line 11:", "'1.#TWO'"});
  expect_refused("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
                 {"line 13:", "face 0 of 1", "below 3", "found 3"});
  expect_refused("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", {"line 13:", "found -1"});
  expect_refused("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2.5\n", {"line 13:", "'2.5'"});
  expect_refused("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", {"line 13:", "found 2"});
  expect_refused("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1\n",
                 {"line 14:", "face 0 of 1", "the file ends"});
  expect_refused("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n99 0 1 2\n", {"line 13:", "a list of 99"});
  expect_refused("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", {"line 13:", "a list of -3"});
}

TEST_F(PlyRefusal, NamesByteAndValueInBinary) {
  const std::size_t data = triangle_header(kBinary).size();
  const auto byte = [](std::size_t at) { return "byte " + std::to_string(at) + ":"; };
  EXPECT_NO_THROW(read_bytes("b.ply", binary_triangle({0, 1, 2})));
  expect_refused("b.ply", binary_triangle({0, 3, 2}), {byte(data + 41), "face 0 of 1", "found 3"});
  expect_refused("b.ply", binary_triangle({0, 1, -1}), {byte(data + 45), "found -1"});
  std::string two = binary_triangle({0, 1, 2});
  two[data + 36] = 2;
  expect_refused("b.ply", two, {byte(data + 36), "found 2"});
  two[data + 36] = 4;
  expect_refused("b.ply", two, {"a list of 4", "12 bytes left"});
}

TEST_F(PlyRefusal, RefusesEveryTruncationOfABinaryFile) {
  const std::string whole = binary_triangle({0, 1, 2});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    expect_refused("cut.ply", whole.substr(0, size));
  }
  EXPECT_EQ(read_bytes("whole.ply", whole).triangles.size(), 1U);
}

TEST_F(PlyRefusal, RefusesEveryTruncationOfATextFile) {
  const std::string whole = triangle_header(kAscii) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2";
  for (std::size_t size = 0; size < whole.size(); ++size) {
    expect_refused("cut.ply", whole.substr(0, size));
  }
  EXPECT_EQ(read_bytes("whole.ply", whole).triangles.size(), 1U);
}

/// Any byte may be wrong: the file is read or refused, nothing else.
TEST_F(PlyRefusal, SurvivesEveryWrongByte) {
  const std::string text = triangle_header(kAscii) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (const std::string& whole : {binary_triangle({0, 1, 2}), text}) {
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (const char wrong : {'\0', '\n', ' ', '0', '9', '-', '\x7f', '\xff'}) {
        std::string bytes = whole;
        bytes[at] = wrong;
        try {
          read_bytes("wrong.ply", bytes);
        } catch (const InputError&) {
        }
      }
    }
  }
}

TEST_F(PlyRefusal, ChecksCountsAgainstTheSizeOfTheFile) {
  const auto vertices = [](const std::string& format, const std::string& count) {
    return format + "element vertex " + count + "\n" + kPositions + kEnd;
  };
  expect_refused("a.ply", vertices(kBinary, "4000000000") + "few bytes",
                 {"4000000000 'vertex'", "12 bytes each", "only 9 bytes"});
  expect_refused("a.ply", vertices(kBinary, "18446744073709551615"), {"18446744073709551615"});
  expect_refused("a.ply", vertices(kBinary, "18446744073709551616"), {"line 3:", "count"});
  expect_refused("a.ply", vertices(kBinary, "-1"), {"line 3:", "'-1'"});
  expect_refused("a.ply", vertices(kBinary, "1x"), {"line 3:", "'1x'"});
  expect_refused("a.ply", vertices(kAscii, "1000") + "0 0 0\n", {"1000 'vertex'"});
}

TEST_F(PlyRefusal, NamesTheFaultOfAHeader) {
  const std::string vertex = "element vertex 0\n" + kPositions;
  expect_refused("a.ply", "ply\n" + vertex + kEnd, {"'format'"});
  expect_refused("a.ply", "ply\nformat binary 1.0\n" + vertex + kEnd, {"line 2:", "format"});
  expect_refused("a.ply", kAscii + vertex, {"end_header"});
  expect_refused("a.ply", kAscii + kPositions + kEnd, {"line 3:", "element"});
  expect_refused("a.ply", kAscii + vertex + vertex + kEnd, {"line 7:", "second element 'vertex'"});
  expect_refused("a.ply", kAscii + vertex + "properties float w\n" + kEnd,
                 {"line 7:", "'properties'"});
  expect_refused("a.ply", kAscii + vertex + "property half w\n" + kEnd, {"line 7:", "'half'"});
  expect_refused("a.ply", kAscii + vertex + "property list float int w\n" + kEnd, {"line 7:"});
  expect_refused("a.ply", kAscii + vertex + "property list uchar int\n" + kEnd, {"line 7:"});
  expect_refused("a.ply", kAscii + "element face 0\n" + kCorners + kEnd, {"'vertex'"});
  expect_refused("a.ply", kAscii + "element vertex 0\nproperty float x\n" + kEnd, {"'y'"});
  expect_refused("a.ply",
                 kAscii + vertex + "element face 1\nproperty list uchar float vertex_indices\n" +
                     kEnd + "3 0 0 0\n",
                 {"'vertex_indices'", "'face'"});
  expect_refused("a.ply", kAscii + vertex + "element face 1\nproperty int a\n" + kEnd + "3\n",
                 {"'vertex_indices'"});
}

TEST_F(PlyRefusal, BoundsTheHeader) {
  expect_refused("a.ply", kAscii + "comment " + std::string(std::size_t{2} << 20, 'x') + "\n",
                 {"1 MiB"});
}

TEST_F(PlyRefusal, RefusesOverlongWords) {
  expect_refused("a.ply", triangle_header(kAscii) + std::string(std::size_t{3} << 20, '1'));
}

}  // namespace
}  // namespace remaps
