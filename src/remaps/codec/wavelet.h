#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/codec/subdivision_hierarchy.h"

namespace remaps::codec {

enum class Wavelet : std::uint8_t {
  kButterfly = 0,        ///< interpolating; coarse vertices are some of the fine ones
  kLiftedButterfly = 1,  ///< coarse vertices are averages: wavelets have no mean
  kLoop = 2,             ///< lifted; without details a level is Loop's subdivision of the one below
};

/// Wavelet transforms of functions on the vertices of a subdivided mesh: level by level, in place,
/// by lifting steps that the inverse takes backwards. Exact but for rounding.
///
/// Butterfly: the modified scheme of Zorin, Schröder, Sweldens (Interpolating Subdivision for
/// Meshes with Arbitrary Topology, SIGGRAPH 96); at boundaries the four-point scheme, and next to
/// them what is missing of the stencil is reflected. The update is that of Schröder, Sweldens
/// (Spherical Wavelets, SIGGRAPH 95) with weights for the least inner products with the coarse
/// scaling functions.
/// Loop: Loop's scheme with his weights as a prediction of edges and a scaled smoothing of
/// vertices, as in Bertram (Biorthogonal Loop-Subdivision Wavelets, Computing 72, 2004); boundaries
/// are cubic splines. Differs: the update nearly is the least-squares fit of the coarse mesh, also
/// where many extraordinary vertices meet, and details are sums of coefficients so that these are
/// nearly orthogonal. The boundary's coefficients depend on it alone.
///
class WaveletTransform {
 public:
  /// What a transform takes on the way, for each vertex of the finest level.
  static constexpr std::uint64_t working_bytes_per_vertex(Wavelet kind) {
    return kind == Wavelet::kLoop ? 36 : 0;
  }

  WaveletTransform(const SubdivisionHierarchy& hierarchy, Wavelet kind);

  /// Splits level + 1 into level and details.
  /// @param level  0 to levels() - 1
  /// @param x      (vertices of level + 1) values; becomes coarse values and, for the vertices that
  ///               level + 1 adds, details
  void analyse(unsigned level, std::span<Vec3> x) const;
  /// The inverse.
  void synthesise(unsigned level, std::span<Vec3> x) const;

 private:
  struct VertexRule {
    double keep = 1, share = 0;  // of a vertex and of each new one about it: Loop's smoothing
    double update = 0;           // of a detail on a neighbouring edge
    double mean = 0, solve = 0;  // of Loop's coefficients about a vertex; to undo that
    bool extraordinary = false;  // Butterfly takes the ring's weights
    std::uint32_t ring = 0;      // where those are in ring_weight_
  };

  struct Stencil {
    std::uint32_t a, b, c, d;  // ends of an edge, and what is opposite to it if it is inner

    bool inner() const { return c != kNoIndex; }
  };

  const VertexRule& rule(std::uint32_t vertex) const;
  /// The boundary's curve is by itself.
  bool takes(const Stencil& stencil, std::uint32_t v) const {
    return !stencil.inner() || !hierarchy_.on_boundary(v);
  }
  Vec3 predict(const SubdivisionLevel& level, std::uint32_t edge, std::span<const Vec3> x) const;
  Vec3 butterfly(const SubdivisionLevel& level, Side side, std::span<const Vec3> x) const;
  Vec3 butterfly_ring(const SubdivisionLevel& level, Side side, std::span<const Vec3> x) const;
  Vec3 boundary_butterfly(const SubdivisionLevel& level, Side side, std::span<const Vec3> x) const;
  template <class Visit>
  void for_ends(const SubdivisionLevel& level, std::uint32_t edge, Visit&& visit) const;
  void update(const SubdivisionLevel& level, std::span<Vec3> x, double sign) const;
  void update_loop(const SubdivisionLevel& level, std::span<Vec3> x, double sign) const;
  std::vector<Vec3> local_fit(std::span<const Stencil> stencils, std::span<const Vec3> details,
                              std::uint32_t vertices) const;
  void fit_residual(std::span<const Stencil> stencils, std::span<const Vec3> details,
                    std::span<const Vec3> fit, std::span<Vec3> even,
                    std::span<Vec3> residual) const;
  std::vector<Vec3> means(const SubdivisionLevel& level, std::span<const Vec3> x) const;
  void mix(const SubdivisionLevel& level, std::span<Vec3> x) const;
  void unmix(const SubdivisionLevel& level, std::span<Vec3> x) const;
  void add_shares(const SubdivisionLevel& level, std::span<Vec3> x, double sign) const;

  const SubdivisionHierarchy& hierarchy_;
  Wavelet kind_;
  std::vector<VertexRule> base_rule_;  // (base vertices)
  VertexRule regular_, boundary_;
  std::vector<double> ring_weight_;
};

}  // namespace remaps::codec
