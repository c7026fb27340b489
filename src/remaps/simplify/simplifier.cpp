#include "remaps/simplify/simplifier.h"

#include <algorithm>
#include <cmath>

#include "remaps/simplify/sampling_load.h"

namespace remaps::simplify {
namespace {

constexpr double kQuadricExponent = 0.3;
constexpr double kLoadExponent = 0.7;
constexpr unsigned kFansTried = 3;  // those of least quadric error get their load computed

}  // namespace

/// Loads and flattens the star of v. False when v cannot be removed as things are.
bool Simplifier::prepare(LocalIndex v) {
  if (!patch_->star(v, star_) || star_.wedges > options_->max_valence) return false;
  const unsigned n = star_.ring_size();
  if (n < 3 || (star_.boundary && star_.wedges < 2)) return false;
  const Vec3 centre = widen(segment_->position[v]);
  for (unsigned i = 0; i < n; ++i) offset_[i] = widen(segment_->position[star_.ring[i]]) - centre;
  if (!flatten_star({offset_.data(), n}, star_.boundary, options_->wedge_floor, flat_))
    return false;
  for (unsigned i = 0; i < star_.wedges; ++i) {
    normal_[i] = cross(offset_[i], offset_[i + 1 == n ? 0 : i + 1]);
    wedge_load_[i] = segment_->load[star_.corner[i] / 3];
  }
  return true;
}

/// The tests of a fan that need no connectivity beyond the star: valence, planar orientation,
/// normals.
bool Simplifier::fan_fits(unsigned apex) const {
  const unsigned n = star_.ring_size();
  const unsigned valence = patch_->valence(star_.ring[apex]);
  const unsigned after = valence + n - 4 + (star_.boundary ? 1 : 0);
  if (after > options_->max_valence && after > valence) return false;
  if (!fan_is_valid(flat_, apex, options_->fan_floor)) return false;
  for (unsigned i = 0; i < star_.wedges; ++i) {
    const unsigned k = i + 1 == n ? 0 : i + 1;
    if (i == apex || k == apex) continue;
    const Vec3 turned = cross(offset_[i] - offset_[apex], offset_[k] - offset_[apex]);
    const double cosine = dot(turned, normal_[i]);
    if (!(cosine > 0)) return false;
    const double floor = options_->normal_floor;
    if (cosine * cosine < floor * floor * norm2(turned) * norm2(normal_[i])) return false;
  }
  return true;
}

/// Least 3D shape of the fan's triangles, 0 to 1.
double Simplifier::fan_shape(unsigned apex) const {
  const unsigned n = star_.ring_size();
  const auto wrap = [n](unsigned slot) { return slot >= n ? slot - n : slot; };
  double least = 1;
  for (unsigned j = 0; j + 2 < n; ++j) {
    const Vec3 a = offset_[wrap(apex + 1 + j)] - offset_[apex];
    const Vec3 b = offset_[wrap(apex + 2 + j)] - offset_[apex];
    const double longest = std::max({norm2(a), norm2(b), norm2(b - a)});
    const double shape = longest > 0 ? 1.1547 * norm(cross(a, b)) / longest : 0;
    least = std::min(least, shape);
  }
  return least;
}

double Simplifier::fan_cost(LocalIndex v, unsigned apex, double star_load) {
  const double quadric = segment_->quadric[v](offset_[apex]);
  const double load = carry_loads(flat_, apex, {wedge_load_.data(), star_.wedges}, fan_load_);
  const double growth = std::max(load - star_load, 1e-3 * star_load);
  const double floor = 1e-6 * star_load;
  const double shape = std::max(fan_shape(apex), 0.02);
  return std::pow(quadric + floor, kQuadricExponent) * std::pow(growth, kLoadExponent) *
         std::pow(shape, -0.25);
}

Simplifier::Candidate Simplifier::evaluate(LocalIndex v) {
  Candidate best;
  if (!prepare(v)) return best;
  const unsigned n = star_.ring_size();
  std::array<std::pair<double, unsigned>, kMaxRing> order;
  unsigned fits = 0;
  for (unsigned apex = 0; apex < n; ++apex) {
    if (star_.boundary && apex != 0 && apex != n - 1) continue;
    order[fits++] = {segment_->quadric[v](offset_[apex]), apex};
  }
  std::sort(order.begin(), order.begin() + fits);
  double star_load = 0;
  for (unsigned i = 0; i < star_.wedges; ++i) star_load += wedge_load_[i];
  unsigned tried = 0;
  const unsigned most = thorough_ ? kMaxRing : kFansTried;
  for (unsigned i = 0; i < fits && tried < most; ++i) {
    const unsigned apex = order[i].second;
    if (!fan_fits(apex) || !patch_->fan_keeps_topology(star_, apex)) continue;
    ++tried;
    const auto cost = static_cast<float>(fan_cost(v, apex, star_load));
    if (!best.valid || cost < best.cost) best = {true, apex, cost};
  }
  return best;
}

void Simplifier::refresh(LocalIndex v) {
  const Candidate candidate = evaluate(v);
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
  Retriangulation record;
  record.wedges = static_cast<std::uint8_t>(star_.wedges);
  record.boundary = star_.boundary;
  record.apex = static_cast<std::uint8_t>(apex);
  for (unsigned i = 0; i < star_.wedges; ++i) {
    record.face[i] = star_.corner[i] / 3;
    record.turn[i] = static_cast<std::uint8_t>(star_.corner[i] % 3);
  }
  record.ring = flat_.ring;
  log.append(record);

  carry_loads(flat_, apex, {wedge_load_.data(), star_.wedges}, fan_load_);
  for (unsigned j = 0; j + 2 < n; ++j)
    segment_->load[record.face[j]] = static_cast<float>(fan_load_[j]);
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
    if (thorough_) {
      refresh(x);
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
  std::size_t left = alive;
  thorough_ = left < options.thorough_below;
  for (LocalIndex v = 0; v < segment.own_vertices; ++v) {
    if (!segment.locked[v] && patch.vertex_alive(v)) refresh(v);
  }
  while (left > options.target_vertices && !queue_.empty()) {
    const LocalIndex v = queue_.top();
    if (stale_[v]) {
      refresh(v);
      continue;
    }
    const unsigned apex = apex_[v];
    const float cost = queue_.top_cost();
    if (!prepare(v) || !fan_fits(apex) || !patch.fan_keeps_topology(star_, apex)) {
      refresh(v);
      continue;
    }
    remove(v, apex, log);
    removed.push_back(v);
    --left;
    thorough_ = left < options.thorough_below;
    update_ring(cost);
  }
  return left;
}

}  // namespace remaps::simplify
