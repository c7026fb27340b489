#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/mesh/attributes.h"
#include "remaps/resample/attribute_mixer.h"

namespace remaps::resample {

/// How far within a face its corners are looked up, as weights of the other two: far more than
/// rounding does to them on their way, and far less than a float of the result shows.
inline constexpr double kInwards = 0x1p-20;
/// The point of a face that is not at a corner.
inline constexpr std::uint8_t kCentre = 3;

/// A point of a face of the grid, where it was found on the input.
struct FaceSample {
  double u = 0, v = 0;  ///< weights in the input face: 1 - u - v, u, v on `vertex`
  std::array<VertexId, 3> vertex{};
  std::array<Vec3f, 3> position{};  ///< at corners: its own, first; at the centre: the input face's
  std::uint8_t slot = 0;            ///< corner 0, 1, 2 or kCentre
  std::uint8_t there = 0;
  std::array<std::uint8_t, 2> unused{};
};
static_assert(sizeof(FaceSample) == 80);

/// Attributes of the corners of one face of the grid from its four points.
class CornerValues {
 public:
  explicit CornerValues(std::vector<AttributeSpec> specs);

  /// Of one corner.
  std::size_t row_bytes() const { return mixer_.row_bytes(); }
  /// The same with the vertex before it.
  std::size_t input_row_bytes() const { return sizeof(VertexId) + row_bytes(); }
  /// @param sample  (4) by slot; a corner that is not there has what the next one of the face has
  ///                that is there, zeros if none is
  /// @param rows    (4 x 3 input rows) of the corners of the input faces that the points lie in, in
  ///                any order
  /// @param out     (3 rows)
  void find(std::span<const FaceSample> sample, std::span<const std::byte> rows,
            std::span<std::byte> out);

 private:
  std::span<const std::byte> row_of(VertexId vertex, std::size_t corner,
                                    std::span<const std::byte> rows) const;
  void interpolate(const FaceSample& sample, std::span<const std::byte> rows,
                   std::span<double> values);
  void mend_seams(std::span<const FaceSample> sample, std::span<const std::byte> centre_rows);

  AttributeMixer mixer_;
  std::vector<std::size_t> uv_;                // first channels
  std::array<std::vector<double>, 3> value_;   // (channels) of each corner
  std::array<std::vector<double>, 3> centre_;  // (channels) of the input face under the centre
};

}  // namespace remaps::resample
