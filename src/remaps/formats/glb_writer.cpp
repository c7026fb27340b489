#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <string>

#include "remaps/base/errors.h"
#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

/// The JSON is written first and completed last: what it does not fill of this is blanks.
constexpr std::size_t kJsonBytes = 1024;
constexpr std::uint64_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr std::uint64_t kJsonOffset = kHeaderBytes + kChunkHeaderBytes;
constexpr std::uint64_t kPositionBytes = sizeof(Vec3f);
constexpr std::uint64_t kTriangleBytes = 3 * sizeof(std::uint32_t);

constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A,
                        kBinChunk = 0x004E4942;

std::uint64_t bin_bytes(std::uint64_t vertices, std::uint64_t faces) {
  return kPositionBytes * vertices + kTriangleBytes * faces;
}

std::uint64_t file_bytes(std::uint64_t vertices, std::uint64_t faces) {
  return kJsonOffset + kJsonBytes + kChunkHeaderBytes + bin_bytes(vertices, faces);
}

/// A float as a decimal of the same value as a double: whoever reads it in either type gets it.
void append_number(std::string& text, double value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, std::end(digits), value).ptr);
}

void append_point(std::string& text, const Vec3& p) {
  text += '[';
  append_number(text, p.x);
  text += ',';
  append_number(text, p.y);
  text += ',';
  append_number(text, p.z);
  text += ']';
}

/// One mesh in one node, positions and triangles in the two halves of the buffer.
std::string make_json(std::uint64_t vertices, std::uint64_t faces, const Box3& box) {
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0","generator":"remaps"}},"scene":0,"scenes":[{{"nodes":[0]}}],)"
      R"("nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":1}},)"
      R"("indices":0}}]}}],"buffers":[{{"byteLength":{}}}],"bufferViews":[)"
      R"({{"buffer":0,"byteLength":{},"target":34962}},)"
      R"({{"buffer":0,"byteOffset":{},"byteLength":{},"target":34963}}],"accessors":[)"
      R"({{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}},)"
      R"({{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":)",
      bin_bytes(vertices, faces), kPositionBytes * vertices, kPositionBytes * vertices,
      kTriangleBytes * faces, 3 * faces, vertices);
  append_point(json, box.low);
  json += R"(,"max":)";
  append_point(json, box.high);
  json += "}]}";
  json.resize(kJsonBytes, ' ');
  return json;
}

class GlbWriter final : public CountedWriter {
 public:
  GlbWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces)
      : CountedWriter(path, vertices, faces) {
    put_words({kMagic, kVersion, narrow<std::uint32_t>(file_bytes(vertices, faces)),
               std::uint32_t{kJsonBytes}, kJsonChunk});
    const std::string room(kJsonBytes, ' ');
    sink().write(room.data(), room.size());
    put_words({narrow<std::uint32_t>(bin_bytes(vertices, faces)), kBinChunk});
  }

 private:
  void put_words(std::initializer_list<std::uint32_t> words) {
    sink().write(words.begin(), words.size() * sizeof(std::uint32_t));
  }

  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& position : positions) {
      const Vec3f stored = to_float(position);
      box_.add(widen(stored));
      std::memcpy(sink().room(sizeof stored), &stored, sizeof stored);
      sink().advance(sizeof stored);
    }
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) {
      const std::uint32_t corners[3] = {static_cast<std::uint32_t>(t[0]),
                                        static_cast<std::uint32_t>(t[1]),
                                        static_cast<std::uint32_t>(t[2])};
      std::memcpy(sink().room(sizeof corners), corners, sizeof corners);
      sink().advance(sizeof corners);
    }
  }

  void finish() override {
    const std::string json = make_json(vertices(), faces(), box_);
    sink().rewrite(kJsonOffset, json.data(), json.size());
  }

  Box3 box_;
};

}  // namespace

void check_glb_size(const std::filesystem::path& path, std::uint64_t vertices,
                    std::uint64_t faces) {
  if (vertices == 0 || faces == 0) {
    throw GeometryError(
        fmt::format("{}: glTF has no mesh without vertices or faces, this one has {} and {}; .ply, "
                    ".off and .vtp may be empty",
                    path.string(), vertices, faces));
  }
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  const bool overflows = vertices > kMost || faces > kMost;
  if (!overflows && file_bytes(vertices, faces) <= kMost) return;
  throw BudgetError(
      fmt::format("{}: a GLB has less than 4 GiB, {} vertices and {} faces need {} bytes each; "
                  ".ply, .obj, .off and .vtp have no such limit",
                  path.string(), vertices, faces, kPositionBytes));
}

std::unique_ptr<IndexedMeshWriter> make_glb_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces) {
  return std::make_unique<GlbWriter>(path, vertices, faces);
}

}  // namespace remaps
