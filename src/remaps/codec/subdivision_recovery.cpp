#include "remaps/codec/subdivision_recovery.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "remaps/codec/mesh_coarsening.h"

namespace remaps::codec {
namespace {

/// The mesh and its components: 32. Then a component: 24, its coarsenings, the best and those in
/// trial: 24, on the way of a step: 19. Or, most where there is no level, the base: 68.
constexpr std::uint64_t kBytesPerFace = 116, kBytesPerVertex = 16;
constexpr std::uint32_t kMostFaces = std::uint32_t{1} << 29;

std::string count(std::uint64_t n, const std::string& one) {
  return std::to_string(n) + " " + one + (n == 1 ? "" : "s");
}

[[noreturn]] void refuse_sides(std::span<const Face> faces, const SideClash& clash) {
  const auto [a, b] = clash;
  const Face& v = faces[a.face()];
  throw GeometryError("faces " + std::to_string(a.face()) + " and " + std::to_string(b.face()) +
                      " both have the edge from vertex " + std::to_string(v[a.corner()]) + " to " +
                      std::to_string(v[Side::next_corner(a.corner())]) +
                      " in the same direction, or a third has it too; subdivision connectivity is "
                      "looked for in oriented manifolds only");
}

void check_corners(std::uint32_t vertices, std::span<const Face> faces) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto [a, b, c] = faces[f];
    if (a >= vertices || b >= vertices || c >= vertices || a == b || b == c || c == a) {
      throw GeometryError("face " + std::to_string(f) +
                          " does not have three different corners among the " +
                          std::to_string(vertices) +
                          " vertices; subdivision connectivity is looked for "
                          "in oriented manifolds only");
    }
  }
}

/// The faces that a walk about the side's first vertex meets.
std::uint32_t faces_about(const JoinedFaces& mesh, Side first) {
  std::uint32_t met = 1;
  Side s = first;
  for (; !mesh.twin_of(s.previous()).none(); ++met) {
    s = mesh.twin_of(s.previous());
    if (s == first) return met;
  }
  for (s = first; !mesh.twin_of(s).none(); ++met) s = mesh.twin_of(s).next();
  return met;
}

void check_fans(const JoinedFaces& mesh) {
  std::vector<std::uint32_t> about(mesh.vertices, 0);
  for (const Face& face : mesh.vertex) {
    for (const std::uint32_t v : face) ++about[v];
  }
  const auto lonely = std::find(about.begin(), about.end(), 0);
  if (lonely != about.end()) {
    throw GeometryError("vertex " + std::to_string(lonely - about.begin()) +
                        " has no face; a subdivided mesh has none of that kind");
  }
  for (std::uint32_t f = 0; f < mesh.faces(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      std::uint32_t& left = about[mesh.vertex[f][k]];
      if (left == 0) continue;
      if (faces_about(mesh, {f, k}) != left) {
        throw GeometryError("the faces at vertex " + std::to_string(mesh.vertex[f][k]) +
                            " are not one fan or disc; subdivision connectivity is looked for in "
                            "oriented manifolds only");
      }
      left = 0;
    }
  }
}

/// The finest mesh, and its faces component by component.
struct Components {
  JoinedFaces mesh;
  std::vector<std::uint32_t> face;   // (faces) by component, then by number
  std::vector<std::uint32_t> start;  // (components + 1)
  std::vector<std::uint32_t> local;  // (faces) place in its component

  std::size_t size() const { return start.size() - 1; }
  std::span<const std::uint32_t> faces_of(std::size_t c) const {
    return std::span(face).subspan(start[c], start[c + 1] - start[c]);
  }

  /// A component by itself, its vertices in the order in which its faces have them.
  /// @param number  (vertices) scratch
  JoinedFaces extract(std::size_t c, std::vector<std::uint32_t>& number) const {
    const auto faces = faces_of(c);
    JoinedFaces part;
    part.vertex.resize(faces.size());
    part.twin.resize(faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        std::uint32_t& v = number[mesh.vertex[faces[i]][k]];
        if (v == kNoIndex) v = part.vertices++;
        part.vertex[i][k] = v;
        const Side twin = mesh.twin[faces[i]][k];
        if (!twin.none()) part.twin[i][k] = {local[twin.face()], twin.corner()};
      }
    }
    return part;
  }
};

Components split_components(JoinedFaces&& mesh) {
  Components result;
  result.mesh = std::move(mesh);
  const JoinedFaces& all = result.mesh;
  std::vector<bool> met(all.faces(), false);
  result.face.reserve(all.faces());
  result.local.resize(all.faces());
  for (std::uint32_t seed = 0; seed < all.faces(); ++seed) {
    if (met[seed]) continue;
    const std::size_t first = result.face.size();
    result.start.push_back(static_cast<std::uint32_t>(first));
    result.face.push_back(seed);
    met[seed] = true;
    for (std::size_t i = first; i < result.face.size(); ++i) {
      for (const Side twin : all.twin[result.face[i]]) {
        if (twin.none() || met[twin.face()]) continue;
        met[twin.face()] = true;
        result.face.push_back(twin.face());
      }
    }
    std::sort(result.face.begin() + static_cast<std::ptrdiff_t>(first), result.face.end());
    for (std::size_t i = first; i < result.face.size(); ++i) {
      result.local[result.face[i]] = static_cast<std::uint32_t>(i - first);
    }
  }
  result.start.push_back(all.faces());
  return result;
}

/// The children of each face, for each of several steps from the finest on.
using Coarsenings = std::vector<std::vector<Children>>;

/// The most steps that a component allows, up to `most`. The recursion is bounded by that, and its
/// cost by the four trials a step that each leave a quarter of the faces. A mesh with double edges
/// ends it: what that is the subdivision of has some too, or is two faces back to back, whose
/// subdivisions all have some.
Coarsenings deepest(const JoinedFaces& mesh, unsigned most) {
  Coarsenings best;
  for (unsigned part = 0; part < 4 && best.size() < most; ++part) {
    auto step = coarsen(mesh, part);
    if (!step || !is_simple(step->coarse)) continue;
    Coarsenings way = deepest(step->coarse, most - 1);
    if (way.size() + 1 <= best.size()) continue;
    way.insert(way.begin(), std::move(step->child));
    best = std::move(way);
  }
  return best;
}

[[noreturn]] void refuse(const Components& parts, std::size_t component, unsigned levels,
                         unsigned least) {
  const auto faces = parts.faces_of(component);
  std::string which = "its " + count(faces.size(), "face");
  if (parts.size() > 1) {
    which = "the " + count(faces.size(), "face") + " of the component with face " +
            std::to_string(faces.front());
  }
  if (levels > 0) {
    throw GeometryError("the mesh has subdivision connectivity of " + count(levels, "level") +
                        " only, and at least " + std::to_string(least) + " are needed: " + which +
                        " cannot be joined by fours more often");
  }
  const std::string why =
      faces.size() % 4 != 0
          ? " are not a multiple of 4"
          : " cannot be joined by fours so that a mesh without double edges is left and all "
            "vertices that go have 6 edges, or 4 on the boundary";
  throw GeometryError("the mesh has no subdivision connectivity: " + which + why);
}

/// Puts faces into the order of a walk that turns right where it can, then left, each beginning at
/// the side that it came from; vertices in the order in which the faces have them.
/// @param order  (base faces) old number, and the corner that is now the first
/// @param old    (base vertices)
void walk(const JoinedFaces& mesh, std::vector<Side>& order, std::vector<std::uint32_t>& old) {
  std::vector<bool> met(mesh.faces(), false);
  std::vector<std::uint32_t> number(mesh.vertices, kNoIndex);
  std::vector<Side> waiting;
  for (std::uint32_t seed = 0; seed < mesh.faces(); ++seed) {
    waiting.emplace_back(seed, 0);
    while (!waiting.empty()) {
      const Side s = waiting.back();
      waiting.pop_back();
      if (met[s.face()]) continue;
      met[s.face()] = true;
      order.push_back(s);
      for (const Side side : {s, s.previous(), s.next()}) {
        const Side twin = mesh.twin_of(side);
        if (!twin.none() && !met[twin.face()]) waiting.push_back(twin);
      }
      for (const Side corner : {s, s.next(), s.previous()}) {
        const std::uint32_t v = mesh.from(corner);
        if (number[v] != kNoIndex) continue;
        number[v] = static_cast<std::uint32_t>(old.size());
        old.push_back(v);
      }
    }
  }
}

Side turned(Side side, std::uint32_t corners) {
  return {side.face(), (side.corner() + corners) % 3};
}

/// From faces of a hierarchy, each with the corner of the coarse face that is its corner 0, to
/// their children.
std::vector<Side> descend(std::span<const Side> coarse, std::span<const Children> child) {
  std::vector<Side> fine;
  fine.reserve(4 * coarse.size());
  for (const Side face : coarse) {
    const Children& four = child[face.face()];
    for (std::uint32_t k = 0; k < 3; ++k) {
      // Child k has the coarse vertex at corner k.
      fine.push_back(turned(four[(face.corner() + k) % 3], 3 - k));
    }
    fine.push_back(turned(four[3], face.corner()));
  }
  return fine;
}

class Recovery {
 public:
  Recovery(const Components& parts, unsigned least, unsigned most) : parts_(parts), levels_(most) {
    std::vector<std::uint32_t> number(parts.mesh.vertices, kNoIndex);
    for (std::size_t c = 0; c < parts.size() && levels_ > 0; ++c) {
      ways_.push_back(deepest(parts.extract(c, number), levels_));
      levels_ = static_cast<unsigned>(ways_.back().size());
      if (levels_ < least) refuse(parts, c, levels_, least);
    }
    ways_.resize(parts.size());
  }

  SemiRegularConnectivity result(MemoryBudget& budget) const {
    SemiRegularConnectivity result;
    result.levels = levels_;
    const std::vector<Side> finest = order_base(result);
    const SubdivisionHierarchy hierarchy(result.base_vertices, result.base, levels_, budget);
    if (hierarchy.vertices() != parts_.mesh.vertices) {
      throw std::logic_error("recovered hierarchy has another number of vertices");
    }
    result.vertex.assign(hierarchy.vertices(), kNoIndex);
    for (std::uint32_t f = 0; f < finest.size(); ++f) {
      const Face vertex = hierarchy.finest_face(f);
      for (std::uint32_t k = 0; k < 3; ++k) {
        std::uint32_t& given = result.vertex[vertex[k]];
        const std::uint32_t here = parts_.mesh.from(turned(finest[f], k));
        if (given != kNoIndex && given != here) {
          throw std::logic_error("recovered hierarchy does not agree with its mesh");
        }
        given = here;
      }
    }
    return result;
  }

 private:
  /// The vertex of the finest mesh at a corner of a coarse face.
  std::uint32_t vertex_at(std::size_t component, Side corner) const {
    for (unsigned i = levels_; i-- > 0;) {
      corner = ways_[component][i][corner.face()][corner.corner()];
    }
    return parts_.mesh.from({parts_.faces_of(component)[corner.face()], corner.corner()});
  }

  /// Fills in the base; gives the face of the given mesh for each of the finest faces of the
  /// hierarchy, with the corner that is the first there.
  std::vector<Side> order_base(SemiRegularConnectivity& result) const {
    std::vector<std::uint32_t> number(parts_.mesh.vertices, kNoIndex);
    JoinedFaces base;
    std::vector<std::uint32_t> start;
    for (std::size_t c = 0; c < parts_.size(); ++c) {
      start.push_back(base.faces());
      const std::size_t faces = parts_.faces_of(c).size() >> (2 * levels_);
      for (std::uint32_t f = 0; f < faces; ++f) {
        Face face;
        for (std::uint32_t k = 0; k < 3; ++k) {
          std::uint32_t& v = number[vertex_at(c, {f, k})];
          if (v == kNoIndex) v = base.vertices++;
          face[k] = v;
        }
        base.vertex.push_back(face);
      }
    }
    start.push_back(base.faces());
    if (join_sides(base.vertices, base.vertex, base.twin)) {
      throw std::logic_error("recovered base is not a manifold");
    }
    std::vector<Side> order;
    std::vector<std::uint32_t> old;
    walk(base, order, old);
    for (std::uint32_t v = 0; v < old.size(); ++v) number[old[v]] = v;
    result.base_vertices = base.vertices;
    for (const Side s : order) {
      result.base.push_back(
          {number[base.from(s)], number[base.from(s.next())], number[base.from(s.previous())]});
    }
    return refine(order, start);
  }

  std::vector<Side> refine(std::span<const Side> order,
                           std::span<const std::uint32_t> start) const {
    std::vector<Side> finest;
    finest.reserve(parts_.mesh.faces());
    for (std::size_t c = 0; c < parts_.size(); ++c) {
      std::vector<Side> faces;
      for (std::uint32_t i = start[c]; i < start[c + 1]; ++i) {
        faces.emplace_back(order[i].face() - start[c], order[i].corner());
      }
      for (unsigned i = levels_; i-- > 0;) faces = descend(faces, ways_[c][i]);
      for (const Side s : faces) finest.emplace_back(parts_.faces_of(c)[s.face()], s.corner());
    }
    return finest;
  }

  const Components& parts_;
  std::vector<Coarsenings> ways_;  // (components)
  unsigned levels_;
};

}  // namespace

SemiRegularConnectivity recover_subdivision(std::uint32_t vertices, std::span<const Face> faces,
                                            unsigned least_levels, unsigned most_levels,
                                            MemoryBudget& budget) {
  const unsigned most = std::min(most_levels, SubdivisionHierarchy::kMostLevels);
  if (least_levels > most) throw std::invalid_argument("more levels asked for than allowed");
  if (faces.empty() || faces.size() >= kMostFaces || vertices > 3 * faces.size()) {
    throw GeometryError("a mesh of " + count(faces.size(), "face") + " and " +
                        std::to_string(vertices) +
                        " vertices is empty, larger than can be numbered, or has vertices without "
                        "a face; none of these is looked at for subdivision");
  }
  const Reservation memory = budget.reserve(
      faces.size() * kBytesPerFace + vertices * kBytesPerVertex, "looking for the subdivision");
  check_corners(vertices, faces);
  JoinedFaces mesh{vertices, {faces.begin(), faces.end()}, {}};
  if (const auto clash = join_sides(vertices, faces, mesh.twin)) refuse_sides(faces, *clash);
  check_fans(mesh);
  const Components parts = split_components(std::move(mesh));
  return Recovery(parts, least_levels, most).result(budget);
}

}  // namespace remaps::codec
