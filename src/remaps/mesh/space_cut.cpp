#include "remaps/mesh/space_cut.h"

#include <algorithm>
#include <limits>

namespace remaps {
namespace {

float coordinate(const Vec3f& p, std::uint32_t axis) {
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/// An orthonormal frame for a level: a rotation by fixed angles that no two levels share.
std::array<Vec3f, 3> frame_of_level(unsigned level) {
  const double a = 0.6180339887498949 * (level + 1);
  const double b = 1.2207440846057596 * (level + 1);
  const Vec3 z{std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b)};
  const Vec3 x{std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), -std::sin(b)};
  return {to_float(x), to_float(cross(z, x)), to_float(z)};
}

}  // namespace

SpaceCut::SpaceCut(std::span<Vec3f> sample, std::size_t segments, unsigned level)
    : axes_(frame_of_level(level)), segments_(std::max<std::size_t>(segments, 1)) {
  nodes_.clear();
  for (Vec3f& p : sample) p = turn(p);
  split(sample, 0, segments_);
}

Vec3f SpaceCut::turn(const Vec3f& p) const {
  const auto along = [&](const Vec3f& axis) { return axis.x * p.x + axis.y * p.y + axis.z * p.z; };
  return {along(axes_[0]), along(axes_[1]), along(axes_[2])};
}

void SpaceCut::split(std::span<Vec3f> turned, std::size_t first_segment, std::size_t count) {
  const std::size_t node = nodes_.size();
  nodes_.push_back({3, 0, static_cast<std::uint32_t>(first_segment)});
  if (count == 1) return;
  Vec3f low{std::numeric_limits<float>::max(), std::numeric_limits<float>::max(),
            std::numeric_limits<float>::max()};
  Vec3f high{-low.x, -low.y, -low.z};
  for (const Vec3f& p : turned) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3f extent{high.x - low.x, high.y - low.y, high.z - low.z};
  const std::uint32_t axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                             : extent.y >= extent.z                       ? 1
                                                                          : 2;

  const std::size_t left_count = count / 2;
  const std::size_t middle = turned.size() * left_count / count;
  float threshold = 0;
  if (middle < turned.size()) {
    std::nth_element(turned.begin(), turned.begin() + std::ptrdiff_t(middle), turned.end(),
                     [axis](const Vec3f& a, const Vec3f& b) {
                       return coordinate(a, axis) < coordinate(b, axis);
                     });
    threshold = coordinate(turned[middle], axis);
  }
  split(turned.first(middle), first_segment, left_count);
  const auto right = static_cast<std::uint32_t>(nodes_.size());
  split(turned.subspan(middle), first_segment + left_count, count - left_count);
  nodes_[node] = {axis, threshold, right};
}

std::uint32_t SpaceCut::segment_of(const Vec3f& p) const {
  if (segments_ == 1) return 0;
  const Vec3f q = turn(p);
  std::uint32_t node = 0;
  while (nodes_[node].axis != 3) {
    node =
        coordinate(q, nodes_[node].axis) < nodes_[node].threshold ? node + 1 : nodes_[node].right;
  }
  return nodes_[node].right;
}

void PositionSample::thin() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < kept_.size(); i += 2) kept_[kept++] = kept_[i];
  kept_.resize(kept);
  stride_ *= 2;
}

}  // namespace remaps
