// isosurface VOLUME NX NY NZ SX SY SZ LEVEL OUTPUT.ply: the surface where a volume of bytes, x
// fastest, passes LEVEL, which must not be whole. Outside the volume is 0, so the surface is
// closed.
//
// Marching cubes whose table is generated: on an ambiguous face of a cube the corners inside are
// always separated, and no diagonal of a loop lies in a face of the cube, so the result is
// manifold.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <stdexcept>
#include <vector>

#include "remaps/formats/mesh_writer.h"

namespace {

using namespace remaps;

/// Edges of a cube by number. Corners: bit 0 is x, bit 1 y, bit 2 z.
using Loop = std::vector<int>;
using EdgeTriangle = std::array<int, 3>;

struct Cube {
  std::array<std::array<int, 2>, 12> edges{};   ///< lower and upper corner
  std::array<std::array<int, 8>, 8> edge_at{};  ///< between two corners
  std::vector<std::array<int, 4>> faces;        ///< corners, counter-clockwise from outside

  Cube() {
    int count = 0;
    for (int a = 0; a < 8; ++a) {
      for (int axis = 0; axis < 3; ++axis) {
        if ((a >> axis & 1) != 0) continue;
        const int b = a | 1 << axis;
        edges[size_t(count)] = {a, b};
        edge_at[size_t(a)][size_t(b)] = edge_at[size_t(b)][size_t(a)] = count++;
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, w = 1 << axis;
      faces.push_back({w, w | u, w | u | v, w | v});
      faces.push_back({0, v, u | v, u});
    }
  }

  bool share_a_face(int e, int f) const {
    const auto on = [&](const std::array<int, 4>& face, int edge) {
      return std::ranges::count_if(face, [&](int corner) {
               return corner == edges[size_t(edge)][0] || corner == edges[size_t(edge)][1];
             }) == 2;
    };
    return std::ranges::any_of(faces, [&](const auto& face) { return on(face, e) && on(face, f); });
  }
};

/// What one of the 256 cubes holds: triangles, and loops that need a vertex in their middle.
struct Case {
  std::vector<EdgeTriangle> triangles;
  std::vector<Loop> with_centre;
};

class CaseTable {
 public:
  CaseTable() {
    for (int inside = 0; inside < 256; ++inside) build(inside);
  }
  const Case& operator[](int inside) const { return cases_[size_t(inside)]; }
  const Cube& cube() const { return cube_; }

 private:
  /// Triangles of a loop without a diagonal in a face of the cube, if there are any.
  std::optional<std::vector<EdgeTriangle>> fill(const Loop& loop) const {
    const size_t n = loop.size();
    if (n == 3) return {{{loop[0], loop[1], loop[2]}}};
    for (size_t k = 1; k + 1 < n; ++k) {
      if (k != 1 && cube_.share_a_face(loop[0], loop[k])) continue;
      if (k != n - 2 && cube_.share_a_face(loop[n - 1], loop[k])) continue;
      std::vector<EdgeTriangle> triangles{{loop[n - 1], loop[0], loop[k]}};
      const auto add = [&](Loop part) {
        if (part.size() < 3) return true;
        const auto more = fill(part);
        if (more) triangles.insert(triangles.end(), more->begin(), more->end());
        return more.has_value();
      };
      const auto apex = loop.begin() + static_cast<std::ptrdiff_t>(k);
      if (add(Loop(loop.begin(), apex + 1)) && add(Loop(apex, loop.end()))) return triangles;
    }
    return std::nullopt;
  }

  /// For each edge crossed, the next one along the surface's loop; -1 for the others.
  std::array<int, 12> successors(int inside) const {
    std::array<int, 12> next;
    next.fill(-1);
    const auto is_in = [&](int corner) { return (inside >> corner & 1) != 0; };
    for (const auto& face : cube_.faces) {
      for (size_t i = 0; i < 4; ++i) {
        if (is_in(face[i]) || !is_in(face[(i + 1) % 4])) continue;
        size_t j = (i + 1) % 4;
        while (is_in(face[(j + 1) % 4])) j = (j + 1) % 4;
        const int enter = cube_.edge_at[size_t(face[i])][size_t(face[(i + 1) % 4])];
        const int leave = cube_.edge_at[size_t(face[j])][size_t(face[(j + 1) % 4])];
        next[size_t(leave)] = enter;
      }
    }
    return next;
  }

  void build(int inside) {
    const auto next = successors(inside);
    std::array<bool, 12> seen{};
    for (int e = 0; e < 12; ++e) {
      if (next[size_t(e)] < 0 || seen[size_t(e)]) continue;
      Loop loop;
      for (int x = e; !seen[size_t(x)]; x = next[size_t(x)]) {
        seen[size_t(x)] = true;
        loop.push_back(x);
      }
      add_loop(loop, cases_[size_t(inside)]);
    }
  }

  void add_loop(const Loop& loop, Case& result) const {
    Loop turned = loop;
    for (size_t r = 0; r < loop.size(); ++r) {
      if (const auto triangles = fill(turned)) {
        result.triangles.insert(result.triangles.end(), triangles->begin(), triangles->end());
        return;
      }
      std::rotate(turned.begin(), turned.begin() + 1, turned.end());
    }
    result.with_centre.push_back(loop);
  }

  Cube cube_;
  std::array<Case, 256> cases_;
};

struct Volume {
  std::array<long, 3> size{};
  std::array<double, 3> spacing{};
  std::vector<unsigned char> values;

  Volume(const char* path, std::array<long, 3> size_in, std::array<double, 3> spacing_in)
      : size(size_in), spacing(spacing_in) {
    for (const long n : size) {
      if (n < 1 || n > 4096) throw std::runtime_error("a side of the volume is not in 1 to 4096");
    }
    values.resize(size_t(size[0]) * size_t(size[1]) * size_t(size[2]));
    std::FILE* file = std::fopen(path, "rb");
    if (file == nullptr) throw std::runtime_error(fmt::format("{}: cannot be opened", path));
    const size_t got = std::fread(values.data(), 1, values.size(), file);
    std::fclose(file);
    if (got != values.size()) {
      throw std::runtime_error(fmt::format("{}: {} bytes, expected {}", path, got, values.size()));
    }
  }
};

class Marcher {
 public:
  Marcher(const Volume& volume, double level)
      : volume_(volume),
        level_(level),
        width_(volume.size[0] + 2),
        depth_(volume.size[1] + 2),
        height_(volume.size[2] + 2) {
    for (Slice& slice : slices_) slice.resize(size_t(width_ * depth_));
    along_z_.resize(size_t(width_ * depth_));
  }

  void run() {
    load(0);
    cross_in_plane(0);
    for (long k = 0; k + 1 < height_; ++k) {
      load(k + 1);
      cross_between(k);
      cross_in_plane(k + 1);
      for (long j = 0; j + 1 < depth_; ++j) {
        for (long i = 0; i + 1 < width_; ++i) march(i, j, k);
      }
    }
  }

  const std::vector<Vec3>& positions() const { return positions_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  /// A plane of the volume, framed by zeros, and the vertices on its edges.
  struct Slice {
    std::vector<double> values;
    std::vector<VertexId> along_x, along_y;
    void resize(size_t n) {
      values.resize(n);
      along_x.resize(n);
      along_y.resize(n);
    }
  };

  Slice& slice(long k) { return slices_[size_t(k & 1)]; }
  size_t at(long i, long j) const { return size_t(j * width_ + i); }

  void load(long k) {
    for (long j = 0; j < depth_; ++j) {
      for (long i = 0; i < width_; ++i) {
        const bool frame =
            i == 0 || j == 0 || k == 0 || i + 1 == width_ || j + 1 == depth_ || k + 1 == height_;
        const auto& [nx, ny, nz] = volume_.size;
        slice(k).values[at(i, j)] =
            frame ? 0 : volume_.values[size_t(((k - 1) * ny + j - 1) * nx + i - 1)];
      }
    }
  }

  bool crossed(double a, double b) const { return (a > level_) != (b > level_); }
  double crossing(double a, double b) const {
    return std::clamp((level_ - a) / (b - a), 1e-3, 1 - 1e-3);
  }

  VertexId add_vertex(double x, double y, double z) {
    positions_.push_back(
        {(x - 1) * volume_.spacing[0], (y - 1) * volume_.spacing[1], (z - 1) * volume_.spacing[2]});
    return positions_.size() - 1;
  }

  void cross_in_plane(long k) {
    Slice& s = slice(k);
    for (long j = 0; j < depth_; ++j) {
      for (long i = 0; i < width_; ++i) {
        const double a = s.values[at(i, j)];
        const double z = static_cast<double>(k);
        const double x = static_cast<double>(i), y = static_cast<double>(j);
        if (i + 1 < width_ && crossed(a, s.values[at(i + 1, j)])) {
          s.along_x[at(i, j)] = add_vertex(x + crossing(a, s.values[at(i + 1, j)]), y, z);
        }
        if (j + 1 < depth_ && crossed(a, s.values[at(i, j + 1)])) {
          s.along_y[at(i, j)] = add_vertex(x, y + crossing(a, s.values[at(i, j + 1)]), z);
        }
      }
    }
  }

  void cross_between(long k) {
    for (long j = 0; j < depth_; ++j) {
      for (long i = 0; i < width_; ++i) {
        const double a = slice(k).values[at(i, j)], b = slice(k + 1).values[at(i, j)];
        if (!crossed(a, b)) continue;
        along_z_[at(i, j)] = add_vertex(static_cast<double>(i), static_cast<double>(j),
                                        static_cast<double>(k) + crossing(a, b));
      }
    }
  }

  double corner_value(long i, long j, long k, int corner) {
    return slice(k + (corner >> 2)).values[at(i + (corner & 1), j + (corner >> 1 & 1))];
  }

  VertexId vertex_on(long i, long j, long k, int edge) {
    const auto [a, b] = table_.cube().edges[size_t(edge)];
    const size_t place = at(i + (a & 1), j + (a >> 1 & 1));
    Slice& s = slice(k + (a >> 2));
    if ((a ^ b) == 1) return s.along_x[place];
    if ((a ^ b) == 2) return s.along_y[place];
    return along_z_[place];
  }

  void march(long i, long j, long k) {
    int inside = 0;
    for (int corner = 0; corner < 8; ++corner) {
      if (corner_value(i, j, k, corner) > level_) inside |= 1 << corner;
    }
    const Case& found = table_[inside];
    for (const auto& [a, b, c] : found.triangles) {
      triangles_.push_back({vertex_on(i, j, k, a), vertex_on(i, j, k, b), vertex_on(i, j, k, c)});
    }
    for (const Loop& loop : found.with_centre) fan(i, j, k, loop);
  }

  void fan(long i, long j, long k, const Loop& loop) {
    Vec3 sum;
    for (const int edge : loop) {
      const auto [a, b] = table_.cube().edges[size_t(edge)];
      const double t = crossing(corner_value(i, j, k, a), corner_value(i, j, k, b));
      const auto along = [&](int bit) {
        return (a >> bit & 1) + t * ((b >> bit & 1) - (a >> bit & 1));
      };
      sum = sum + Vec3{static_cast<double>(i) + along(0), static_cast<double>(j) + along(1),
                       static_cast<double>(k) + along(2)};
    }
    const double n = static_cast<double>(loop.size());
    const VertexId centre = add_vertex(sum.x / n, sum.y / n, sum.z / n);
    for (size_t m = 0; m < loop.size(); ++m) {
      triangles_.push_back(
          {vertex_on(i, j, k, loop[m]), vertex_on(i, j, k, loop[(m + 1) % loop.size()]), centre});
    }
  }

  const Volume& volume_;
  double level_;
  long width_, depth_, height_;
  CaseTable table_;
  std::array<Slice, 2> slices_;
  std::vector<VertexId> along_z_;
  std::vector<Vec3> positions_;
  std::vector<Triangle> triangles_;
};

void run(char** argv) {
  const auto count = [&](int i) { return std::strtol(argv[i], nullptr, 10); };
  const auto real = [&](int i) { return std::strtod(argv[i], nullptr); };
  const Volume volume(argv[1], {count(2), count(3), count(4)}, {real(5), real(6), real(7)});
  const double level = real(8);
  if (!(level > 0) || level == std::floor(level)) {
    throw std::runtime_error("LEVEL must be above 0 and not whole, so that no value equals it");
  }
  Marcher marcher(volume, level);
  marcher.run();
  const auto writer =
      open_mesh_writer(argv[9], marcher.positions().size(), marcher.triangles().size());
  writer->write_positions(marcher.positions());
  writer->write_triangles(marcher.triangles());
  writer->close();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 10) {
    fmt::print(stderr, "usage: isosurface VOLUME NX NY NZ SX SY SZ LEVEL OUTPUT.ply\n");
    return 2;
  }
  try {
    run(argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "isosurface: {}\n", error.what());
    return 1;
  }
}
