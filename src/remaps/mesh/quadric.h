#pragma once

#include <array>

#include "remaps/base/geometry.h"

namespace remaps {

/// Quadratic form of area-weighted squared distances to planes (length^4), centred at the vertex
/// that carries it: the argument is an offset from that vertex. Centring is what lets floats
/// suffice. Source: Garland, Heckbert, Surface Simplification Using Quadric Error Metrics,
/// SIGGRAPH 97.
struct Quadric {
  // a00 a11 a22 a01 a02 a12 b0 b1 b2 c: x'Ax + 2 b'x + c
  std::array<float, 10> q{};

  /// The plane with unit normal n at signed distance d from the vertex.
  void add_plane(const Vec3& n, double d, double weight) {
    const std::array<double, 10> plane{n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z,
                                       n.y * n.z, n.x * d,   n.y * d,   n.z * d,   d * d};
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += static_cast<float>(weight * plane[i]);
  }

  /// Value at an offset; never negative.
  double operator()(const Vec3& x) const {
    const double value = q[0] * x.x * x.x + q[1] * x.y * x.y + q[2] * x.z * x.z +
                         2 * (q[3] * x.x * x.y + q[4] * x.x * x.z + q[5] * x.y * x.z) +
                         2 * (q[6] * x.x + q[7] * x.y + q[8] * x.z) + q[9];
    return value > 0 ? value : 0;
  }

  /// Adds the quadric of a vertex that lies at `offset` from this one.
  void add_translated(const Quadric& other, const Vec3& offset) {
    // other(x - offset) = (x - o)'A(x - o) + 2 b'(x - o) + c
    const Vec3 ao{other.q[0] * offset.x + other.q[3] * offset.y + other.q[4] * offset.z,
                  other.q[3] * offset.x + other.q[1] * offset.y + other.q[5] * offset.z,
                  other.q[4] * offset.x + other.q[5] * offset.y + other.q[2] * offset.z};
    for (std::size_t i = 0; i < 6; ++i) q[i] += other.q[i];
    q[6] += static_cast<float>(other.q[6] - ao.x);
    q[7] += static_cast<float>(other.q[7] - ao.y);
    q[8] += static_cast<float>(other.q[8] - ao.z);
    q[9] += static_cast<float>(other(Vec3{} - offset));
  }
};

}  // namespace remaps
