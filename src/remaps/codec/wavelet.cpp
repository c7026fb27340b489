#include "remaps/codec/wavelet.h"

#include <cmath>
#include <numbers>

namespace remaps::codec {
namespace {

/// Of a detail, what the ends of its edge take up: least inner products with the scaling functions
/// about a regular edge, and about a third more than the wavelet's mean asks for.
constexpr double kButterflyUpdate = 0.125;
/// The noise that a vertex keeps, where its neighbours have none, in the coarse vertex: that of the
/// regular case with the update of least inner products, 0.193.
constexpr double kLoopGain = 1.41;
constexpr double kLoopBoundaryUpdate = 0.17;

/// Weights of the ring of a vertex of valence n, from the edge in question on [Zorin et al.].
void append_ring(std::uint32_t n, std::vector<double>& weights) {
  if (n == 3) {
    weights.insert(weights.end(), {5.0 / 12, -1.0 / 12, -1.0 / 12});
  } else if (n == 4) {
    weights.insert(weights.end(), {3.0 / 8, 0, -1.0 / 8, 0});
  } else {
    for (std::uint32_t j = 0; j < n; ++j) {
      const double turn = 2 * std::numbers::pi * j / n;
      weights.push_back((0.25 + std::cos(turn) + 0.5 * std::cos(2 * turn)) / n);
    }
  }
}

/// Loop's weight of all neighbours together.
double loop_ring(std::uint32_t n) {
  const double c = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / n);
  return 0.625 - c * c;
}

}  // namespace

WaveletTransform::WaveletTransform(const SubdivisionHierarchy& hierarchy, Wavelet kind)
    : hierarchy_(hierarchy), kind_(kind) {
  const auto rule_of = [&](std::uint32_t valence, bool on_boundary) {
    VertexRule rule;
    if (kind == Wavelet::kLoop) {
      if (on_boundary) {
        rule = {0.5, 0.25, kLoopBoundaryUpdate};
      } else {
        const double ring = loop_ring(valence);
        rule.keep = 1 - 1.6 * ring;
        rule.share = 1.6 * ring / valence;
        rule.update = 8 * (1 - kLoopGain * rule.keep) / (3 * valence);
      }
    } else if (kind == Wavelet::kLiftedButterfly) {
      const std::uint32_t faces = on_boundary ? valence - 1 : valence;
      rule.update = kButterflyUpdate * 6 / faces;
    }
    return rule;
  };
  regular_ = rule_of(6, false);
  boundary_ = rule_of(4, true);
  for (std::uint32_t v = 0; v < hierarchy.vertices(0); ++v) {
    const std::uint32_t valence = hierarchy.valence(v);
    base_rule_.push_back(rule_of(valence, hierarchy.on_boundary(v)));
    if (kind != Wavelet::kLoop && !hierarchy.on_boundary(v) && valence != 6) {
      base_rule_.back().extraordinary = true;
      base_rule_.back().ring = static_cast<std::uint32_t>(ring_weight_.size());
      append_ring(valence, ring_weight_);
    }
  }
}

const WaveletTransform::VertexRule& WaveletTransform::rule(std::uint32_t vertex) const {
  if (vertex < base_rule_.size()) return base_rule_[vertex];
  return hierarchy_.on_boundary(vertex) ? boundary_ : regular_;
}

Vec3 WaveletTransform::predict(const SubdivisionLevel& level, std::uint32_t edge,
                               std::span<const Vec3> x) const {
  const Side side = level.side[edge];
  const Side twin = level.twin_of(side);
  const std::uint32_t a = level.from(side), b = level.to(side);
  if (kind_ == Wavelet::kLoop) {
    if (twin.none()) return 0.5 * (x[a] + x[b]);
    return 0.375 * (x[a] + x[b]) + 0.125 * (x[level.opposite(side)] + x[level.opposite(twin)]);
  }
  if (twin.none()) return boundary_butterfly(level, side, x);
  const bool at_a = a < base_rule_.size() && base_rule_[a].extraordinary;
  const bool at_b = b < base_rule_.size() && base_rule_[b].extraordinary;
  if (at_a && at_b) {
    return 0.5 * (butterfly_ring(level, side, x) + butterfly_ring(level, twin, x));
  }
  if (at_a) return butterfly_ring(level, side, x);
  if (at_b) return butterfly_ring(level, twin, x);
  return butterfly(level, side, x);
}

/// The regular stencil: 1/2 on the ends, 1/8 opposite, -1/16 on the wings.
Vec3 WaveletTransform::butterfly(const SubdivisionLevel& level, Side side,
                                 std::span<const Vec3> x) const {
  const auto half = [&](Side s) {
    const Vec3& c = x[level.opposite(s)];
    Vec3 wings;
    for (const Side outer : {s.next(), s.previous()}) {
      const Side across = level.twin_of(outer);
      // Without a face across, the corner inside reflected at the edge.
      wings = wings + (across.none()
                           ? x[level.from(outer)] + x[level.to(outer)] - x[level.opposite(outer)]
                           : x[level.opposite(across)]);
    }
    return 0.125 * c - 0.0625 * wings;
  };
  return 0.5 * (x[level.from(side)] + x[level.to(side)]) + half(side) + half(level.twin_of(side));
}

/// The stencil of an extraordinary vertex, at which the side begins.
Vec3 WaveletTransform::butterfly_ring(const SubdivisionLevel& level, Side side,
                                      std::span<const Vec3> x) const {
  const std::uint32_t centre = level.from(side);
  const double* weight = &ring_weight_[base_rule_[centre].ring];
  Vec3 sum = 0.75 * x[centre];
  Side s = side;
  do {
    sum = sum + *weight++ * x[level.to(s)];
    s = level.twin_of(s.previous());
  } while (s != side);
  return sum;
}

/// The four-point scheme along the boundary.
Vec3 WaveletTransform::boundary_butterfly(const SubdivisionLevel& level, Side side,
                                          std::span<const Vec3> x) const {
  Side before = side.previous();
  while (!level.twin_of(before).none()) before = level.twin_of(before).previous();
  Side after = side.next();
  while (!level.twin_of(after).none()) after = level.twin_of(after).next();
  return 0.5625 * (x[level.from(side)] + x[level.to(side)]) -
         0.0625 * (x[level.from(before)] + x[level.to(after)]);
}

void WaveletTransform::update(const SubdivisionLevel& level, std::span<Vec3> x, double sign) const {
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const Side side = level.side[e];
    const double scale = level.twin_of(side).none() && kind_ != Wavelet::kLoop ? 0.5 * sign : sign;
    const Vec3 detail = scale * x[level.vertices + e];
    for (const std::uint32_t v : {level.from(side), level.to(side)}) {
      x[v] = x[v] + rule(v).update * detail;
    }
  }
}

void WaveletTransform::add_shares(const SubdivisionLevel& level, std::span<Vec3> x,
                                  double sign) const {
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const Side side = level.side[e];
    const bool inner = !level.twin_of(side).none();
    for (const std::uint32_t v : {level.from(side), level.to(side)}) {
      if (inner && hierarchy_.on_boundary(v)) continue;
      x[v] = x[v] + sign * rule(v).share * x[level.vertices + e];
    }
  }
}

void WaveletTransform::analyse(unsigned level_number, std::span<Vec3> x) const {
  const SubdivisionLevel& level = hierarchy_.level(level_number);
  if (kind_ == Wavelet::kLoop) {
    add_shares(level, x, -1);
    for (std::uint32_t v = 0; v < level.vertices; ++v) x[v] = (1 / rule(v).keep) * x[v];
  }
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    Vec3& odd = x[level.vertices + e];
    odd = odd - predict(level, e, x);
  }
  if (kind_ != Wavelet::kButterfly) update(level, x, 1);
}

void WaveletTransform::synthesise(unsigned level_number, std::span<Vec3> x) const {
  const SubdivisionLevel& level = hierarchy_.level(level_number);
  if (kind_ != Wavelet::kButterfly) update(level, x, -1);
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    Vec3& odd = x[level.vertices + e];
    odd = odd + predict(level, e, x);
  }
  if (kind_ == Wavelet::kLoop) {
    for (std::uint32_t v = 0; v < level.vertices; ++v) x[v] = rule(v).keep * x[v];
    add_shares(level, x, 1);
  }
}

}  // namespace remaps::codec
