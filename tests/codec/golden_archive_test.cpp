#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <sstream>

#include "formats/mesh_files.h"
#include "remaps/pipeline/codec_files.h"

namespace remaps {
namespace {

/// A binary PLY of remaps: rows of three floats and what else a vertex has, then faces.
struct PlyParts {
  std::string header, vertices, faces;
  std::size_t count = 0;

  std::size_t row_bytes() const { return vertices.size() / count; }
  float coordinate(std::size_t vertex, std::size_t k) const {
    float x = 0;
    std::memcpy(&x, vertices.data() + vertex * row_bytes() + 4 * k, sizeof x);
    return x;
  }
};

/// Archives that were written by the first program of their version must decode as they did then.
class GoldenArchive : public MeshFiles {
 protected:
  static PlyParts parts_of(const std::filesystem::path& path) {
    const std::string bytes = bytes_of(path);
    constexpr std::string_view kEnd = "end_header\n";
    PlyParts ply;
    ply.header = bytes.substr(0, bytes.find(kEnd) + kEnd.size());
    std::size_t faces = 0;
    std::istringstream lines(ply.header);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("element vertex ")) ply.count = std::stoul(line.substr(15));
      if (line.starts_with("element face ")) faces = std::stoul(line.substr(13));
    }
    const std::size_t vertex_bytes = bytes.size() - ply.header.size() - 13 * faces;
    ply.vertices = bytes.substr(ply.header.size(), vertex_bytes);
    ply.faces = bytes.substr(ply.header.size() + vertex_bytes);
    return ply;
  }

  void expect_same(const std::string& archive, const std::string& expected,
                   std::optional<std::uint64_t> bytes, std::optional<unsigned> level) const {
    const std::filesystem::path data = REMAPS_TEST_DATA;
    pipeline::DecodeOptions options;
    options.archive = data / archive;
    options.output = directory() / "out.ply";
    options.bytes = bytes;
    options.level = level;
    Progress progress;
    pipeline::decode_file(options, progress);
    const PlyParts out = parts_of(options.output), then = parts_of(data / expected);
    ASSERT_EQ(out.header, then.header);
    EXPECT_EQ(out.faces, then.faces);
    ASSERT_EQ(out.vertices.size(), then.vertices.size());
    for (std::size_t v = 0; v < out.count; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(out.coordinate(v, k), then.coordinate(v, k), 1e-5) << v;
      }
      for (std::size_t at = v * out.row_bytes() + 12; at < (v + 1) * out.row_bytes(); ++at) {
        const auto value = [&](const PlyParts& ply) {
          return static_cast<int>(static_cast<unsigned char>(ply.vertices[at]));
        };
        EXPECT_LE(std::abs(value(out) - value(then)), 1) << v;
      }
    }
  }
};

TEST_F(GoldenArchive, Version1DecodesAsItDid) {
  expect_same("golden-v1.remapsa", "golden-v1.ply", {}, {});
}

TEST_F(GoldenArchive, PrefixesOfVersion1DecodeAsTheyDid) {
  expect_same("golden-v1.remapsa", "golden-v1-1000-bytes.ply", 1000, 2);
}

TEST_F(GoldenArchive, OpenAndColouredOnesOfVersion1DecodeAsTheyDid) {
  expect_same("golden-v1-open.remapsa", "golden-v1-open.ply", {}, {});
}

}  // namespace
}  // namespace remaps
