#include "remaps/generate/base_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace remaps {
namespace {

ShapeMesh make_icosahedron() {
  const double p = std::numbers::phi;
  ShapeMesh mesh;
  mesh.positions = {{-1, p, 0},  {1, p, 0},  {-1, -p, 0}, {1, -p, 0}, {0, -1, p},  {0, 1, p},
                    {0, -1, -p}, {0, 1, -p}, {p, 0, -1},  {p, 0, 1},  {-p, 0, -1}, {-p, 0, 1}};
  for (Vec3& v : mesh.positions) v = 1 / norm(v) * v;
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7}, {0, 7, 10}, {0, 10, 11},
                    {11, 10, 2}, {5, 11, 4}, {1, 5, 9}, {7, 1, 8},  {10, 7, 6},
                    {4, 11, 2},  {9, 5, 4},  {8, 1, 9}, {6, 7, 8},  {2, 10, 6},
                    {3, 4, 2},   {3, 9, 4},  {3, 8, 9}, {3, 6, 8},  {3, 2, 6}};
  mesh.spherical = true;
  return mesh;
}

/// The icosahedron less its vertex 0: the others move down by one.
ShapeMesh make_disk() {
  ShapeMesh mesh = make_icosahedron();
  mesh.positions.erase(mesh.positions.begin());
  std::erase_if(mesh.triangles, [](const Triangle& t) { return t[0] == 0; });
  for (Triangle& t : mesh.triangles)
    for (VertexId& v : t) --v;
  return mesh;
}

void add_quad(ShapeMesh& mesh, VertexId a, VertexId b, VertexId c, VertexId d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

ShapeMesh make_torus() {
  constexpr VertexId kAround = 12;
  constexpr VertexId kTube = 6;
  constexpr double kTubeRadius = 0.45;
  const auto angle_rad = [](VertexId i, VertexId n) {
    return 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
  };
  const auto id = [](VertexId i, VertexId j) { return (i % kAround) * kTube + j % kTube; };
  ShapeMesh mesh;
  for (VertexId i = 0; i < kAround; ++i) {
    for (VertexId j = 0; j < kTube; ++j) {
      const double u = angle_rad(i, kAround);
      const double v = angle_rad(j, kTube);
      const double radius = 1 + kTubeRadius * std::cos(v);
      mesh.positions.push_back(
          {radius * std::cos(u), radius * std::sin(u), kTubeRadius * std::sin(v)});
      add_quad(mesh, id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
    }
  }
  return mesh;
}

/// Moves every vertex half way to the mean of its neighbours, all at once.
void smooth(ShapeMesh& mesh) {
  std::vector<Vec3> sums(mesh.positions.size());
  std::vector<double> valences(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sums[t[k]] = sums[t[k]] + mesh.positions[t[(k + 1) % 3]];
      ++valences[t[k]];
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v)
    mesh.positions[v] = 0.5 * (mesh.positions[v] + 1 / valences[v] * sums[v]);
}

/// Divides every triangle into four at the middles of its edges.
ShapeMesh subdivided(const ShapeMesh& mesh) {
  ShapeMesh result{mesh.positions, {}, mesh.spherical};
  std::map<std::pair<VertexId, VertexId>, VertexId> ids;
  const auto middle = [&](VertexId a, VertexId b) {
    const auto [at, is_new] = ids.try_emplace(std::minmax(a, b), result.positions.size());
    if (is_new) result.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    return at->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const VertexId ab = middle(a, b);
    const VertexId bc = middle(b, c);
    const VertexId ca = middle(c, a);
    result.triangles.insert(result.triangles.end(),
                            {{a, ab, ca}, {ab, b, bc}, {ab, bc, ca}, {ca, bc, c}});
  }
  return result;
}

/// The surface of a slab of 5 x 3 x 1 unit cubes without the two that make its holes.
ShapeMesh make_double_torus() {
  const auto solid = [](int x, int y, int z) {
    const bool hole = y == 1 && (x == 1 || x == 3);
    return x >= 0 && x < 5 && y >= 0 && y < 3 && z == 0 && !hole;
  };
  ShapeMesh mesh;
  std::map<std::array<int, 3>, VertexId> ids;
  const auto id = [&](int x, int y, int z) {
    const auto [at, is_new] = ids.try_emplace({x, y, z}, mesh.positions.size());
    if (is_new) mesh.positions.push_back({x - 2.5, y - 1.5, 1.4 * (z - 0.5)});
    return at->second;
  };
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 3; ++y) {
      if (!solid(x, y, 0)) continue;
      const auto side = [&](int dx, int dy, std::array<int, 2> a, std::array<int, 2> b) {
        if (solid(x + dx, y + dy, 0)) return;
        add_quad(mesh, id(x + a[0], y + a[1], 0), id(x + b[0], y + b[1], 0),
                 id(x + b[0], y + b[1], 1), id(x + a[0], y + a[1], 1));
      };
      add_quad(mesh, id(x, y, 1), id(x + 1, y, 1), id(x + 1, y + 1, 1), id(x, y + 1, 1));
      add_quad(mesh, id(x, y, 0), id(x, y + 1, 0), id(x + 1, y + 1, 0), id(x + 1, y, 0));
      side(0, -1, {0, 0}, {1, 0});
      side(1, 0, {1, 0}, {1, 1});
      side(0, 1, {1, 1}, {0, 1});
      side(-1, 0, {0, 1}, {0, 0});
    }
  }
  mesh = subdivided(mesh);
  for (int pass = 0; pass < 3; ++pass) smooth(mesh);
  return mesh;
}

}  // namespace

std::optional<BaseShape> base_shape_named(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, BaseShape>, 4> kNames{
      {{"icosahedron", BaseShape::kIcosahedron},
       {"torus", BaseShape::kTorus},
       {"double-torus", BaseShape::kDoubleTorus},
       {"disk", BaseShape::kDisk}}};
  for (const auto& [known, shape] : kNames)
    if (known == name) return shape;
  return std::nullopt;
}

ShapeMesh make_base_mesh(BaseShape shape) {
  switch (shape) {
    case BaseShape::kTorus:
      return make_torus();
    case BaseShape::kDoubleTorus:
      return make_double_torus();
    case BaseShape::kDisk:
      return make_disk();
    case BaseShape::kIcosahedron:
      break;
  }
  return make_icosahedron();
}

}  // namespace remaps
