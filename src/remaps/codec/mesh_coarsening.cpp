#include "remaps/codec/mesh_coarsening.h"

#include <algorithm>

namespace remaps::codec {
namespace {

constexpr std::uint8_t kMiddle = 3, kUnknown = 4;

std::uint32_t lower_end(std::span<const Face> faces, Side s) {
  const Face& v = faces[s.face()];
  return std::min(v[s.corner()], v[Side::next_corner(s.corner())]);
}

std::uint32_t higher_end(std::span<const Face> faces, Side s) {
  const Face& v = faces[s.face()];
  return std::max(v[s.corner()], v[Side::next_corner(s.corner())]);
}

/// A stable counting sort by key(side), which is below `keys`.
template <class Key>
void sort_by(std::uint32_t keys, const std::vector<Side>& in, std::vector<Side>& out, Key&& key) {
  std::vector<std::uint32_t> start(std::size_t{keys} + 1, 0);
  for (const Side s : in) ++start[key(s) + 1];
  for (std::size_t i = 0; i < keys; ++i) start[i + 1] += start[i];
  out.resize(in.size());
  for (const Side s : in) out[start[key(s)]++] = s;
}

/// What a face is in its coarse face decides what its neighbours are in theirs.
class Labelling {
 public:
  explicit Labelling(const JoinedFaces& mesh) : mesh_(mesh), part_(mesh.faces(), kUnknown) {}

  /// @return  whether all faces that can be reached agree
  bool spread(std::uint32_t face, std::uint8_t part) {
    if (!set(face, part)) return false;
    while (!waiting_.empty()) {
      const std::uint32_t f = waiting_.back();
      waiting_.pop_back();
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (!across({f, k})) return false;
      }
    }
    return true;
  }
  std::uint8_t part(std::uint32_t face) const { return part_[face]; }

 private:
  bool set(std::uint32_t face, std::uint8_t part) {
    if (part_[face] == kUnknown) {
      part_[face] = part;
      waiting_.push_back(face);
    }
    return part_[face] == part;
  }

  bool across(Side side) {
    const std::uint8_t own = part_[side.face()];
    const Side twin = mesh_.twin_of(side);
    const bool inner = own == kMiddle || side.corner() == Side::next_corner(own);
    if (twin.none()) return !inner;  // the boundary is made of halves of coarse edges
    if (own == kMiddle)
      return set(twin.face(), static_cast<std::uint8_t>(twin.previous().corner()));
    if (inner) return set(twin.face(), kMiddle);
    // Half of a coarse edge: the same coarse vertex on both sides.
    const Side corner = side.corner() == own ? twin.next() : twin;
    return set(twin.face(), static_cast<std::uint8_t>(corner.corner()));
  }

  const JoinedFaces& mesh_;
  std::vector<std::uint8_t> part_;
  std::vector<std::uint32_t> waiting_;
};

/// The place of a fine face: coarse face and number of the child.
using Places = std::vector<Side>;

std::vector<Children> gather(const JoinedFaces& fine, const Labelling& labels, Places& place) {
  std::vector<Children> all;
  all.reserve(fine.faces() / 4);
  place.assign(fine.faces(), {});
  for (std::uint32_t f = 0; f < fine.faces(); ++f) {
    if (!place[f].none()) continue;
    const auto coarse = static_cast<std::uint32_t>(all.size());
    Children child;
    const std::uint32_t part = labels.part(f);
    child[3] = part == kMiddle ? Side(f, 0) : fine.twin_of(Side(f, part).next()).previous();
    Side opposite = child[3];
    for (std::uint32_t k = 0; k < 3; ++k, opposite = opposite.next()) {
      child[k] = fine.twin_of(opposite.next()).previous();
      place[child[k].face()] = {coarse, k};
    }
    place[child[3].face()] = {coarse, 3};
    all.push_back(child);
  }
  return all;
}

/// Corners and twins. False where an odd vertex is not regular: then the two halves of a coarse
/// edge lead to different places.
bool connect(const JoinedFaces& fine, const Places& place, Coarsening& result) {
  JoinedFaces& coarse = result.coarse;
  coarse.vertex.resize(result.child.size());
  coarse.twin.resize(result.child.size());
  std::vector<std::uint32_t> number(fine.vertices, kNoIndex);
  for (std::uint32_t f = 0; f < coarse.faces(); ++f) {
    const Children& child = result.child[f];
    for (std::uint32_t k = 0; k < 3; ++k) {
      std::uint32_t& v = number[fine.from(child[k])];
      if (v == kNoIndex) v = coarse.vertices++;
      coarse.vertex[f][k] = v;
      const Side first = fine.twin_of(child[k]);
      const Side second = fine.twin_of(child[Side::next_corner(k)].previous());
      if (first.none() != second.none()) return false;
      if (first.none()) continue;
      const Side there = place[second.face()];
      if (place[first.face()] != there.next()) return false;
      coarse.twin[f][k] = there;
    }
  }
  return true;
}

}  // namespace

std::optional<SideClash> join_sides(std::uint32_t vertices, std::span<const Face> faces,
                                    std::vector<std::array<Side, 3>>& twin) {
  twin.assign(faces.size(), {});
  std::vector<Side> sides, sorted;
  sides.reserve(3 * faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) sides.emplace_back(f, k);
  }
  sort_by(vertices, sides, sorted, [&](Side s) { return higher_end(faces, s); });
  sort_by(vertices, sorted, sides, [&](Side s) { return lower_end(faces, s); });
  const auto same = [&](Side a, Side b) {
    return lower_end(faces, a) == lower_end(faces, b) &&
           higher_end(faces, a) == higher_end(faces, b);
  };
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side a = sides[i], b = sides[i + 1];
    if (!same(a, b)) continue;
    if (faces[a.face()][a.corner()] == faces[b.face()][b.corner()]) return SideClash{a, b};
    if (i + 2 < sides.size() && same(a, sides[i + 2])) return SideClash{a, sides[i + 2]};
    twin[a.face()][a.corner()] = b;
    twin[b.face()][b.corner()] = a;
    ++i;
  }
  return std::nullopt;
}

std::optional<Coarsening> coarsen(const JoinedFaces& fine, unsigned part) {
  if (fine.faces() == 0 || fine.faces() % 4 != 0) return std::nullopt;
  Coarsening result;
  Places place;
  {
    Labelling labels(fine);
    if (!labels.spread(0, static_cast<std::uint8_t>(part))) return std::nullopt;
    result.child = gather(fine, labels, place);
  }
  if (!connect(fine, place, result)) return std::nullopt;
  return result;
}

bool is_simple(const JoinedFaces& mesh) {
  for (const auto& [a, b, c] : mesh.vertex) {
    if (a == b || b == c || c == a) return false;
  }
  std::vector<std::array<Side, 3>> twin;
  return !join_sides(mesh.vertices, mesh.vertex, twin) && twin == mesh.twin;
}

}  // namespace remaps::codec
