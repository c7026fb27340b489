#include "remaps/codec/semi_regular_mesh.h"

#include <span>
#include <utility>

#include "remaps/codec/base_code.h"

namespace remaps::codec {
namespace {

/// Copies values to where the vertices are when the base is in another order.
class Reordering {
 public:
  Reordering(const BaseOrder& order, unsigned levels) : order_(order), levels_(levels) {}

  bool is_identity() const {
    for (std::size_t v = 0; v < order_.vertex.size(); ++v) {
      if (order_.vertex[v] != v) return false;
    }
    for (std::size_t f = 0; f < order_.face.size(); ++f) {
      if (order_.face[f] != f || order_.rotation[f] != 0) return false;
    }
    return true;
  }

  std::vector<Face> base(std::span<const Face> faces) const {
    std::vector<Face> result(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        result[order_.face[f]][(k + order_.rotation[f]) % 3] = order_.vertex[faces[f][k]];
      }
    }
    return result;
  }

  /// Children turn with their parents: child k becomes child k + rotation, the middle one stays.
  std::vector<Vec3> values(const SubdivisionHierarchy& from, const SubdivisionHierarchy& to,
                           std::span<const Vec3> x) const {
    std::vector<Vec3> result(x.size());
    const std::uint64_t children = std::uint64_t{1} << (2 * levels_);
    for (std::uint64_t i = 0; i < from.faces(); ++i) {
      const auto f = static_cast<std::size_t>(i >> (2 * levels_));
      const std::uint32_t turn = order_.rotation[f];
      std::uint64_t path = i & (children - 1);
      if (turn != 0) {
        std::uint64_t turned = 0;
        for (unsigned shift = 0; shift < 2 * levels_; shift += 2) {
          const std::uint64_t digit = path >> shift & 3;
          turned |= (digit == 3 ? 3 : (digit + turn) % 3) << shift;
        }
        path = turned;
      }
      const Face source = from.finest_face(i);
      const Face target = to.finest_face(order_.face[f] * children + path);
      for (std::uint32_t k = 0; k < 3; ++k) result[target[(k + turn) % 3]] = x[source[k]];
    }
    return result;
  }

 private:
  const BaseOrder& order_;
  unsigned levels_;
};

}  // namespace

SemiRegularMesh in_coding_order(SemiRegularMesh mesh, MemoryBudget& budget) {
  const BaseOrder order = order_base(mesh.base_vertices, mesh.base);
  const Reordering reordering(order, mesh.levels);
  if (reordering.is_identity()) return mesh;
  std::vector<Face> base = reordering.base(mesh.base);
  const SubdivisionHierarchy from(mesh.base_vertices, mesh.base, mesh.levels, budget);
  const SubdivisionHierarchy to(mesh.base_vertices, base, mesh.levels, budget);
  mesh.position = reordering.values(from, to, mesh.position);
  for (Signal& signal : mesh.signals) signal.value = reordering.values(from, to, signal.value);
  mesh.base = std::move(base);
  return mesh;
}

}  // namespace remaps::codec
