#include "remaps/sphere/octahedral_unfolding.h"

#include <cmath>
#include <numbers>

namespace remaps::sphere {

Vec3 octahedral_direction(double x, double y) {
  const double across = std::fabs(x), up = std::fabs(y);
  const double height = 1 - across - up;  // on the octahedron
  const double r = 1 - std::fabs(height);
  const double angle = (r > 0 ? (up - across) / r + 1 : 1) * std::numbers::pi / 4;
  const double z = std::copysign(1 - r * r, height);
  const double ring = r * std::sqrt(2 - r * r);
  const Vec3 p{std::copysign(ring * std::cos(angle), x), std::copysign(ring * std::sin(angle), y),
               z};
  return 1 / norm(p) * p;
}

}  // namespace remaps::sphere
