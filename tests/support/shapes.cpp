#include "support/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

namespace remaps::test {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

Vec3 unit(const Vec3& p) {
  return (1 / norm(p)) * p;
}

/// Two triangles over the square of four vertices, counter-clockwise.
void add_square(Shape& s, LocalIndex a, LocalIndex b, LocalIndex c, LocalIndex d) {
  s.triangle.push_back({a, b, c});
  s.triangle.push_back({a, c, d});
}

}  // namespace

Shape tetrahedron() {
  return {"tetrahedron",
          {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
          {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
}

Shape octahedron() {
  Shape s{"octahedron", {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, {}};
  for (LocalIndex i = 0; i < 4; ++i) {
    s.triangle.push_back({i, (i + 1) % 4, 4});
    s.triangle.push_back({(i + 1) % 4, i, 5});
  }
  return s;
}

Shape icosphere(unsigned level) {
  const double g = std::numbers::phi;
  Shape s{"icosphere",
          {{-1, g, 0},
           {1, g, 0},
           {-1, -g, 0},
           {1, -g, 0},
           {0, -1, g},
           {0, 1, g},
           {0, -1, -g},
           {0, 1, -g},
           {g, 0, -1},
           {g, 0, 1},
           {-g, 0, -1},
           {-g, 0, 1}},
          {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  for (Vec3& p : s.position) p = unit(p);
  for (unsigned l = 0; l < level; ++l) {
    std::map<std::pair<LocalIndex, LocalIndex>, LocalIndex> middle;
    const auto between = [&](LocalIndex a, LocalIndex b) {
      const auto [at, fresh] = middle.try_emplace({std::min(a, b), std::max(a, b)},
                                                  static_cast<LocalIndex>(s.position.size()));
      if (fresh) s.position.push_back(unit(s.position[a] + s.position[b]));
      return at->second;
    };
    std::vector<LocalTriangle> finer;
    for (const LocalTriangle& t : s.triangle) {
      const LocalIndex ab = between(t[0], t[1]), bc = between(t[1], t[2]), ca = between(t[2], t[0]);
      finer.push_back({t[0], ab, ca});
      finer.push_back({ab, t[1], bc});
      finer.push_back({ca, bc, t[2]});
      finer.push_back({ab, bc, ca});
    }
    s.triangle = std::move(finer);
  }
  return s;
}

Shape torus(unsigned m, unsigned n) {
  Shape s{"torus", {}, {}};
  for (unsigned i = 0; i < m; ++i) {
    for (unsigned j = 0; j < n; ++j) {
      const double a = kTurn * i / m;
      const double b = kTurn * j / n;
      const double r = 1 + 0.4 * std::cos(b);
      s.position.push_back({r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b)});
      const auto at = [&](unsigned x, unsigned y) { return x % m * n + y % n; };
      add_square(s, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  s.euler_characteristic = 0;
  s.least_vertices = 7;  // the irreducible triangulations of the torus have 7 to 10 vertices
  s.most_vertices = 10;
  return s;
}

Shape disk(unsigned rings) {
  Shape s{"disk", {{0, 0, 0}}, {}};
  for (unsigned r = 1; r <= rings; ++r) {
    const auto inner = static_cast<LocalIndex>(r == 1 ? 0 : 1 + 3 * (r - 1) * (r - 2));
    const auto outer = static_cast<LocalIndex>(s.position.size());
    for (unsigned i = 0; i < 6 * r; ++i) {
      const double a = kTurn * i / (6 * r);
      s.position.push_back({r * std::cos(a) / rings, r * std::sin(a) / rings, 0});
    }
    for (unsigned side = 0; side < 6; ++side) {
      const auto out = [&](unsigned i) { return outer + (side * r + i) % (6 * r); };
      const auto in = [&](unsigned i) {
        return r == 1 ? 0u : inner + (side * (r - 1) + i) % (6 * (r - 1));
      };
      for (unsigned i = 0; i < r; ++i) {
        s.triangle.push_back({in(i), out(i), out(i + 1)});
        if (i + 1 < r) s.triangle.push_back({in(i), out(i + 1), in(i + 1)});
      }
    }
  }
  s.euler_characteristic = 1;
  s.boundary_loops = 1;
  s.least_vertices = s.most_vertices = 3;
  return s;
}

Shape annulus(unsigned around, unsigned across) {
  Shape s{"annulus", {}, {}};
  for (unsigned i = 0; i <= across; ++i) {
    for (unsigned j = 0; j < around; ++j) {
      const double r = 0.5 + 0.5 * i / across;
      const double a = kTurn * j / around;
      s.position.push_back({r * std::cos(a), r * std::sin(a), 0.2 * r});
      const auto at = [&](unsigned x, unsigned y) { return x * around + y % around; };
      if (i < across) add_square(s, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  s.euler_characteristic = 0;
  s.boundary_loops = 2;
  s.least_vertices = s.most_vertices = 6;
  return s;
}

Shape cone(unsigned valence) {
  Shape s{"cone", {{0, 0, 1}}, {}};
  for (LocalIndex i = 0; i < valence; ++i) {
    const double a = kTurn * i / valence;
    s.position.push_back({std::cos(a), std::sin(a), 0});
    s.triangle.push_back({0, 1 + i, 1 + (i + 1) % valence});
  }
  s.euler_characteristic = 1;
  s.boundary_loops = 1;
  s.least_vertices = s.most_vertices = 3;
  return s;
}

Shape bipyramid(unsigned valence) {
  Shape s = cone(valence);
  s.name = "bipyramid";
  s.position.push_back({0, 0, -1});
  for (LocalIndex i = 0; i < valence; ++i) {
    s.triangle.push_back({valence + 1, 1 + (i + 1) % valence, 1 + i});
  }
  s.euler_characteristic = 2;
  s.boundary_loops = 0;
  s.least_vertices = s.most_vertices = 4;
  return s;
}

Shape cube(unsigned n) {
  Shape s{"cube", {}, {}};
  std::map<std::array<unsigned, 3>, LocalIndex> index;
  const auto at = [&](unsigned side, unsigned i, unsigned j) {
    const unsigned axis = side / 2;
    std::array<unsigned, 3> place{};
    place[axis] = side % 2 * n;
    place[(axis + 1) % 3] = i;
    place[(axis + 2) % 3] = j;
    const auto [found, fresh] =
        index.try_emplace(place, static_cast<LocalIndex>(s.position.size()));
    if (fresh) {
      s.position.push_back(
          {2.0 * place[0] / n - 1, 2.0 * place[1] / n - 1, 2.0 * place[2] / n - 1});
    }
    return found->second;
  };
  for (unsigned side = 0; side < 6; ++side) {
    for (unsigned i = 0; i < n; ++i) {
      for (unsigned j = 0; j < n; ++j) {
        const LocalIndex a = at(side, i, j), b = at(side, i + 1, j);
        const LocalIndex c = at(side, i + 1, j + 1), d = at(side, i, j + 1);
        side % 2 == 1 ? add_square(s, a, b, c, d) : add_square(s, a, d, c, b);
      }
    }
  }
  return s;
}

Shape drum(unsigned rings, unsigned across) {
  Shape s = disk(rings);
  s.name = "drum";
  for (Vec3& p : s.position) p.z = 1;
  const auto lid = static_cast<LocalIndex>(s.position.size());
  const LocalIndex around = 6 * rings;
  const std::vector<LocalTriangle> top = s.triangle;
  for (LocalIndex v = 0; v < lid; ++v) s.position.push_back({s.position[v].x, s.position[v].y, 0});
  for (const LocalTriangle& t : top) s.triangle.push_back({t[0] + lid, t[2] + lid, t[1] + lid});
  const auto wall = static_cast<LocalIndex>(s.position.size());
  const auto at = [&](LocalIndex row, LocalIndex i) {
    if (row == 0) return 2 * lid - around + i % around;
    if (row == across) return lid - around + i % around;
    return wall + (row - 1) * around + i % around;
  };
  for (LocalIndex row = 0; row < across; ++row) {
    for (LocalIndex i = 0; i < around; ++i) {
      if (row > 0) {
        const Vec3& p = s.position[at(0, i)];
        s.position.push_back({p.x, p.y, double(row) / across});
      }
      add_square(s, at(row, i), at(row, i + 1), at(row + 1, i + 1), at(row + 1, i));
    }
  }
  s.euler_characteristic = 2;
  s.boundary_loops = 0;
  return s;
}

Shape together(const Shape& a, const Shape& b) {
  Shape s = a;
  s.name = a.name + " and " + b.name;
  const auto base = static_cast<LocalIndex>(a.position.size());
  for (const Vec3& p : b.position) s.position.push_back(p + Vec3{5, 1, 0});
  for (const LocalTriangle& t : b.triangle) {
    s.triangle.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
  s.euler_characteristic += b.euler_characteristic;
  s.components += b.components;
  s.boundary_loops += b.boundary_loops;
  s.least_vertices += b.least_vertices;
  s.most_vertices += b.most_vertices;
  return s;
}

std::vector<Shape> all_shapes() {
  return {tetrahedron(),
          octahedron(),
          icosphere(2),
          torus(9, 7),
          disk(4),
          annulus(9, 3),
          cone(40),
          bipyramid(40),
          together(icosphere(1), disk(3)),
          together(torus(8, 6), annulus(7, 2))};
}

void add_noise(Shape& shape, double amount, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> offset(-amount, amount);
  for (Vec3& p : shape.position) {
    p.x += offset(random);
    p.y += offset(random);
    p.z += offset(random);
  }
}

Shape bumpy(Shape shape, double waves, double noise, std::uint64_t seed) {
  for (Vec3& p : shape.position) {
    const double wave = std::sin(5 * p.x + 1) * std::sin(4 * p.y + 2) + std::sin(6 * p.z * p.x);
    p = (1 + waves * wave) * p;
    p.z += waves * std::sin(4 * p.x) * std::cos(3 * p.y);
  }
  add_noise(shape, noise, seed);
  return shape;
}

double diagonal_of(const Shape& shape) {
  Box3 box;
  for (const Vec3& p : shape.position) box.add(p);
  return box.diagonal();
}

}  // namespace remaps::test
