#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "remaps/base/progress.h"
#include "remaps/measure/surface_error.h"
#include "remaps/pipeline/query.h"

namespace remaps::pipeline {

enum class ImageKind {
  geometry,  ///< positions, at the corners of the cells of a grid
  normal,    ///< unit normals in model axes, means over pixels
  colour     ///< of the input's vertices, from 0 to 1, means over pixels
};

struct SurfaceImageOptions {
  QueryOptions query;  ///< of a bundle with a map to the sphere
  /// .exr, .npy and .png; a geometry image also as a mesh, by any extension that meshes have
  std::filesystem::path output;
  ImageKind kind = ImageKind::geometry;
  std::uint32_t size = 257;     ///< pixels a side; of a geometry image odd
  std::uint32_t component = 0;  ///< of the bundle's spheres
  std::uint32_t supersampling =
      4;                ///< of all but geometry: so many samples along each side of a pixel
  unsigned bits = 16;   ///< of a PNG
  bool measure = true;  ///< a geometry image against the input
  std::uint64_t samples = 200'000;
};

struct SurfaceImageSummary {
  std::uint32_t size = 0;
  std::uint64_t samples = 0;          ///< points that were looked up on the input
  std::optional<SurfaceError> error;  ///< of the mesh that a geometry image is
};

/// True when an image or mesh can be written by that name.
bool is_writable_image(const std::filesystem::path& path, ImageKind kind);

/// Makes an image of a surface on the octahedral unfolding of its sphere: the surface itself, as a
/// geometry image whose sides close exactly, or normals or colours of the input. What is in a pixel
/// is looked up on the input, through the map.
///
/// Of pixels that are the same point of the sphere, the first is looked up and the others copied.
/// A cell of a geometry image is cut along its shorter diagonal.
/// Normals are those of the input's faces, colours are interpolated on them; each pixel is the mean
/// over supersampling^2 points, normals of length 1.
///
/// Cost: a point takes what resampling takes. Memory: some 60 bytes a pixel, reserved.
/// @throws InputError  the bundle has no map to the sphere, or not for that component; or a size,
///                     or an extension that is none; or the input has no colours
/// @throws BudgetError the image does not fit; CorruptionError: the bundle is damaged
/// Source: Gu, Gortler, Hoppe, Geometry Images (SIGGRAPH 2002); Praun, Hoppe 2003, section 4.
SurfaceImageSummary make_surface_image(const SurfaceImageOptions& options, Progress& progress);

}  // namespace remaps::pipeline
