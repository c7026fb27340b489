#include "remaps/codec/geometry_code.h"

#include <algorithm>
#include <cmath>

#include "remaps/codec/edge_frames.h"

namespace remaps::codec {
namespace {

double component(const Vec3& v, unsigned c) {
  return c == 0 ? v.x : c == 1 ? v.y : v.z;
}

/// Calls visit(vertex, level) for all vertices up to a level; the base is level 0.
template <class Visit>
void for_vertices(const SubdivisionHierarchy& hierarchy, unsigned level, Visit&& visit) {
  std::uint32_t v = 0;
  for (unsigned m = 0; m <= level; ++m) {
    for (; v < hierarchy.vertices(m); ++v) visit(v, m);
  }
}

}  // namespace

double Quantization::step_of(unsigned level, unsigned component) const {
  double result = step;
  for (unsigned m = 1; m < level; ++m) result *= level_ratio / 64.0;
  return component == 0 || level == 0 ? result : result * (256.0 / tangential);
}

void to_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                std::vector<Vec3>& positions, Progress* progress) {
  const WaveletTransform transform(hierarchy, wavelet);
  for (unsigned j = hierarchy.levels(); j-- > 0;) {
    if (progress != nullptr) progress->check();
    transform.analyse(j, positions);
    // The coarse surface is now what a decoder has when it comes to these details.
    const SubdivisionLevel& level = hierarchy.level(j);
    for (std::uint32_t e = 0; e < level.edges(); ++e) {
      Vec3& detail = positions[level.vertices + e];
      detail = frame_of_edge(level, e, positions).to_local(detail);
    }
  }
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

double largest_detail(const SubdivisionHierarchy& hierarchy, const Quantization& q,
                      std::span<const Vec3> details) {
  double largest = 0;
  for (unsigned m = 1; m <= hierarchy.levels(); ++m) {
    double first = 0, others = 0;
    for (std::uint32_t v = hierarchy.vertices(m - 1); v < hierarchy.vertices(m); ++v) {
      first = std::max(first, std::fabs(details[v].x));
      others = std::max({others, std::fabs(details[v].y), std::fabs(details[v].z)});
    }
    largest = std::max({largest, first / q.step_of(m, 0), others / q.step_of(m, 1)});
  }
  return largest;
}

void quantize(const SubdivisionHierarchy& hierarchy, const Quantization& q,
              std::span<const Vec3> values, Coefficients& coefficients) {
  coefficients.resize(hierarchy.vertices());
  const auto most = static_cast<double>((std::uint64_t{1} << q.planes) - 1);
  for_vertices(hierarchy, hierarchy.levels(), [&](std::uint32_t v, unsigned m) {
    for (unsigned c = 0; c < 3; ++c) {
      const double value = component(values[v], c);
      const double steps = std::fabs(value) / q.step_of(m, c);
      coefficients.magnitude[v][c] = static_cast<std::uint32_t>(std::min(steps, most));
      if (value < 0) coefficients.negative[v] |= static_cast<std::uint8_t>(1 << c);
    }
  });
}

std::vector<Vec3> dequantize(const SubdivisionHierarchy& hierarchy, const Quantization& q,
                             unsigned level, const Coefficients& coefficients) {
  std::vector<Vec3> values(hierarchy.vertices(level));
  for_vertices(hierarchy, level, [&](std::uint32_t v, unsigned m) {
    std::array<double, 3> value{};
    for (unsigned c = 0; c < 3; ++c) {
      const std::uint32_t magnitude = coefficients.magnitude[v][c];
      if (magnitude == 0) continue;
      const auto unknown = static_cast<double>(std::uint64_t{1} << coefficients.plane[v][c]);
      value[c] = (magnitude + 0.5 * unknown) * q.step_of(m, c);
      if ((coefficients.negative[v] >> c & 1) != 0) value[c] = -value[c];
    }
    values[v] = {value[0], value[1], value[2]};
  });
  return values;
}

}  // namespace remaps::codec
