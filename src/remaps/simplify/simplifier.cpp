#include "remaps/simplify/simplifier.h"

#include <algorithm>
#include <cmath>

#include "remaps/base/fast_math.h"
#include "remaps/simplify/feature_edges.h"
#include "remaps/simplify/sampling_load.h"

namespace remaps::simplify {
namespace {

constexpr unsigned kFansTried = 3;  // those of least quadric error get their load computed
constexpr std::size_t kRemovalsPerReport = 256;

}  // namespace

/// Loads the star of v. False when it cannot be removed whatever the geometry.
bool Simplifier::load_star(LocalIndex v) {
  if (!patch_->star(v, star_) || star_.wedges > options_->max_valence) return false;
  const unsigned n = star_.ring_size();
  if (n < 3 || (star_.boundary && star_.wedges < 2)) return false;
  crease_ = crease_of(*patch_, star_);
  const Vec3 centre = widen(segment_->position[v]);
  for (unsigned i = 0; i < n; ++i) offset_[i] = widen(segment_->position[star_.ring[i]]) - centre;
  star_load_ = 0;
  for (unsigned i = 0; i < star_.wedges; ++i) {
    normal_[i] = cross(offset_[i], offset_[i + 1 == n ? 0 : i + 1]);
    wedge_load_[i] = segment_->load[face_of(star_.corner[i])];
    star_load_ += wedge_load_[i];
  }
  return true;
}

bool Simplifier::flatten() {
  return flatten_star({offset_.data(), star_.ring_size()}, star_.boundary, options_->wedge_floor,
                      flat_, crease_);
}

/// The tests of a fan that need no plane and no connectivity beyond the star: valence and normals.
bool Simplifier::fan_fits(unsigned apex) const {
  const unsigned n = star_.ring_size();
  const unsigned valence = patch_->valence(star_.ring[apex]);
  const unsigned after = valence + n - 4 + (star_.boundary ? 1 : 0);
  if (after > options_->max_valence && after > valence) return false;
  for (unsigned i = 0; i < star_.wedges; ++i) {
    const unsigned k = i + 1 == n ? 0 : i + 1;
    if (i == apex || k == apex) continue;
    const Vec3 turned = cross(offset_[i] - offset_[apex], offset_[k] - offset_[apex]);
    if (!(dot(turned, normal_[i]) > 0)) return false;
  }
  return true;
}

/// Least 3D shape of the fan's triangles: 1 for equilateral, 0 for degenerate.
double Simplifier::fan_shape(unsigned apex) const {
  const unsigned n = star_.ring_size();
  double least = 1;
  unsigned k = apex + 1 == n ? 0 : apex + 1;
  Vec3 a = offset_[k] - offset_[apex];
  for (unsigned j = 0; j + 2 < n; ++j) {
    k = k + 1 == n ? 0 : k + 1;
    const Vec3 b = offset_[k] - offset_[apex];
    const double longest = std::max({norm2(a), norm2(b), norm2(b - a)});
    least = std::min(least, norm2(cross(a, b)) / (longest * longest));
    a = b;
  }
  return std::sqrt(4.0 / 3 * std::max(least, 0.0));
}

double Simplifier::fan_cost(LocalIndex v, unsigned apex) {
  const double quadric = segment_->quadric[v](offset_[apex]);
  const double carried = carry_loads(flat_, apex, {wedge_load_.data(), star_.wedges}, fan_load_);
  const double growth = std::max(carried - star_load_, 1e-3 * star_load_);
  constexpr double kLeast = 1e-300;
  return kQuadricExponent * fast_log2(quadric + 1e-6 * star_load_ + kLeast) +
         kLoadExponent * fast_log2(growth + kLeast) +
         kShapeExponent * fast_log2(std::max(fan_shape(apex), kLeastShape));
}

/// Orders the ring by quadric error as apex. At a boundary or a feature only its two ends keep it
/// in place.
unsigned Simplifier::rank_fans(LocalIndex v, std::array<unsigned, kMaxRing>& order) const {
  const unsigned n = star_.ring_size();
  if (star_.boundary || crease_.exists()) {
    const Quadric& q = segment_->quadric[v];
    const unsigned a = star_.boundary ? 0 : crease_.from;
    const unsigned b = star_.boundary ? n - 1 : crease_.to;
    const bool first = q(offset_[a]) <= q(offset_[b]);
    order[0] = first ? a : b;
    order[1] = first ? b : a;
    return 2;
  }
  std::array<double, kMaxRing> error;
  for (unsigned apex = 0; apex < n; ++apex) {
    const double e = segment_->quadric[v](offset_[apex]);
    unsigned at = apex;
    for (; at > 0 && error[at - 1] > e; --at) {
      error[at] = error[at - 1];
      order[at] = order[at - 1];
    }
    error[at] = e;
    order[at] = apex;
  }
  return n;
}

Simplifier::Candidate Simplifier::evaluate(LocalIndex v, Care care) {
  Candidate best;
  if (!load_star(v) || !flatten()) return best;
  std::array<unsigned, kMaxRing> order;
  const unsigned fans = rank_fans(v, order);
  const unsigned most = care == Care::kCareful ? kFansTried : kMaxRing;
  unsigned tried = 0;
  for (unsigned i = 0; i < fans && tried < most; ++i) {
    const unsigned apex = order[i];
    if (!fan_fits(apex) || !fan_is_valid(flat_, apex, options_->fan_floor)) continue;
    if (!patch_->fan_keeps_topology(star_, apex)) continue;
    ++tried;
    const auto cost = static_cast<float>(fan_cost(v, apex));
    if (!best.valid || cost < best.cost) best = {true, apex, cost};
  }
  return best;
}

void Simplifier::refresh(LocalIndex v, Care care) {
  const Candidate candidate = evaluate(v, care);
  stale_[v] = 0;
  if (candidate.valid) {
    apex_[v] = static_cast<std::uint8_t>(candidate.apex);
    queue_.set(v, candidate.cost);
  } else {
    queue_.erase(v);
  }
}

void Simplifier::remove(LocalIndex v, unsigned apex, RetriangulationLog& log) {
  const unsigned n = star_.ring_size();
  const Retriangulation record = make_record(star_, flat_, apex);
  log.append(record);

  carry_loads(flat_, apex, {wedge_load_.data(), star_.wedges}, fan_load_);
  for (unsigned j = 0; j + 2 < n; ++j) {
    segment_->load[record.face[j]] = static_cast<float>(fan_load_[j]);
  }
  const LocalIndex target = star_.ring[apex];
  segment_->quadric[target].add_translated(segment_->quadric[v], Vec3{} - offset_[apex]);
  patch_->retriangulate(v, star_, apex);
  queue_.erase(v);
}

/// The costs of the ring of the vertex just removed are out of date: marks them, to be evaluated
/// when they come up (most are marked again before), or evaluates them at once when thorough.
void Simplifier::update_ring(float cost) {
  const auto ring = star_.ring;
  const unsigned n = star_.ring_size();
  for (unsigned i = 0; i < n; ++i) {
    const LocalIndex x = ring[i];
    if (x >= segment_->own_vertices || segment_->locked[x]) continue;
    if (care_ == Care::kThorough) {
      refresh(x, care_);
      continue;
    }
    stale_[x] = 1;
    if (!queue_.contains(x)) queue_.set(x, cost);
  }
}

std::size_t Simplifier::run(const SimplifyOptions& options, Segment& segment, Patch& patch,
                            std::size_t alive, RetriangulationLog& log,
                            std::vector<LocalIndex>& removed) {
  options_ = &options;
  segment_ = &segment;
  patch_ = &patch;
  queue_.reset(segment.own_vertices);
  stale_.assign(segment.own_vertices, 0);
  apex_.assign(segment.own_vertices, 0);
  const auto care_with = [&](std::size_t vertices) {
    return vertices < options.thorough_below ? Care::kThorough : Care::kCareful;
  };
  std::size_t left = alive;
  care_ = care_with(left);
  for (LocalIndex v = 0; v < segment.own_vertices; ++v) {
    if (!segment.locked[v] && patch.vertex_alive(v)) refresh(v, care_);
  }
  while (left > options.target_vertices && !queue_.empty()) {
    const LocalIndex v = queue_.top();
    if (stale_[v]) {
      refresh(v, care_);
      continue;
    }
    const unsigned apex = apex_[v];
    const float cost = queue_.top_cost();
    const bool good = load_star(v) && fan_fits(apex) && flatten() &&
                      fan_is_valid(flat_, apex, options.fan_floor) &&
                      patch.fan_keeps_topology(star_, apex);
    if (!good) {
      refresh(v, care_);
      continue;
    }
    remove(v, apex, log);
    removed.push_back(v);
    --left;
    if (options.progress != nullptr && left % kRemovalsPerReport == 0) {
      options.progress->advance(double(alive - left) / double(alive - options.target_vertices));
    }
    care_ = care_with(left);
    update_ring(cost);
  }
  return left;
}

}  // namespace remaps::simplify
