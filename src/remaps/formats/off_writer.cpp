#include <fmt/format.h>

#include <charconv>
#include <initializer_list>
#include <string>

#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

/// Room for a line: four numbers of at most 20 characters with a separator each.
constexpr std::size_t kLongestLine = 90;

class OffWriter final : public CountedWriter {
 public:
  OffWriter(const std::filesystem::path& path, std::uint64_t vertices, std::uint64_t faces)
      : CountedWriter(path, vertices, faces) {
    const std::string header = fmt::format("OFF\n{} {} 0\n", vertices, faces);
    sink().write(header.data(), header.size());
  }

 private:
  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& position : positions) {
      const Vec3f p = to_float(position);
      put_line({p.x, p.y, p.z});
    }
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) put_line<std::uint64_t>({3, t[0], t[1], t[2]});
  }

  /// Floats as the shortest text that reads back as the same float.
  template <class Number>
  void put_line(std::initializer_list<Number> numbers) {
    char* const first = sink().room(kLongestLine);
    char* to = first;
    for (const Number number : numbers) {
      to = std::to_chars(to, first + kLongestLine, number).ptr;
      *to++ = ' ';
    }
    to[-1] = '\n';
    sink().advance(static_cast<std::size_t>(to - first));
  }
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_off_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces) {
  return std::make_unique<OffWriter>(path, vertices, faces);
}

}  // namespace remaps
