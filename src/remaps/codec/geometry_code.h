#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/memory_budget.h"
#include "remaps/base/progress.h"
#include "remaps/codec/coefficient_code.h"
#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/codec/wavelet.h"

namespace remaps::codec {

/// How coefficients are rounded: what both sides must agree on.
struct Quantization {
  Wavelet wavelet = Wavelet::kLiftedButterfly;
  std::uint8_t planes = 12;        ///< bits of the largest magnitude, 1 to 30
  std::uint8_t level_ratio = 109;  ///< of the steps of a level and the next coarser one, 2^-6
  std::uint8_t tangential = 51;    ///< of the weight of tangential components, 2^-8; not 0
  double step = 0;                 ///< of base vertices and the coarsest details, in model units
  std::uint8_t grid_shift = 0;     ///< the grid of base vertices has cells of 2^grid_shift steps
  Vec3 origin;                     ///< a corner of the grid

  /// Of the details that a level adds, 1 or more; of component 0, along the normal, or the others.
  double step_of(unsigned level, unsigned component) const;
  double cell() const { return step * static_cast<double>(std::uint64_t{1} << grid_shift); }
};

/// A surface as base vertices and details: positions of the base, then for each vertex of a finer
/// level its offset from the prediction, along the axes of the edge that it lies on.
///
/// @param positions  (vertices) of the finest level; replaced
void to_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                std::vector<Vec3>& positions, Progress* progress);
/// The inverse, up to a level.
/// @param details  (vertices of that level at least); replaced by its positions
void from_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet, unsigned level,
                  std::vector<Vec3>& details);

/// The cell of a base vertex.
std::array<std::int32_t, 3> grid_cell(const Quantization& quantization, const Vec3& position);

/// Rounds details to magnitudes, towards zero; base vertices as offsets from the centres of their
/// cells.
void quantize(const SubdivisionHierarchy& hierarchy, const Quantization& quantization,
              std::span<const Vec3> details, Coefficients& coefficients);
/// The middles of what magnitudes stand for; 0 for what is insignificant.
/// @param cells  (base vertices)
/// @param level  vertices of finer ones are left out
std::vector<Vec3> dequantize(const SubdivisionHierarchy& hierarchy,
                             const Quantization& quantization,
                             std::span<const std::array<std::int32_t, 3>> cells, unsigned level,
                             const Coefficients& coefficients);

}  // namespace remaps::codec
