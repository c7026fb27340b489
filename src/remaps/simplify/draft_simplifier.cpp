#include "remaps/simplify/draft_simplifier.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "remaps/base/fast_math.h"
#include "remaps/simplify/feature_edges.h"

namespace remaps::simplify {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLeastValue = 1e-37f;
constexpr float kKeysPerOctave = 8;
/// What the shape of a usual fan adds to a cost, in an estimate that does not know it.
constexpr float kUsualShape = 0.5f;
/// A vertex is removed although its cost is so much above its estimate.
constexpr std::int32_t kSlack = 4;
constexpr unsigned kFansTried = 3;

/// log2 of the growth of a load spread evenly over k triangles when they become n - 2.
std::array<float, kMaxStarFaces + 1> growth_logs() {
  std::array<float, kMaxStarFaces + 1> result{};
  for (unsigned k = 3; k < result.size(); ++k) {
    const double fewer = double(k) / double(k - 2);
    result[k] = static_cast<float>(std::log2(fewer * fewer - 1));
  }
  result[2] = result[3];
  return result;
}

float quadric_at(const Quadric& q, float x, float y, float z) {
  const float value = q.q[0] * x * x + q.q[1] * y * y + q.q[2] * z * z +
                      2 * (q.q[3] * x * y + q.q[4] * x * z + q.q[5] * y * z) +
                      2 * (q.q[6] * x + q.q[7] * y + q.q[8] * z) + q.q[9];
  return value > 0 ? value : 0;
}

std::int32_t key_of(float error, float load, unsigned wedges, float shape) {
  static const std::array<float, kMaxStarFaces + 1> growth = growth_logs();
  const float cost = float(kQuadricExponent) * rough_log2(error + 1e-6f * load + kLeastValue) +
                     float(kLoadExponent) * (rough_log2(load + kLeastValue) +
                                             growth[std::min(wedges, kMaxStarFaces)]) +
                     float(kShapeExponent) * rough_log2(std::max(shape, float(kLeastShape)));
  return static_cast<std::int32_t>(kKeysPerOctave * cost + 4096) - 4096;
}

}  // namespace

bool DraftSimplifier::removable(LocalIndex v) const {
  return v < segment_->own_vertices && !segment_->locked[v] && patch_->vertex_alive(v);
}

std::int32_t DraftSimplifier::estimated_key(LocalIndex v) const {
  return key_of(fan_error_[v], star_sum_[v], patch_->valence(v), kUsualShape);
}

/// Estimates of all vertices, by a walk over the faces: each is good for three half-edges.
void DraftSimplifier::estimate_all() {
  const Segment& s = *segment_;
  fan_error_.assign(s.own_vertices, kInfinity);
  star_sum_.assign(s.own_vertices, 0);
  for (LocalIndex f = 0; f < s.triangle.size(); ++f) {
    const LocalTriangle& t = s.triangle[f];
    for (unsigned i = 0; i < 3; ++i) {
      const LocalIndex v = t[i];
      if (v >= s.own_vertices) continue;
      star_sum_[v] += s.load[f];
      const Vec3f& from = s.position[v];
      const Vec3f& to = s.position[t[i == 2 ? 0 : i + 1]];
      const float e = quadric_at(s.quadric[v], to.x - from.x, to.y - from.y, to.z - from.z);
      fan_error_[v] = std::min(fan_error_[v], e);
    }
  }
  std::int32_t least = std::numeric_limits<std::int32_t>::max();
  for (LocalIndex v = 0; v < s.own_vertices; ++v) {
    if (removable(v)) least = std::min(least, estimated_key(v));
  }
  queue_.reset(s.own_vertices, least == std::numeric_limits<std::int32_t>::max() ? 0 : least);
  for (LocalIndex v = 0; v < s.own_vertices; ++v) {
    if (removable(v)) queue_.set(v, estimated_key(v));
  }
}

/// Loads the star of v. False when it cannot be removed whatever the geometry.
bool DraftSimplifier::load_star(LocalIndex v) {
  if (!patch_->star(v, star_) || star_.wedges > options_->max_valence) return false;
  const unsigned n = star_.ring_size();
  if (n < 3 || (star_.boundary && star_.wedges < 2)) return false;
  const Vec3f centre = segment_->position[v];
  offset_.size = n;
  for (unsigned i = 0; i < n; ++i) {
    const Vec3f& p = segment_->position[star_.ring[i]];
    offset_.x[i] = p.x - centre.x;
    offset_.y[i] = p.y - centre.y;
    offset_.z[i] = p.z - centre.z;
  }
  offset_.close();
  load_ = 0;
  for (unsigned i = 0; i < star_.wedges; ++i) {
    wedge_load_[i] = segment_->load[face_of(star_.corner[i])];
    load_ += wedge_load_[i];
  }
  for (unsigned i = 0; i < n; i += kLanes) {
    const Float4 ax = load4(&offset_.x[i]), bx = load4(&offset_.x[i + 1]);
    const Float4 ay = load4(&offset_.y[i]), by = load4(&offset_.y[i + 1]);
    const Float4 az = load4(&offset_.z[i]), bz = load4(&offset_.z[i + 1]);
    store4(&normal_x_[i], ay * bz - az * by);
    store4(&normal_y_[i], az * bx - ax * bz);
    store4(&normal_z_[i], ax * by - ay * bx);
  }
  flattened_ = false;
  crease_ = crease_of(*patch_, star_);
  find_fan_errors(v);
  return true;
}

/// Quadric errors with each ring point as apex; at a boundary or a feature only its two ends keep
/// it in place.
void DraftSimplifier::find_fan_errors(LocalIndex v) {
  const std::array<float, 10>& q = segment_->quadric[v].q;
  const unsigned n = offset_.size;
  for (unsigned i = 0; i < n; i += kLanes) {
    const Float4 x = load4(&offset_.x[i]);
    const Float4 y = load4(&offset_.y[i]);
    const Float4 z = load4(&offset_.z[i]);
    const Float4 value = q[0] * x * x + q[1] * y * y + q[2] * z * z +
                         2 * (q[3] * x * y + q[4] * x * z + q[5] * y * z) +
                         2 * (q[6] * x + q[7] * y + q[8] * z) + q[9];
    store4(&error_[i], max4(value, all4(0.0f)));
  }
  if (star_.boundary) {
    for (unsigned i = 1; i + 1 < n; ++i) error_[i] = kInfinity;
  } else if (crease_.exists()) {
    for (unsigned i = 0; i < n; ++i) {
      if (i != crease_.from && i != crease_.to) error_[i] = kInfinity;
    }
  }
}

bool DraftSimplifier::valence_fits(unsigned apex) const {
  const unsigned valence = patch_->valence(star_.ring[apex]);
  const unsigned after = valence + star_.ring_size() - 4 + (star_.boundary ? 1 : 0);
  return after <= options_->max_valence || after <= valence;
}

/// Least 3D shape of the fan's triangles, 1 for equilateral; 0 when one turns by more than a right
/// angle against the wedge at its outer edge.
float DraftSimplifier::fan_shape(unsigned apex) const {
  const unsigned n = star_.ring_size();
  const float wx = offset_.x[apex], wy = offset_.y[apex], wz = offset_.z[apex];
  const Int4 at_apex = all4(static_cast<std::int32_t>(apex));
  const Int4 before_apex = all4(static_cast<std::int32_t>(apex == 0 ? n - 1 : apex - 1));
  const Int4 wedges = all4(static_cast<std::int32_t>(star_.wedges));
  Float4 least = all4(1.0f);
  for (unsigned i = 0; i < star_.wedges; i += kLanes) {
    const Float4 ax = load4(&offset_.x[i]) - wx, bx = load4(&offset_.x[i + 1]) - wx;
    const Float4 ay = load4(&offset_.y[i]) - wy, by = load4(&offset_.y[i + 1]) - wy;
    const Float4 az = load4(&offset_.z[i]) - wz, bz = load4(&offset_.z[i + 1]) - wz;
    const Float4 cx = ay * bz - az * by;
    const Float4 cy = az * bx - ax * bz;
    const Float4 cz = ax * by - ay * bx;
    const Float4 turn =
        cx * load4(&normal_x_[i]) + cy * load4(&normal_y_[i]) + cz * load4(&normal_z_[i]);
    const Float4 ex = ax - bx, ey = ay - by, ez = az - bz;
    const Float4 longest = max4(max4(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz),
                                ex * ex + ey * ey + ez * ez);
    const Float4 shape = (cx * cx + cy * cy + cz * cz) / (longest * longest);
    const Int4 lane = lanes_from(i);
    const Int4 counts = (lane < wedges) & (lane != at_apex) & (lane != before_apex);
    least = select4(counts, min4(select4(turn > 0, shape, all4(0.0f)), least), least);
  }
  return std::sqrt(1.33333333f * least_lane(least));
}

/// The best fan that obeys the rules, if its key is not above the limit; otherwise a key to wait
/// with, which is not valid.
DraftSimplifier::Choice DraftSimplifier::choose_fan(std::int32_t limit) {
  const unsigned n = star_.ring_size();
  Choice choice;
  for (unsigned tried = 0; tried < std::min(kFansTried, n); ++tried) {
    unsigned apex = 0;
    for (unsigned i = 1; i < n; ++i) {
      if (error_[i] < error_[apex]) apex = i;
    }
    const float error = error_[apex];
    if (error == kInfinity) break;
    error_[apex] = kInfinity;
    if (!valence_fits(apex)) continue;
    const float shape = fan_shape(apex);
    if (!(shape > 0) || !patch_->fan_keeps_topology(star_, apex)) continue;
    const std::int32_t key = queue_.clamped(key_of(error, load_, star_.wedges, shape));
    if (key > limit) return {false, apex, key};
    if (!flattened_) {
      flattened_ = true;
      flat_is_valid_ = flatten_star(offset_, star_.boundary, options_->wedge_floor, flat_, crease_);
    }
    if (!flat_is_valid_) break;
    if (fan_is_valid(flat_, apex, options_->fan_floor)) return {true, apex, key};
  }
  choice.key = std::numeric_limits<std::int32_t>::max();
  return choice;
}

/// Loads of the fan, as if the star's load had one density in the plane: S = density * area^3.
void DraftSimplifier::spread_loads(unsigned apex) {
  const unsigned n = star_.ring_size();
  float sum = 0;
  float area_sum = 0;
  for (unsigned i = 0; i < star_.wedges; ++i) {
    const auto area =
        static_cast<float>(orientation(flat_.ring[i], flat_.ring[i + 1 == n ? 0 : i + 1]));
    sum += wedge_load_[i] / (area * area);
    area_sum += area;
  }
  const float density = sum / area_sum;
  unsigned a = apex + 1 == n ? 0 : apex + 1;
  for (unsigned j = 0; j + 2 < n; ++j) {
    const unsigned b = a + 1 == n ? 0 : a + 1;
    const auto area =
        static_cast<float>(orientation(flat_.ring[apex], flat_.ring[a], flat_.ring[b]));
    fan_load_[j] = density * area * area * area;
    a = b;
  }
}

void DraftSimplifier::remove(LocalIndex v, unsigned apex, RetriangulationLog& log) {
  log.append(make_record(star_, flat_, apex));
  spread_loads(apex);
  for (unsigned j = 0; j + 2 < star_.ring_size(); ++j) {
    segment_->load[face_of(star_.corner[j])] = fan_load_[j];
  }
  const Quadric& quadric = segment_->quadric[v];
  const LocalIndex target = star_.ring[apex];
  if (target < segment_->own_vertices) {
    fan_error_[target] += quadric_at(quadric, offset_.x[apex], offset_.y[apex], offset_.z[apex]);
  }
  segment_->quadric[target].add_translated(quadric, Vec3{} - offset_[apex]);
  patch_->retriangulate(v, star_, apex);
  queue_.erase(v);
  update_ring(apex);
}

/// Brings the estimates of the ring up to date: wedges give way to triangles of the fan.
void DraftSimplifier::update_ring(unsigned apex) {
  const unsigned n = star_.ring_size();
  const unsigned own = segment_->own_vertices;
  const auto add = [&](unsigned slot, float load) {
    const LocalIndex x = star_.ring[slot];
    if (x < own) star_sum_[x] += load;
  };
  for (unsigned i = 0; i < star_.wedges; ++i) {
    add(i, -wedge_load_[i]);
    add(i + 1 == n ? 0 : i + 1, -wedge_load_[i]);
  }
  unsigned a = apex + 1 == n ? 0 : apex + 1;
  for (unsigned j = 0; j + 2 < n; ++j) {
    const unsigned b = a + 1 == n ? 0 : a + 1;
    for (const unsigned slot : {apex, a, b}) add(slot, fan_load_[j]);
    a = b;
  }
  for (unsigned i = 0; i < n; ++i) {
    const LocalIndex x = star_.ring[i];
    if (x >= own || segment_->locked[x]) continue;
    star_sum_[x] = std::max(star_sum_[x], 0.0f);
    queue_.set(x, estimated_key(x));
  }
}

std::size_t DraftSimplifier::run(const SimplifyOptions& options, Segment& segment, Patch& patch,
                                 std::size_t alive, RetriangulationLog& log,
                                 std::vector<LocalIndex>& removed) {
  options_ = &options;
  segment_ = &segment;
  patch_ = &patch;
  estimate_all();
  std::size_t left = alive;
  while (left > options.target_vertices && !queue_.empty()) {
    const LocalIndex v = queue_.top();
    const std::int32_t limit = queue_.top_key() + kSlack;
    Choice choice;
    choice.key = std::numeric_limits<std::int32_t>::max();
    if (load_star(v)) choice = choose_fan(limit);
    if (choice.valid) {
      remove(v, choice.apex, log);
      removed.push_back(v);
      --left;
    } else if (choice.key != std::numeric_limits<std::int32_t>::max()) {
      queue_.set(v, choice.key);
    } else {
      queue_.erase(v);  // until a neighbour changes
    }
  }
  return left;
}

}  // namespace remaps::simplify
