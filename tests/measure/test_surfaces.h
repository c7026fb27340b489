#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/triangle_stream.h"

namespace remaps::test {

using Soup = std::vector<TrianglePositions>;

/// Streams a soup, which must outlive the source, in chunks of a size.
inline TriangleSource source_of(const Soup& soup, std::size_t chunk = 10'000) {
  return [&soup, chunk](TriangleSink sink) {
    for (std::size_t i = 0; i < soup.size(); i += chunk) {
      sink(std::span(soup).subspan(i, std::min(chunk, soup.size() - i)));
    }
  };
}

/// A sphere of 4 n (n - 1) triangles with bumps, its vertices moved along the radius by up to noise
/// either way.
inline Soup bumpy_sphere(std::size_t n, double noise, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> offset(-noise, noise);
  const double step = std::numbers::pi / static_cast<double>(n);
  std::vector<Vec3> grid;
  for (std::size_t i = 0; i <= n; ++i) {
    for (std::size_t j = 0; j < 2 * n; ++j) {
      const double theta = step * static_cast<double>(i);
      const double phi = step * static_cast<double>(j);
      const double bump = 0.1 * std::sin(5 * theta) * std::sin(4 * phi) + offset(random);
      const double r = 1 + (i == 0 || i == n ? 0.0 : bump);
      grid.push_back({r * std::sin(theta) * std::cos(phi), r * std::sin(theta) * std::sin(phi),
                      r * std::cos(theta)});
    }
  }
  Soup soup;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < 2 * n; ++j) {
      const std::size_t k = (j + 1) % (2 * n);
      const Vec3 a = grid[2 * n * i + j], b = grid[2 * n * (i + 1) + j];
      const Vec3 c = grid[2 * n * (i + 1) + k], d = grid[2 * n * i + k];
      if (i + 1 < n) soup.push_back({a, b, c});
      if (i > 0) soup.push_back({a, c, d});
    }
  }
  return soup;
}

/// The square [x, x + 1] x [0, 1] at a height.
inline Soup square(double x, double z) {
  const Vec3 a{x, 0, z}, b{x + 1, 0, z}, c{x + 1, 1, z}, d{x, 1, z};
  return {{a, b, c}, {a, c, d}};
}

}  // namespace remaps::test
