#include "codec/semi_regular_shapes.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace remaps::test {

codec::SemiRegularMesh rough_mesh(const CodecBase& base, unsigned levels, double roughness,
                                  std::uint64_t seed) {
  MemoryBudget budget(kCodecMemory);
  const codec::SubdivisionHierarchy hierarchy(base.vertices(), base.face, levels, budget);
  codec::SemiRegularMesh mesh;
  mesh.base_vertices = base.vertices();
  mesh.base = base.face;
  mesh.levels = levels;
  Box3 box;
  for (const Vec3& p : base.position) box.add(p);
  std::mt19937_64 random(seed);
  mesh.position = random_values(hierarchy.vertices(), random);
  double size = roughness * box.diagonal();
  std::uint32_t v = 0;
  for (; v < base.vertices(); ++v) mesh.position[v] = base.position[v];
  for (unsigned m = 1; m <= levels; ++m, size /= 4) {
    for (; v < hierarchy.vertices(m); ++v) mesh.position[v] = size * mesh.position[v];
  }
  codec::from_details(hierarchy, codec::Wavelet::kButterfly, levels, mesh.position);
  return mesh;
}

void add_signals(codec::SemiRegularMesh& mesh) {
  codec::Signal colour{codec::SignalKind::kColour, {}}, normal{codec::SignalKind::kNormal, {}};
  for (const Vec3& p : mesh.position) {
    const double length = norm(p);
    colour.value.push_back({0.5 + 0.5 * std::sin(p.x), 0.5 + 0.5 * std::cos(p.y), 0.25});
    normal.value.push_back(length > 0 ? 1 / length * p : Vec3{0, 0, 1});
  }
  mesh.signals = {colour, normal};
}

store::Bytes encode(const codec::SemiRegularMesh& mesh, const codec::EncodeOptions& options) {
  MemoryBudget budget(kCodecMemory);
  return codec::encode_mesh(mesh, options, budget);
}

codec::SemiRegularMesh decode(store::ByteSpan bytes, std::uint64_t prefix) {
  MemoryBudget budget(kCodecMemory);
  const codec::Archive archive(bytes, "archive");
  return archive.decode(prefix, archive.header().levels, budget);
}

double diagonal_of(const codec::SemiRegularMesh& mesh) {
  Box3 box;
  for (const Vec3& p : mesh.position) box.add(p);
  return box.diagonal();
}

double largest_distance(const codec::SemiRegularMesh& a, const codec::SemiRegularMesh& b) {
  double largest = a.position.size() == b.position.size() ? 0 : HUGE_VAL;
  for (std::size_t v = 0; v < std::min(a.position.size(), b.position.size()); ++v) {
    largest = std::fmax(largest, norm(a.position[v] - b.position[v]));
  }
  return largest;
}

bool is_finite(std::span<const Vec3> values) {
  return std::all_of(values.begin(), values.end(), [](const Vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  });
}

}  // namespace remaps::test
