#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>
#include <string>

#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

class PlyWriter final : public CountedWriter {
 public:
  PlyWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces)
      : CountedWriter(path, vertices, faces),
        wide_(vertices > std::numeric_limits<std::uint32_t>::max()) {
    const bool fits_int = vertices <= std::numeric_limits<std::int32_t>::max();
    const std::string header = fmt::format(
        "ply\n"
        "format binary_little_endian 1.0\n"
        "element vertex {}\n"
        "property float x\n"
        "property float y\n"
        "property float z\n"
        "element face {}\n"
        "property list uchar {} vertex_indices\n"
        "end_header\n",
        vertices, faces,
        fits_int ? "int"
        : wide_  ? "uint64"
                 : "uint");
    sink().write(header.data(), header.size());
  }

 private:
  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& position : positions) {
      const Vec3f stored = to_float(position);
      std::memcpy(sink().room(sizeof stored), &stored, sizeof stored);
      sink().advance(sizeof stored);
    }
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    if (wide_) {
      put<std::uint64_t>(triangles);
    } else {
      put<std::uint32_t>(triangles);
    }
  }

  template <class Index>
  void put(std::span<const Triangle> triangles) {
    constexpr std::size_t kRecord = 1 + 3 * sizeof(Index);
    for (const Triangle& triangle : triangles) {
      const Index corners[3] = {static_cast<Index>(triangle[0]), static_cast<Index>(triangle[1]),
                                static_cast<Index>(triangle[2])};
      char* const to = sink().room(kRecord);
      to[0] = 3;
      std::memcpy(to + 1, corners, sizeof corners);
      sink().advance(kRecord);
    }
  }

  bool wide_;
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_ply_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces) {
  return std::make_unique<PlyWriter>(path, vertices, faces);
}

}  // namespace remaps
