#include <algorithm>
#include <string>

#include "remaps/formats/file_extension.h"
#include "remaps/formats/glb_layout.h"
#include "remaps/formats/mesh_writer.h"

namespace remaps {
namespace {

using Kind = AttributeKind;
using Per = AttributePer;

/// Gives away the places that a format has: each once, to the first attribute that fits.
class Places {
 public:
  explicit Places(std::span<const AttributeSpec> specs) : specs_(specs), held_(specs.size()) {}

  bool give(Kind kind, Per per, std::size_t least, std::size_t most) {
    for (std::size_t i = 0; i < specs_.size(); ++i) {
      const AttributeSpec& spec = specs_[i];
      const std::size_t n = spec.components.size();
      if (held_[i] || spec.kind != kind || spec.per != per || n < least || n > most) continue;
      held_[i] = true;
      return true;
    }
    return false;
  }
  void give_all(Per per) {
    for (std::size_t i = 0; i < specs_.size(); ++i) held_[i] = held_[i] || specs_[i].per == per;
  }
  void give_textures(std::size_t most) {
    for (std::size_t i = 0; i < specs_.size() && most > 0; ++i) {
      const bool fits = specs_[i].kind == Kind::uv && specs_[i].per != Per::face;
      if (!fits || specs_[i].components.size() != 2) continue;
      held_[i] = true;
      --most;
    }
  }
  std::vector<bool> held() && { return std::move(held_); }

 private:
  std::span<const AttributeSpec> specs_;
  std::vector<bool> held_;
};

}  // namespace

std::vector<bool> held_attributes(const std::filesystem::path& path,
                                  std::span<const AttributeSpec> specs) {
  constexpr std::size_t kAny = ~std::size_t{0};
  const std::string extension = lower_extension(path);
  Places places(specs);
  if (extension == ".ply" || extension == ".vtp") {
    places.give_all(Per::vertex);
    places.give_all(Per::face);
    if (extension == ".vtp") places.give_all(Per::corner);
    if (extension == ".ply") places.give(Kind::uv, Per::corner, 2, 2);
  } else if (extension == ".obj") {
    places.give(Kind::colour, Per::vertex, 3, kAny);
    for (const Kind kind : {Kind::normal, Kind::uv}) {
      const std::size_t n = kind == Kind::normal ? 3 : 2;
      if (!places.give(kind, Per::corner, n, n)) places.give(kind, Per::vertex, n, n);
    }
  } else if (extension == ".off") {
    places.give(Kind::normal, Per::vertex, 3, 3);
    places.give(Kind::colour, Per::vertex, 3, 4);
    places.give(Kind::uv, Per::vertex, 2, 2);
    places.give(Kind::colour, Per::face, 3, 4);
  } else if (extension == ".glb") {
    places.give(Kind::normal, Per::vertex, 3, 3);
    places.give(Kind::colour, Per::vertex, 3, 4);
    places.give_textures(kMostGlbTextures);
  }
  return std::move(places).held();
}

}  // namespace remaps
