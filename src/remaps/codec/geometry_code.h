#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/base/progress.h"
#include "remaps/codec/coefficient_code.h"
#include "remaps/codec/subdivision_hierarchy.h"
#include "remaps/codec/wavelet.h"

namespace remaps::codec {

/// How coefficients are rounded: what both sides must agree on.
struct Quantization {
  std::uint8_t planes = 12;        ///< bits of the largest magnitude, 1 to 30
  std::uint8_t level_ratio = 109;  ///< of the steps of a level and the next coarser one, 2^-6
  std::uint8_t tangential = 51;    ///< of the weight of components 1 and 2, 2^-8; not 0
  double step = 1;                 ///< of the base and of component 0 of the coarsest details

  /// Of what a level adds; level 0 is the base.
  double step_of(unsigned level, unsigned component) const;
};

/// The grid on which base vertices are coded first.
struct BaseGrid {
  Vec3 origin;
  double cell = 1;

  std::array<std::int32_t, 3> cell_of(const Vec3& position) const;
  Vec3 centre_of(const std::array<std::int32_t, 3>& cell) const;
};

/// A surface as base vertices and details: for each vertex of a finer level its offset from the
/// prediction, along the axes of the coordinates.
///
/// @param positions  (vertices) of the finest level; replaced
/// @return the largest detail as a multiple of its step, along the axes of the edges
double to_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                  const Quantization& quantization, std::vector<Vec3>& positions,
                  Progress* progress);

/// Rounds details along the axes of the edges of the surface that a decoder of all coefficients
/// has when it comes to them. So what it makes of them is wrong by their rounding only; axes of the
/// surface itself would be turned against the decoder's, which matters where it is folded.
///
/// @param base_centres  (base vertices) what the decoder adds to their coefficients
/// @param details       (vertices) of to_details; base vertices as offsets from the centres
/// @return the largest detail as a multiple of its step, before it was cut to the planes
double quantize_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet,
                        const Quantization& quantization, std::span<const Vec3> base_centres,
                        std::span<const Vec3> details, Coefficients& coefficients,
                        Progress* progress);

/// The surface of details along the axes of the edges, up to a level.
/// @param details  (vertices of that level); replaced by its positions
void from_details(const SubdivisionHierarchy& hierarchy, Wavelet wavelet, unsigned level,
                  std::vector<Vec3>& details);

/// Rounds values to magnitudes, towards zero.
void quantize(const SubdivisionHierarchy& hierarchy, const Quantization& quantization,
              std::span<const Vec3> values, Coefficients& coefficients);
/// The middles of what magnitudes stand for; 0 for what is insignificant.
/// @param level  vertices of finer ones are left out
std::vector<Vec3> dequantize(const SubdivisionHierarchy& hierarchy,
                             const Quantization& quantization, unsigned level,
                             const Coefficients& coefficients);

}  // namespace remaps::codec
