#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>

#include "remaps/base/errors.h"
#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"
#include "remaps/formats/position_spool.h"

namespace remaps {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFaceBytes = 50;
/// Must not begin as an ASCII STL does.
constexpr char kHeader[] = "binary STL written by remaps";

/// Of length 1, or zero for a face without area.
Vec3f unit_normal(const std::array<Vec3f, 3>& corner) {
  const Vec3 a = widen(corner[0]);
  const Vec3 normal = cross(widen(corner[1]) - a, widen(corner[2]) - a);
  const double length = norm(normal);
  return length > 0 && length <= std::numeric_limits<double>::max() ? to_float(1 / length * normal)
                                                                    : Vec3f{};
}

class StlWriter final : public CountedWriter {
 public:
  StlWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces)
      : CountedWriter(path, vertices, faces), spool_(path) {
    char header[kHeaderBytes] = {};
    std::memcpy(header, kHeader, sizeof kHeader);
    sink().write(header, sizeof header);
    const auto count = narrow<std::uint32_t>(faces);
    sink().write(&count, sizeof count);
  }

 private:
  void put_positions(std::span<const Vec3> positions) override { spool_.append(positions); }

  void put_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) {
      const std::array<Vec3f, 3> corner{spool_.at(t[0]), spool_.at(t[1]), spool_.at(t[2])};
      const Vec3f normal = unit_normal(corner);
      char* const to = sink().room(kFaceBytes);
      std::memcpy(to, &normal, sizeof normal);
      std::memcpy(to + sizeof normal, corner.data(), sizeof corner);
      std::memset(to + sizeof normal + sizeof corner, 0, 2);
      sink().advance(kFaceBytes);
    }
  }

  PositionSpool spool_;
};

}  // namespace

void check_stl_size(const std::filesystem::path& path, std::uint64_t faces) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (faces <= kMost) return;
  throw BudgetError(
      fmt::format("{}: a binary STL holds at most {} faces, the mesh has {}; .ply, .obj, .off and "
                  ".vtp have no such limit",
                  path.string(), kMost, faces));
}

std::unique_ptr<IndexedMeshWriter> make_stl_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces) {
  return std::make_unique<StlWriter>(path, vertices, faces);
}

}  // namespace remaps
