#include "remaps/measure/surface_sampler.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "remaps/base/errors.h"
#include "remaps/measure/morton.h"

namespace remaps {
namespace {

constexpr std::size_t kScoutsPerPiece = 512;
constexpr int kCurveBits = 20;

double area_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 0.5 * norm(cross(b - a, c - a));
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

/// @param fraction  uniform in [0, 1]: the share of the triangle's area nearer to corner 0
/// @param across    uniform in [0, 1]
Vec3 point_in(const TrianglePositions& triangle, double fraction, double across) {
  const double r = std::sqrt(fraction);
  return (1 - r) * triangle[0] + r * (1 - across) * triangle[1] + r * across * triangle[2];
}

void areas_of(const SurfacePiece& piece, std::vector<double>& areas) {
  areas.resize(piece.triangle.size());
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const auto& t = piece.triangle[i];
    areas[i] = area_of(piece.position[t[0]], piece.position[t[1]], piece.position[t[2]]);
  }
}

/// Walks through the triangles of a piece along their area.
class AreaWalk {
 public:
  /// @param areas  of the triangles; one of them at least is not 0
  AreaWalk(const SurfacePiece& piece, std::span<const double> areas)
      : piece_(piece), areas_(areas) {
    step();
  }

  /// Steps on to the triangle that holds a place; to the last that has an area, if rounding puts
  /// the place behind it.
  void go_to(double at) {
    while (at >= end_ && next_ < areas_.size()) step();
    fraction_ = std::clamp((at - begin_) / (end_ - begin_), 0.0, 1.0);
  }

  Vec3 point(double across) const { return point_in(piece_.corners(triangle_), fraction_, across); }

 private:
  void step() {
    while (next_ < areas_.size()) {
      const double end = end_ + areas_[next_++];
      if (!(end > end_)) continue;
      begin_ = std::exchange(end_, end);
      triangle_ = next_ - 1;
      return;
    }
  }

  const SurfacePiece& piece_;
  const std::span<const double> areas_;
  std::size_t next_ = 0, triangle_ = 0;
  double begin_ = 0, end_ = 0, fraction_ = 0;
};

/// What a pass tells of a piece.
struct PieceSummary {
  Box3 box;
  double area = 0;
  std::size_t triangles = 0;
  std::vector<Vec3> scouts;
};

Box3 box_of(const SurfacePiece& piece, std::vector<std::uint8_t>& used) {
  used.assign(piece.position.size(), 0);
  for (const auto& t : piece.triangle) used[t[0]] = used[t[1]] = used[t[2]] = 1;
  Box3 box;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) continue;
    const Vec3& p = piece.position[v];
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

/// Keeps points so that each lies in another stretch of the area than the one before it; the
/// stretches grow as the points become too many.
class ScoutCollector {
 public:
  ScoutCollector(std::vector<Vec3>& scouts, std::size_t most)
      : scouts_(scouts), most_(most), stride_(0) {}

  void add(const Vec3& point, double at) {
    if (!places_.empty() && !apart(places_.back(), at)) return;
    if (scouts_.size() == most_) {
      stride_ = std::max(2 * stride_, 2 * at / static_cast<double>(most_));
      std::size_t kept = 1;
      for (std::size_t i = 1; i < places_.size(); ++i) {
        if (!apart(places_[kept - 1], places_[i])) continue;
        scouts_[kept] = scouts_[i];
        places_[kept++] = places_[i];
      }
      scouts_.resize(kept);
      places_.resize(kept);
      if (scouts_.size() == most_ || !apart(places_.back(), at)) return;
    }
    scouts_.push_back(point);
    places_.push_back(at);
  }

 private:
  bool apart(double a, double b) const {
    return stride_ == 0 || std::floor(b / stride_) > std::floor(a / stride_);
  }

  std::vector<Vec3>& scouts_;
  std::vector<double> places_;  // along the area
  const std::size_t most_;
  double stride_;
};

}  // namespace

SurfaceSummary summarise_surface(const SurfacePieces& surface, std::size_t scouts_max,
                                 unsigned threads, const Progress* progress) {
  SurfaceSummary summary;
  ScoutCollector collector(summary.scouts, std::max<std::size_t>(scouts_max, 1));
  struct Lane {
    std::vector<double> areas;
    std::vector<std::uint8_t> used;
  };
  std::vector<Lane> lanes(std::max(threads, 1u));
  const auto commit = [&](const PieceSummary& piece) {
    summary.pieces.push_back({piece.box, summary.area, summary.triangles});
    const double step = piece.area / static_cast<double>(kScoutsPerPiece);
    double at = summary.area + 0.5 * step;
    for (const Vec3& scout : piece.scouts) collector.add(scout, std::exchange(at, at + step));
    summary.area += piece.area;
    summary.triangles += piece.triangles;
    summary.largest_piece = std::max<std::uint64_t>(summary.largest_piece, piece.triangles);
    if (!piece.box.empty()) {
      summary.box.add(piece.box.low);
      summary.box.add(piece.box.high);
    }
  };
  surface.stream(
      threads, [](std::size_t) { return true; },
      [&](std::size_t, const SurfacePiece& piece, unsigned number) -> Commit {
        if (progress != nullptr) progress->check();
        auto& [areas, used] = lanes[number];
        areas_of(piece, areas);
        PieceSummary found;
        found.triangles = areas.size();
        for (const double area : areas) found.area += area;
        if (!std::isfinite(found.area)) {
          const auto wild = std::find_if_not(areas.begin(), areas.end(),
                                             [](double area) { return std::isfinite(area); });
          return [&summary, index = static_cast<std::uint64_t>(wild - areas.begin())] {
            throw GeometryError("triangle " + std::to_string(summary.triangles + index) +
                                ": coordinates not finite, or too large");
          };
        }
        found.box = box_of(piece, used);
        if (found.area > 0) {
          AreaWalk walk(piece, areas);
          const double step = found.area / static_cast<double>(kScoutsPerPiece);
          for (std::size_t i = 0; i < kScoutsPerPiece; ++i) {
            walk.go_to((static_cast<double>(i) + 0.5) * step);
            found.scouts.push_back(walk.point(0.5));
          }
        }
        return [&commit, found = std::move(found)] { commit(found); };
      });
  if (summary.triangles == 0) throw GeometryError("the surface has no triangles");
  if (!(summary.area > 0)) throw GeometryError("the surface has no area");
  return summary;
}

SurfaceSampler::SurfaceSampler(const SurfaceSummary& summary, const SamplingPlan& plan)
    : summary_(summary), plan_(plan), seed_(hash(plan.seed + kGolden)) {}

/// How far along the surface sample k lies: somewhere in its own part of the area.
double SurfaceSampler::area_position(std::uint64_t k) const {
  const double parts = static_cast<double>(k) + to_unit(hash(seed_ + k * kGolden));
  const double at = parts * (summary_.area / static_cast<double>(plan_.samples));
  return std::min(at, std::nextafter(summary_.area, 0.0));
}

/// The first sample of the plan whose place is not before that.
std::uint64_t SurfaceSampler::first_from(double area) const {
  const double parts = area / (summary_.area / static_cast<double>(plan_.samples));
  std::uint64_t k = parts > 1 ? static_cast<std::uint64_t>(parts) - 1 : 0;
  k = std::clamp(k, plan_.first_sample, plan_.last_sample);
  while (k < plan_.last_sample && area_position(k) < area) ++k;
  return k;
}

bool SurfaceSampler::touches(std::size_t piece) const {
  const bool last = piece + 1 == summary_.pieces.size();
  const SurfaceSummary::Piece& here = summary_.pieces[piece];
  const double area_end = last ? summary_.area : summary_.pieces[piece + 1].area_before;
  const std::uint64_t triangles_end =
      last ? summary_.triangles : summary_.pieces[piece + 1].triangles_before;
  return first_from(here.area_before) < first_from(area_end) ||
         (3 * here.triangles_before < plan_.last_corner && 3 * triangles_end > plan_.first_corner);
}

void SurfaceSampler::sample(std::size_t number, const SurfacePiece& piece,
                            std::vector<double>& areas, SurfacePoints& points) const {
  points.samples.clear();
  points.corners.clear();
  if (number >= summary_.pieces.size()) return;
  const MortonCurve curve(summary_.box, kCurveBits);
  const auto add = [&](std::vector<SurfacePoint>& to, const Vec3& p) {
    to.push_back({p, curve.place(p)});
  };
  const SurfaceSummary::Piece& here = summary_.pieces[number];
  const double end = number + 1 == summary_.pieces.size() ? summary_.area
                                                          : summary_.pieces[number + 1].area_before;
  const std::uint64_t last = first_from(end);
  std::uint64_t k = first_from(here.area_before);
  if (k < last) {
    areas_of(piece, areas);
    AreaWalk walk(piece, areas);
    for (; k < last; ++k) {
      walk.go_to(area_position(k) - here.area_before);
      add(points.samples, walk.point(to_unit(seed_ + k * kGolden)));
    }
  }
  const std::uint64_t before = 3 * here.triangles_before;
  const std::uint64_t past = before + 3 * piece.triangle.size();
  for (std::uint64_t c = std::max(plan_.first_corner, before);
       c < std::min(plan_.last_corner, past); ++c) {
    add(points.corners, piece.position[piece.triangle[(c - before) / 3][(c - before) % 3]]);
  }
}

}  // namespace remaps
