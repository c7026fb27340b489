#include "remaps/codec/geometry_code.h"

#include <algorithm>
#include <cmath>

#include "remaps/codec/edge_frames.h"

namespace remaps::codec {
namespace {

/// Rounding to the steps of a level; level 0 is the base.
class LevelSteps {
 public:
  LevelSteps(const Quantization& q, unsigned level)
      : step_{q.step_of(level, 0), q.step_of(level, 1), q.step_of(level, 2)},
        most_(static_cast<double>((std::uint64_t{1} << q.planes) - 1)) {}

  /// The largest component as a multiple of its step.
  double largest(const Vec3& value) const {
    return std::max({std::fabs(value.x) / step_[0], std::fabs(value.y) / step_[1],
                     std::fabs(value.z) / step_[2]});
  }

  /// Sets the coefficients of a vertex; returns the middle of what they stand for.
  Vec3 round(const Vec3& value, std::uint32_t v, Coefficients& coefficients) const {
    const std::array<double, 3> components{value.x, value.y, value.z};
    for (unsigned c = 0; c < 3; ++c) {
      const double steps = std::fabs(components[c]) / step_[c];
      coefficients.magnitude[v][c] = static_cast<std::uint32_t>(std::min(steps, most_));
      if (components[c] < 0) coefficients.negative[v] |= static_cast<std::uint8_t>(1 << c);
    }
    return middle(v, coefficients);
  }

  /// The middle of what the coefficients of a vertex stand for; 0 for what is insignificant.
  Vec3 middle(std::uint32_t v, const Coefficients& coefficients) const {
    std::array<double, 3> value{};
    for (unsigned c = 0; c < 3; ++c) {
      const std::uint32_t magnitude = coefficients.magnitude[v][c];
      if (magnitude == 0) continue;
      const auto unknown = static_cast<double>(std::uint64_t{1} << coefficients.plane[v][c]);
      value[c] = (magnitude + 0.5 * unknown) * step_[c];
      if ((coefficients.negative[v] >> c & 1) != 0) value[c] = -value[c];
    }
    return {value[0], value[1], value[2]};
  }

 private:
  std::array<double, 3> step_;
  double most_;
};

}  // namespace

double Quantization::step_of(unsigned level, unsigned component) const {
  double result = step;
  for (unsigned m = 1; m < level; ++m) result *= level_ratio / 64.0;
  return component == 0 || level == 0 ? result : result * (256.0 / tangential);
}

double to_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                  const Quantization& quantization, std::vector<Vec3>& positions,
                  Progress* progress) {
  const WaveletTransform transform(hierarchy, wavelet);
  double largest = 0;
  for (unsigned j = hierarchy.levels(); j-- > 0;) {
    if (progress != nullptr) progress->check();
    transform.analyse(j, positions);
    // The coarse surface is now about what a decoder has when it comes to these details.
    const SubdivisionLevel& level = hierarchy.level(j);
    const LevelSteps steps(quantization, j + 1);
    for (std::uint32_t e = 0; e < level.edges(); ++e) {
      const EdgeFrame frame = frame_of_edge(level, e, positions);
      largest = std::max(largest, steps.largest(frame.to_local(positions[level.vertices + e])));
    }
  }
  return largest;
}

double quantize_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                        const Quantization& quantization, std::span<const Vec3> base_centres,
                        std::span<const Vec3> details, Coefficients& coefficients,
                        Progress* progress) {
  const WaveletTransform transform(hierarchy, wavelet);
  coefficients.resize(hierarchy.vertices());
  std::vector<Vec3> decoded(hierarchy.vertices());
  const LevelSteps base_steps(quantization, 0);
  for (std::uint32_t v = 0; v < hierarchy.vertices(0); ++v) {
    decoded[v] = base_centres[v] + base_steps.round(details[v], v, coefficients);
  }
  double largest = 0;
  for (unsigned j = 0; j < hierarchy.levels(); ++j) {
    if (progress != nullptr) progress->check();
    const SubdivisionLevel& level = hierarchy.level(j);
    const LevelSteps steps(quantization, j + 1);
    for (std::uint32_t e = 0; e < level.edges(); ++e) {
      const std::uint32_t v = level.vertices + e;
      const EdgeFrame frame = frame_of_edge(level, e, decoded);
      const Vec3 detail = frame.to_local(details[v]);
      largest = std::max(largest, steps.largest(detail));
      decoded[v] = frame.to_global(steps.round(detail, v, coefficients));
    }
    // The finest level is needed by nobody.
    if (j + 1 < hierarchy.levels()) transform.synthesise(j, decoded);
  }
  return largest;
}

void from_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet, unsigned level_number,
                  std::vector<Vec3>& details) {
  const WaveletTransform transform(hierarchy, wavelet);
  for (unsigned j = 0; j < level_number; ++j) {
    const SubdivisionLevel& level = hierarchy.level(j);
    for (std::uint32_t e = 0; e < level.edges(); ++e) {
      Vec3& detail = details[level.vertices + e];
      if (detail == Vec3{}) continue;
      detail = frame_of_edge(level, e, details).to_global(detail);
    }
    transform.synthesise(j, details);
  }
}

std::array<std::int32_t, 3> BaseGrid::cell_of(const Vec3& position) const {
  const Vec3 from_origin = position - origin;
  const auto along = [&](double x) { return static_cast<std::int32_t>(std::floor(x / cell)); };
  return {along(from_origin.x), along(from_origin.y), along(from_origin.z)};
}

Vec3 BaseGrid::centre_of(const std::array<std::int32_t, 3>& at) const {
  return origin + Vec3{(at[0] + 0.5) * cell, (at[1] + 0.5) * cell, (at[2] + 0.5) * cell};
}

void quantize(const SubdivisionHierarchy& hierarchy, const Quantization& q,
              std::span<const Vec3> values, Coefficients& coefficients) {
  coefficients.resize(hierarchy.vertices());
  std::uint32_t v = 0;
  for (unsigned m = 0; m <= hierarchy.levels(); ++m) {
    const LevelSteps steps(q, m);
    for (; v < hierarchy.vertices(m); ++v) steps.round(values[v], v, coefficients);
  }
}

std::vector<Vec3> dequantize(const SubdivisionHierarchy& hierarchy, const Quantization& q,
                             unsigned level, const Coefficients& coefficients) {
  std::vector<Vec3> values(hierarchy.vertices(level));
  std::uint32_t v = 0;
  for (unsigned m = 0; m <= level; ++m) {
    const LevelSteps steps(q, m);
    for (; v < hierarchy.vertices(m); ++v) values[v] = steps.middle(v, coefficients);
  }
  return values;
}

}  // namespace remaps::codec
