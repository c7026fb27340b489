#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/formats/corner_splitter.h"
#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/glb_layout.h"
#include "remaps/formats/record_spool.h"

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

constexpr std::uint64_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr std::uint64_t kJsonOffset = kHeaderBytes + kChunkHeaderBytes;
constexpr std::uint64_t kTriangleBytes = 3 * sizeof(std::uint32_t);
constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();

constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A,
                        kBinChunk = 0x004E4942;

std::uint64_t bin_bytes(const GlbLayout& layout, std::uint64_t vertices, std::uint64_t faces) {
  return layout.stride() * vertices + kTriangleBytes * faces;
}

std::uint64_t file_bytes(const GlbLayout& layout, std::uint64_t vertices, std::uint64_t faces) {
  return kJsonOffset + layout.json_bytes() + kChunkHeaderBytes + bin_bytes(layout, vertices, faces);
}

void check_size(const std::filesystem::path& path, const GlbLayout& layout, std::uint64_t vertices,
                std::uint64_t faces) {
  const bool overflows = vertices > kMost || faces > kMost;
  if (!overflows && file_bytes(layout, vertices, faces) <= kMost) return;
  throw BudgetError(fmt::format(
      "{}: a GLB has less than 4 GiB, but {} vertices of {} bytes and {} faces of {} need more; "
      ".ply, .obj, .off and .vtp have no such limit",
      path.string(), vertices, layout.stride(), faces, kTriangleBytes));
}

/// The JSON is written first and completed last: what it does not fill of its room is blanks.
///
/// Vertices are written as they come, then the faces. Where corners have texture coordinates,
/// vertices with several of them are copied, and how many there are is known at the end: then they
/// wait, the faces come first, and the sizes in the header are completed last too.
class GlbWriter final : public CountedWriter {
 public:
  GlbWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces,
            const std::vector<AttributeSpec>& attributes)
      : CountedWriter(path, vertices, faces, attributes),
        layout_(attributes),
        vertex_(layout_.stride()) {
    check_size(path, layout_, vertices, faces);
    if (layout_.corner_sets() > 0) {
      waiting_.emplace(path, layout_.corners_at());
      splitter_.emplace(path, vertices, 2 * layout_.corner_sets());
      corner_.resize(2 * layout_.corner_sets());
    }
    put_head(vertices);
  }

 private:
  /// Everything before the buffer, with the JSON still blank.
  void put_head(std::uint64_t vertices) {
    put_words({kMagic, kVersion, narrow<std::uint32_t>(file_bytes(layout_, vertices, faces())),
               narrow<std::uint32_t>(layout_.json_bytes()), kJsonChunk});
    const std::string room(layout_.json_bytes(), ' ');
    sink().write(room.data(), room.size());
    put_words({narrow<std::uint32_t>(bin_bytes(layout_, vertices, faces())), kBinChunk});
  }

  void put_words(std::initializer_list<std::uint32_t> words) {
    sink().write(words.begin(), words.size() * sizeof(std::uint32_t));
  }

  void put_positions(std::span<const Vec3> positions) override { put_vertices(positions, {}); }

  void put_vertices(std::span<const Vec3> positions, std::span<const std::byte> rows) override {
    const std::size_t width = rows.size() / std::max<std::size_t>(positions.size(), 1);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Vec3f stored = to_float(positions[i]);
      box_.add(widen(stored));
      std::memcpy(vertex_.data(), &stored, sizeof stored);
      if (width > 0) layout_.put(rows.subspan(i * width, width), vertex_.data());
      if (waiting_) {
        std::memcpy(waiting_->change(seen_++), vertex_.data(), waiting_->record_bytes());
      } else {
        sink().write(vertex_.data(), vertex_.size());
      }
    }
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) put_triangle(t);
  }

  void put_faces(std::span<const Triangle> triangles, std::span<const std::byte>,
                 std::span<const std::byte> corner_rows) override {
    if (!splitter_) return put_triangles(triangles);
    const std::size_t width = corner_rows.size() / triangles.size() / 3;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      Triangle split = triangles[i];
      for (std::size_t k = 0; k < 3; ++k) {
        layout_.read_corner(corner_rows.subspan((3 * i + k) * width, width), corner_);
        split[k] = splitter_->split(split[k], corner_);
      }
      check_size(sink().path(), layout_, vertices() + splitter_->copies(), faces());
      put_triangle(split);
    }
  }

  void put_triangle(const Triangle& t) {
    const std::uint32_t corners[3] = {static_cast<std::uint32_t>(t[0]),
                                      static_cast<std::uint32_t>(t[1]),
                                      static_cast<std::uint32_t>(t[2])};
    std::memcpy(sink().room(sizeof corners), corners, sizeof corners);
    sink().advance(sizeof corners);
  }

  void finish() override {
    std::uint64_t count = vertices();
    if (splitter_) {
      count += splitter_->copies();
      put_waiting(count);
      const std::uint32_t file = narrow<std::uint32_t>(file_bytes(layout_, count, faces()));
      const std::uint32_t bin = narrow<std::uint32_t>(bin_bytes(layout_, count, faces()));
      sink().rewrite(2 * sizeof file, &file, sizeof file);
      sink().rewrite(kJsonOffset + layout_.json_bytes(), &bin, sizeof bin);
    }
    const std::string json = layout_.json({count, faces(), box_, splitter_.has_value()});
    sink().rewrite(kJsonOffset, json.data(), json.size());
  }

  void put_waiting(std::uint64_t count) {
    for (std::uint64_t v = 0; v < count; ++v) {
      const std::uint64_t original = splitter_->read(v, corner_);
      sink().write(waiting_->at(original), waiting_->record_bytes());
      sink().write(corner_.data(), corner_.size() * sizeof(float));
    }
  }

  GlbLayout layout_;
  Box3 box_;
  std::vector<std::byte> vertex_;
  // Where corners have texture coordinates.
  std::optional<RecordSpool> waiting_;
  std::optional<CornerSplitter> splitter_;
  std::vector<float> corner_;
  std::uint64_t seen_ = 0;
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
  check_size(path, GlbLayout({}), vertices, faces);
}

std::unique_ptr<IndexedMeshWriter> make_glb_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces,
                                                   const std::vector<AttributeSpec>& attributes) {
  return std::make_unique<GlbWriter>(path, vertices, faces, attributes);
}

}  // namespace remaps
