#include "remaps/codec/geometry_code.h"

#include <algorithm>
#include <cmath>

#include "remaps/codec/edge_frames.h"

namespace remaps::codec {
namespace {

double component(const Vec3& v, unsigned c) {
  return c == 0 ? v.x : c == 1 ? v.y : v.z;
}

Vec3 cell_centre(const Quantization& q, const std::array<std::int32_t, 3>& cell) {
  const double size = q.cell();
  return q.origin + Vec3{(cell[0] + 0.5) * size, (cell[1] + 0.5) * size, (cell[2] + 0.5) * size};
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

std::array<std::int32_t, 3> grid_cell(const Quantization& q, const Vec3& position) {
  std::array<std::int32_t, 3> cell;
  for (unsigned c = 0; c < 3; ++c) {
    cell[c] = static_cast<std::int32_t>(
        std::floor((component(position, c) - component(q.origin, c)) / q.cell()));
  }
  return cell;
}

void quantize(const SubdivisionHierarchy& hierarchy, const Quantization& q,
              std::span<const Vec3> details, Coefficients& coefficients) {
  coefficients.resize(hierarchy.vertices());
  const auto most = static_cast<double>((std::uint64_t{1} << q.planes) - 1);
  for_vertices(hierarchy, hierarchy.levels(), [&](std::uint32_t v, unsigned m) {
    const Vec3 value = m == 0 ? details[v] - cell_centre(q, grid_cell(q, details[v])) : details[v];
    for (unsigned c = 0; c < 3; ++c) {
      const double steps = std::fabs(component(value, c)) / q.step_of(m, c);
      coefficients.magnitude[v][c] = static_cast<std::uint32_t>(std::min(steps, most));
      if (component(value, c) < 0) {
        coefficients.negative[v] |= static_cast<std::uint8_t>(1 << c);
      }
    }
  });
}

std::vector<Vec3> dequantize(const SubdivisionHierarchy& hierarchy, const Quantization& q,
                             std::span<const std::array<std::int32_t, 3>> cells, unsigned level,
                             const Coefficients& coefficients) {
  std::vector<Vec3> details(hierarchy.vertices(level));
  for_vertices(hierarchy, level, [&](std::uint32_t v, unsigned m) {
    std::array<double, 3> value{};
    for (unsigned c = 0; c < 3; ++c) {
      const std::uint32_t magnitude = coefficients.magnitude[v][c];
      if (magnitude == 0) continue;
      const auto unknown = static_cast<double>(std::uint64_t{1} << coefficients.plane[v][c]);
      value[c] = (magnitude + 0.5 * unknown) * q.step_of(m, c);
      if ((coefficients.negative[v] >> c & 1) != 0) value[c] = -value[c];
    }
    details[v] = {value[0], value[1], value[2]};
    if (m == 0) details[v] = details[v] + cell_centre(q, cells[v]);
  });
  return details;
}

}  // namespace remaps::codec
