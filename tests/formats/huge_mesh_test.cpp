#include <limits>
#include <system_error>

#include "formats/mesh_files.h"

namespace remaps {
namespace {

/// Files of more records than 32 bits count. Their vertices are a hole in the file: no byte of them
/// is on disk or ever read.
class HugeMesh : public MeshFiles {
 protected:
  /// A binary PLY of n vertices, some other records and the given bytes of faces.
  std::filesystem::path make_ply(std::uint64_t vertices, std::uint64_t others,
                                 std::string_view index_type, std::uint64_t faces,
                                 std::string_view face_bytes) const {
    std::string head =
        "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(vertices) +
        "\nproperty float x\nproperty float y\nproperty float z\nelement material " +
        std::to_string(others) + "\nproperty uchar shine\nelement face " + std::to_string(faces) +
        "\nproperty list uchar " + std::string(index_type) + " vertex_indices\nend_header\n";
    const std::filesystem::path path = make_file("huge.ply", head);
    std::error_code error;
    std::filesystem::resize_file(path, head.size() + 12 * vertices + others, error);
    if (error) return {};
    std::ofstream(path, std::ios::binary | std::ios::app)
        .write(face_bytes.data(), std::ssize(face_bytes));
    return path;
  }

  static std::vector<Triangle> read_triangles(const std::filesystem::path& path) {
    std::vector<Triangle> triangles;
    const auto reader = open_mesh_reader(path);
    reader->read_triangles([&](std::span<const Triangle> chunk) {
      triangles.insert(triangles.end(), chunk.begin(), chunk.end());
    });
    EXPECT_LT(reader->bytes_read_total(), std::uint64_t{4} << 20);
    return triangles;
  }
};

template <class Index>
std::string face_bytes(const std::vector<Triangle>& faces) {
  std::string bytes;
  for (const Triangle& t : faces) {
    append(bytes, std::uint8_t{3});
    for (const VertexId v : t) append(bytes, static_cast<Index>(v));
  }
  return bytes;
}

TEST_F(HugeMesh, ReadsIndicesOnBothSidesOf31And32Bits) {
  for (const unsigned bits : {31u, 32u}) {
    const std::uint64_t border = std::uint64_t{1} << bits;
    const std::uint64_t vertices = border + 10;
    const std::vector<Triangle> faces = {
        {0, border - 2, border - 1}, {border - 1, border, border + 1}, {vertices - 1, border, 7}};
    std::vector<std::pair<std::string_view, std::string>> cases = {
        {"int64", face_bytes<std::int64_t>(faces)}, {"uint64", face_bytes<std::uint64_t>(faces)}};
    if (bits == 31) cases.emplace_back("uint", face_bytes<std::uint32_t>(faces));
    for (const auto& [type, bytes] : cases) {
      const auto path = make_ply(vertices, border + 1, type, faces.size(), bytes);
      if (path.empty()) GTEST_SKIP() << "no sparse files here";
      EXPECT_EQ(read_triangles(path), faces) << type;
    }
  }
}

TEST_F(HugeMesh, RefusesIndicesThatWouldBeValidCutTo32Bits) {
  const std::uint64_t border = std::uint64_t{1} << 32;
  const auto expect_refused_at = [&](std::string_view type, std::uint64_t vertices,
                                     const std::string& bytes, const std::string& found) {
    const auto path = make_ply(vertices, 0, type, 1, bytes);
    if (path.empty()) GTEST_SKIP() << "no sparse files here";
    try {
      read_triangles(path);
      ADD_FAILURE() << type << " was read";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("found " + found), std::string::npos) << message;
      EXPECT_NE(message.find("face 0 of 1"), std::string::npos) << message;
    }
  };
  expect_refused_at("uint64", border + 10, face_bytes<std::uint64_t>({{0, 1, border + 10}}),
                    std::to_string(border + 10));
  expect_refused_at("uint64", 10, face_bytes<std::uint64_t>({{0, 1, border + 2}}),
                    std::to_string(border + 2));
  // As unsigned numbers these would be vertices.
  expect_refused_at("int", border + 10, face_bytes<std::int32_t>({{0, 1, border - 1}}), "-1");
  expect_refused_at("int", border + 10, face_bytes<std::int32_t>({{0, 1, border / 2}}),
                    "-2147483648");
}

TEST_F(HugeMesh, ChecksCountsBeyond32BitsAgainstTheFile) {
  const std::uint64_t faces = (std::uint64_t{1} << 32) + 3;
  const auto path = make_ply(10, 0, "int", faces, "");
  try {
    open_mesh_reader(path);
    ADD_FAILURE() << "opened";
  } catch (const InputError& error) {
    EXPECT_NE(std::string_view(error.what()).find("4294967299 'face'"), std::string_view::npos)
        << error.what();
  }
}

/// As many faces as a hole has bytes: the first of them is a list of none.
TEST_F(HugeMesh, CountsFacesIn64Bits) {
  const std::uint64_t faces = (std::uint64_t{1} << 32) + 3;
  const auto path = make_ply(10, 0, "int", faces, "");
  std::error_code error;
  std::filesystem::resize_file(path, std::filesystem::file_size(path) + faces, error);
  if (error) GTEST_SKIP() << "no sparse files here";
  try {
    read_triangles(path);
    ADD_FAILURE() << "read";
  } catch (const InputError& refused) {
    EXPECT_NE(std::string_view(refused.what()).find("face 0 of 4294967299"), std::string_view::npos)
        << refused.what();
  }
}

}  // namespace
}  // namespace remaps
