#include "remaps/codec/wavelet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace remaps::codec {
namespace {

/// Of a detail, what the ends of its edge take up: on a regular mesh wavelets then have no mean.
constexpr double kButterflyUpdate = 0.125;
/// Loop's guess: valence times the update that leaves least noise in the coarse vertex, if those
/// about it are regular, for valences from 3 to 12; details opposite to a vertex count by
/// kOppositeUpdate of it.
constexpr double kLoopUpdate[] = {2.916, 2.537, 2.292, 2.168, 2.117,
                                  2.104, 2.115, 2.134, 2.16,  2.192};
constexpr double kOppositeUpdate = -0.54, kLoopBoundaryUpdate = 0.437;
/// Loop's subdivision has singular values whose squares are within these, nearly, and so much is
/// enough: a fifth step gains less than 0.1 dB.
constexpr double kLeastEigenvalue = 0.25, kMostEigenvalue = 4.2;
constexpr unsigned kFitSteps = 4;
/// What a detail of Loop's is of its coefficient, and of the mean of those about each of its ends.
constexpr double kOwn = 0.7, kShared = 0.9, kBoundaryShared = 0.56;
/// Of the Jacobi iteration that undoes it, and steps of Chebyshev's until rounding is all that is
/// left: 0.31 a step.
constexpr double kSpectralRadius = kShared / (kShared + kOwn);
constexpr unsigned kSteps = 32;

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
        rule = {0.5, 0.25, kLoopBoundaryUpdate, kBoundaryShared / 2, 0};
        rule.solve = 1 / (kOwn + kBoundaryShared);
      } else {
        const double ring = loop_ring(valence);
        rule.keep = 1 - 1.6 * ring;
        rule.share = 1.6 * ring / valence;
        rule.update = kLoopUpdate[std::clamp(valence, 3u, 12u) - 3] / valence;
        rule.mean = kShared / valence;
        rule.solve = 1 / (kOwn + kShared);
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

/// Visits the ends of an edge; of an inner one not those on the boundary, whose curve is by itself.
template <class Visit>
void WaveletTransform::for_ends(const SubdivisionLevel& level, std::uint32_t edge,
                                Visit&& visit) const {
  const Side side = level.side[edge];
  const bool inner = !level.twin_of(side).none();
  for (const std::uint32_t v : {level.from(side), level.to(side)}) {
    if (!inner || !hierarchy_.on_boundary(v)) visit(v);
  }
}

void WaveletTransform::update(const SubdivisionLevel& level, std::span<Vec3> x, double sign) const {
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const Side side = level.side[e];
    const double scale = level.twin_of(side).none() ? 0.5 * sign : sign;
    const Vec3 detail = scale * x[level.vertices + e];
    for (const std::uint32_t v : {level.from(side), level.to(side)}) {
      x[v] = x[v] + rule(v).update * detail;
    }
  }
}

/// Adds to the coarse vertices the least-squares fit of subdivision without details to what the
/// details alone make, nearly: a local guess, then some steps of Chebyshev's iteration.
void WaveletTransform::update_loop(const SubdivisionLevel& level, std::span<Vec3> x,
                                   double sign) const {
  constexpr double kMiddle = 0.5 * (kLeastEigenvalue + kMostEigenvalue);
  constexpr double kHalf = kMostEigenvalue - kMiddle;
  std::vector<Stencil> stencils;
  stencils.reserve(level.edges());
  for (const Side side : level.side) {
    const Side twin = level.twin_of(side);
    stencils.push_back({level.from(side), level.to(side),
                        twin.none() ? kNoIndex : level.opposite(side),
                        twin.none() ? kNoIndex : level.opposite(twin)});
  }
  const std::span<const Vec3> details = x.subspan(level.vertices, level.edges());
  std::vector<Vec3> fit = local_fit(stencils, details, level.vertices), even(level.vertices),
                    residual(level.vertices), step(level.vertices);
  double rho = 0;
  for (unsigned i = 0; i < kFitSteps; ++i) {
    fit_residual(stencils, details, fit, even, residual);
    const double next = i == 0 ? kHalf / kMiddle : 1 / (2 * kMiddle / kHalf - rho);
    const double size = (i == 0 ? 1 : 2) * next / kHalf;
    for (std::uint32_t v = 0; v < level.vertices; ++v) {
      step[v] = next * rho * step[v] + size * residual[v];
      fit[v] = fit[v] + step[v];
    }
    rho = next;
  }
  for (std::uint32_t v = 0; v < level.vertices; ++v) x[v] = x[v] + sign * fit[v];
}

std::vector<Vec3> WaveletTransform::local_fit(std::span<const Stencil> stencils,
                                              std::span<const Vec3> details,
                                              std::uint32_t vertices) const {
  std::vector<Vec3> fit(vertices);
  for (std::size_t e = 0; e < stencils.size(); ++e) {
    const Stencil& s = stencils[e];
    for (const std::uint32_t v : {s.a, s.b}) {
      if (takes(s, v)) fit[v] = fit[v] + rule(v).update * details[e];
    }
    if (!s.inner()) continue;
    for (const std::uint32_t v : {s.c, s.d}) {
      if (takes(s, v)) fit[v] = fit[v] + kOppositeUpdate * rule(v).update * details[e];
    }
  }
  return fit;
}

/// What the normal equations of the fit lack: the transpose of subdivision, applied to what the
/// details make less the subdivision of the fit. On the boundary those of its curve.
/// @param even  scratch
void WaveletTransform::fit_residual(std::span<const Stencil> stencils,
                                    std::span<const Vec3> details, std::span<const Vec3> fit,
                                    std::span<Vec3> even, std::span<Vec3> residual) const {
  const auto missing = [&](std::size_t e) {
    const Stencil& s = stencils[e];
    if (!s.inner()) return details[e] - 0.5 * (fit[s.a] + fit[s.b]);
    return details[e] - 0.375 * (fit[s.a] + fit[s.b]) - 0.125 * (fit[s.c] + fit[s.d]);
  };
  for (std::size_t v = 0; v < fit.size(); ++v) {
    even[v] = -rule(static_cast<std::uint32_t>(v)).keep * fit[v];
  }
  for (std::size_t e = 0; e < stencils.size(); ++e) {
    const Stencil& s = stencils[e];
    const Vec3 odd = missing(e);
    for (const std::uint32_t v : {s.a, s.b}) {
      if (takes(s, v)) even[v] = even[v] + rule(v).share * odd;
    }
  }
  for (std::size_t v = 0; v < fit.size(); ++v) {
    residual[v] = rule(static_cast<std::uint32_t>(v)).keep * even[v];
  }
  for (std::size_t e = 0; e < stencils.size(); ++e) {
    const Stencil& s = stencils[e];
    Vec3 odd = missing(e);
    for (const std::uint32_t v : {s.a, s.b}) {
      if (takes(s, v)) odd = odd + rule(v).share * even[v];
    }
    for (const std::uint32_t v : {s.a, s.b}) {
      if (takes(s, v)) residual[v] = residual[v] + (s.inner() ? 0.375 : 0.5) * odd;
    }
    if (!s.inner()) continue;
    for (const std::uint32_t v : {s.c, s.d}) {
      if (takes(s, v)) residual[v] = residual[v] + 0.125 * odd;
    }
  }
}

void WaveletTransform::add_shares(const SubdivisionLevel& level, std::span<Vec3> x,
                                  double sign) const {
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const Vec3 odd = sign * x[level.vertices + e];
    for_ends(level, e, [&](std::uint32_t v) { x[v] = x[v] + rule(v).share * odd; });
  }
}

/// The weighted sums of coefficients about vertices.
std::vector<Vec3> WaveletTransform::means(const SubdivisionLevel& level,
                                          std::span<const Vec3> x) const {
  std::vector<Vec3> mean(level.vertices);
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const Vec3& c = x[level.vertices + e];
    for_ends(level, e, [&](std::uint32_t v) { mean[v] = mean[v] + rule(v).mean * c; });
  }
  return mean;
}

/// From coefficients to details: kOwn of each and the means at its ends.
void WaveletTransform::mix(const SubdivisionLevel& level, std::span<Vec3> x) const {
  const std::vector<Vec3> mean = means(level, x);
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    Vec3& c = x[level.vertices + e];
    c = kOwn * c;
    for_ends(level, e, [&](std::uint32_t v) { c = c + mean[v]; });
  }
}

/// The inverse. Details are d = kOwn c + A m of coefficients c and their means m = B A^T c, where A
/// is the incidence of edges and vertices and B the diagonal of weights. So the means follow from
/// those of the details, (kOwn + B A^T A) m = B A^T d, where the diagonal prevails.
void WaveletTransform::unmix(const SubdivisionLevel& level, std::span<Vec3> x) const {
  std::vector<std::array<std::uint32_t, 2>> pairs;  // vertices that share in an edge
  pairs.reserve(level.edges());
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    std::array<std::uint32_t, 2> ends{};
    std::size_t count = 0;
    for_ends(level, e, [&](std::uint32_t v) { ends[count++] = v; });
    if (count == 2) pairs.push_back(ends);
  }
  std::vector<Vec3> right = means(level, x);
  for (std::uint32_t v = 0; v < level.vertices; ++v) right[v] = rule(v).solve * right[v];
  std::vector<Vec3> now = right, last(level.vertices), about(level.vertices);
  double omega = 2;
  for (unsigned i = 0; i < kSteps; ++i) {
    omega = 1 / (1 - 0.25 * kSpectralRadius * kSpectralRadius * omega);
    std::fill(about.begin(), about.end(), Vec3{});
    for (const auto& [v, w] : pairs) {
      about[v] = about[v] + now[w];
      about[w] = about[w] + now[v];
    }
    for (std::uint32_t v = 0; v < level.vertices; ++v) {
      const Vec3 jacobi = right[v] - rule(v).solve * rule(v).mean * about[v];
      last[v] = (1 - omega) * last[v] + omega * jacobi;
    }
    std::swap(now, last);
  }
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    Vec3& c = x[level.vertices + e];
    for_ends(level, e, [&](std::uint32_t v) { c = c - now[v]; });
    c = 1 / kOwn * c;
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
  if (kind_ == Wavelet::kLiftedButterfly) update(level, x, 1);
  if (kind_ == Wavelet::kLoop) {
    update_loop(level, x, 1);
    unmix(level, x);
  }
}

void WaveletTransform::synthesise(unsigned level_number, std::span<Vec3> x) const {
  const SubdivisionLevel& level = hierarchy_.level(level_number);
  if (kind_ == Wavelet::kLiftedButterfly) update(level, x, -1);
  if (kind_ == Wavelet::kLoop) {
    mix(level, x);
    update_loop(level, x, -1);
  }
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
