#pragma once

#include <cstdint>
#include <variant>

#include "remaps/base/geometry.h"
#include "remaps/generate/base_shapes.h"
#include "remaps/generate/fractal_noise.h"
#include "remaps/generate/index_permutation.h"
#include "remaps/generate/patch_grid.h"
#include "remaps/generate/random_flips.h"
#include "remaps/generate/smooth_base.h"
#include "remaps/mesh/indexed_stream.h"

namespace remaps {

struct GeneratorOptions {
  /// What the mesh is divided from: a built-in shape, or any oriented manifold mesh.
  std::variant<BaseShape, ShapeMesh> base = BaseShape::kIcosahedron;
  /// Wanted number of vertices. Every base face is divided n x n with the nearest n.
  std::uint64_t vertices = 1'000'000;
  /// Height of the fractal relief, as a fraction of the base's bounding-box diagonal.
  double amplitude = 0.12;
  /// Wavelength of the largest features, as a fraction of the base's bounding-box diagonal.
  double wavelength = 0.25;
  /// Amplitude of an octave over that of the one before; 1/2 gives a 1/f spectrum, as scans have.
  double roughness = 0.5;
  /// At most so many octaves; those finer than the mesh can show are left out.
  int octaves = 8;
  /// How far vertices stray from the regular grid: 0 not at all, 1 as far as no triangle can flip.
  double jitter = 0.8;
  /// Fraction of the paired triangles that take their other diagonal. 3 triangles in 5 have a pair.
  double flip_fraction = 0.5;
  /// The same options and seed give the same mesh, bit for bit.
  std::uint64_t seed = 1;
  /// Vertices and faces in pseudo-random order instead of row by row.
  bool shuffled = false;
};

/// A scan-like irregular mesh of any size, as pure functions of the index: nothing that grows with
/// the mesh is stored.
///
/// A grid point of a base face is jittered in the face, pushed to the smooth surface that the base
/// stands for, and displaced along the normal by fractal noise evaluated in space, hence without
/// seams. Pairs of triangles inside a base face take their other diagonal at random, so that
/// valences range from 3 to about 10. The mesh is an oriented manifold whenever the base is.
/// Threads: any number on one generator.
class ScanGenerator {
 public:
  /// @throws GeometryError  the base is not an oriented manifold or has unused vertices; or the
  ///                        number of vertices is beyond 2^60
  /// @throws std::invalid_argument  a numeric option is out of its range
  explicit ScanGenerator(GeneratorOptions options);

  std::uint64_t vertices() const { return grid_.vertices(); }
  std::uint64_t faces() const { return grid_.faces(); }

  /// Position of a vertex. i < vertices().
  Vec3 vertex(VertexId i) const;
  /// Corners of a face. i < faces().
  Triangle triangle(FaceId i) const;

  /// Sends all positions in the order of their indices; the chunks are those of one thread whatever
  /// the number of threads, and the sink is called from one thread at a time.
  void positions(PositionSink sink, unsigned threads = 1) const;
  /// Sends all triangles likewise.
  void triangles(IndexSink sink, unsigned threads = 1) const;

 private:
  GeneratorOptions options_;
  SmoothBase base_;
  PatchGrid grid_;
  RandomFlips flips_;
  FractalNoise noise_;
  IndexPermutation vertex_order_;
  IndexPermutation face_order_;
};

}  // namespace remaps
