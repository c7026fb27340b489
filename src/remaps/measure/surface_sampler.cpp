#include "remaps/measure/surface_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "remaps/base/errors.h"

namespace remaps {
namespace {

double area_of(const TrianglePositions& triangle) {
  return 0.5 * norm(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
}

/// Counter-based random bits: the finaliser of SplitMix64.
std::uint64_t hash(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// In [0, 1).
double to_unit(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// 2^64 divided by the golden ratio: its multiples modulo 2^64 fill the range evenly.
constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15u;

/// Puts two zero bits before each of the lowest 20 bits.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | (x << 32)) & 0x001F00000000FFFFu;
  x = (x | (x << 16)) & 0x001F0000FF0000FFu;
  x = (x | (x << 8)) & 0x100F00F00F00F00Fu;
  x = (x | (x << 4)) & 0x10C30C30C30C30C3u;
  return (x | (x << 2)) & 0x1249249249249249u;
}

/// Places on the Morton curve of a cube about a box, of 2^20 cells along each side.
class MortonCurve {
 public:
  explicit MortonCurve(const Box3& box)
      : low_(box.low),
        cells_(kSide /
               std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z})) {
  }

  std::uint64_t place(const Vec3& p) const {
    return spread_bits(cell(p.x - low_.x)) | spread_bits(cell(p.y - low_.y)) << 1 |
           spread_bits(cell(p.z - low_.z)) << 2;
  }

 private:
  static constexpr double kSide = 0x1p20;

  std::uint64_t cell(double offset) const {
    return static_cast<std::uint64_t>(std::clamp(offset * cells_, 0.0, kSide - 1));
  }

  Vec3 low_;
  double cells_;
};

/// Walks along the stream and makes the points of a range as it passes them.
class Walker {
 public:
  Walker(const SurfaceSummary& summary, const SamplingPlan& plan, std::uint64_t first,
         std::uint64_t last, std::vector<SurfacePoint>& points)
      : summary_(summary),
        plan_(plan),
        first_(first),
        last_(last),
        next_(first),
        curve_(summary.box),
        seed_(hash(plan.seed + kGolden)),
        points_(points) {}

  void pass(const TrianglePositions& triangle) {
    const double area = area_of(triangle);
    const double end = walked_ + area;
    for (; next_ < std::min(last_, plan_.samples); ++next_) {
      const double at = area_position(next_);
      if (at >= end) break;
      add(point_at(triangle, std::clamp((at - walked_) / area, 0.0, 1.0), next_), 0);
    }
    if (plan_.corners) add_corners(triangle);
    walked_ = end;
    ++index_;
  }

 private:
  /// How far along the surface sample k lies: somewhere in its own part of the area.
  double area_position(std::uint64_t k) const {
    const double parts = static_cast<double>(k) + to_unit(hash(seed_ + k * kGolden));
    const double at = parts * (summary_.area / static_cast<double>(plan_.samples));
    return std::min(at, std::nextafter(summary_.area, 0.0));
  }

  /// @param fraction  uniform in [0, 1]: the share of the triangle's area nearer to corner 0
  Vec3 point_at(const TrianglePositions& triangle, double fraction, std::uint64_t k) const {
    const double r = std::sqrt(fraction);
    const double v = to_unit(seed_ + k * kGolden);
    return (1 - r) * triangle[0] + r * (1 - v) * triangle[1] + r * v * triangle[2];
  }

  void add_corners(const TrianglePositions& triangle) {
    for (std::uint64_t i = 0; i < 3; ++i) {
      const std::uint64_t k = plan_.samples + 3 * index_ + i;
      if (k >= first_ && k < last_) add(triangle[i], 1);
    }
  }

  void add(const Vec3& position, std::uint64_t corner) {
    points_.push_back({.position = position,
                       .distance2 = std::numeric_limits<double>::infinity(),
                       .key = curve_.place(position) << 1 | corner});
  }

  const SurfaceSummary& summary_;
  const SamplingPlan& plan_;
  const std::uint64_t first_;
  const std::uint64_t last_;
  std::uint64_t next_;
  const MortonCurve curve_;
  const std::uint64_t seed_;
  std::vector<SurfacePoint>& points_;
  double walked_ = 0;
  std::uint64_t index_ = 0;
};

}  // namespace

SurfaceSummary summarise_surface(const TriangleSource& surface, std::size_t scouts_max,
                                 const Progress* progress) {
  SurfaceSummary summary;
  std::uint64_t stride = 1;
  surface([&](std::span<const TrianglePositions> chunk) {
    if (progress != nullptr) progress->check();
    for (const TrianglePositions& triangle : chunk) {
      const double area = area_of(triangle);
      if (!std::isfinite(area)) {
        throw GeometryError("triangle " + std::to_string(summary.triangles) +
                            ": coordinates not finite, or too large");
      }
      summary.area += area;
      for (const Vec3& corner : triangle) summary.box.add(corner);
      if (summary.triangles++ % stride != 0) continue;
      if (summary.scouts.size() == scouts_max) {  // keep every other one
        std::size_t kept = 0;
        for (std::size_t i = 0; i < scouts_max; i += 2) summary.scouts[kept++] = summary.scouts[i];
        summary.scouts.resize(kept);
        stride *= 2;
        if ((summary.triangles - 1) % stride != 0) continue;
      }
      summary.scouts.push_back(triangle);
    }
  });
  if (summary.triangles == 0) throw GeometryError("the surface has no triangles");
  if (!(summary.area > 0)) throw GeometryError("the surface has no area");
  return summary;
}

void sample_surface(const TriangleSource& surface, const SurfaceSummary& summary,
                    const SamplingPlan& plan, std::uint64_t first, std::uint64_t last,
                    std::vector<SurfacePoint>& points, const Progress* progress) {
  points.clear();
  points.reserve(last - first);
  Walker walker(summary, plan, first, last, points);
  surface([&](std::span<const TrianglePositions> chunk) {
    if (progress != nullptr) progress->check();
    for (const TrianglePositions& triangle : chunk) walker.pass(triangle);
  });
  if (points.size() != last - first) throw GeometryError("the surface changed between two passes");
  std::sort(points.begin(), points.end(),
            [](const SurfacePoint& a, const SurfacePoint& b) { return a.key < b.key; });
}

}  // namespace remaps
