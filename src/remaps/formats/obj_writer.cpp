#include <charconv>

#include "remaps/formats/counted_writer.h"
#include "remaps/formats/format_factories.h"

namespace remaps {
namespace {

/// Room for a line: a keyword, three numbers of at most 20 characters with a separator each.
constexpr std::size_t kLongestLine = 80;

class ObjWriter final : public CountedWriter {
 public:
  using CountedWriter::CountedWriter;

 private:
  void put_positions(std::span<const Vec3> positions) override {
    for (const Vec3& position : positions) {
      const Vec3f p = to_float(position);
      put_line('v', p.x, p.y, p.z);
    }
  }

  void put_triangles(std::span<const Triangle> triangles) override {
    for (const Triangle& t : triangles) put_line('f', t[0] + 1, t[1] + 1, t[2] + 1);
  }

  /// Floats as the shortest text that reads back as the same float.
  template <class Number>
  void put_line(char keyword, Number a, Number b, Number c) {
    char* const first = sink().room(kLongestLine);
    char* to = first;
    *to++ = keyword;
    for (const Number number : {a, b, c}) {
      *to++ = ' ';
      to = std::to_chars(to, first + kLongestLine, number).ptr;
    }
    *to++ = '\n';
    sink().advance(static_cast<std::size_t>(to - first));
  }
};

}  // namespace

std::unique_ptr<IndexedMeshWriter> make_obj_writer(const std::filesystem::path& path,
                                                   std::uint64_t vertices, std::uint64_t faces) {
  return std::make_unique<ObjWriter>(path, vertices, faces);
}

}  // namespace remaps
