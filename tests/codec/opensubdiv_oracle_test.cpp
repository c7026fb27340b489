#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <memory>

#include "codec/codec_shapes.h"
#include "remaps/codec/wavelet.h"

namespace remaps::codec {
namespace {

using OpenSubdiv::Far::PrimvarRefiner;
using OpenSubdiv::Far::TopologyDescriptor;
using OpenSubdiv::Far::TopologyRefiner;
using OpenSubdiv::Far::TopologyRefinerFactory;
using OpenSubdiv::Sdc::Options;

/// A point as PrimvarRefinerReal wants it.
struct Point {
  Vec3 at;
  void Clear() { at = {}; }
  void AddWithWeight(const Point& p, double weight) { at = at + weight * p.at; }
};

/// Loop's refinement of a mesh by one level, by OpenSubdiv: the values of its vertices, then those
/// of its edges, by the numbers of `level`.
std::vector<Vec3> refined(const SubdivisionLevel& level, std::span<const Vec3> coarse) {
  std::vector<int> corners(level.faces(), 3), vertices;
  for (const Face& face : level.vertex) {
    for (const std::uint32_t v : face) vertices.push_back(static_cast<int>(v));
  }
  TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(level.vertices);
  descriptor.numFaces = static_cast<int>(level.faces());
  descriptor.numVertsPerFace = corners.data();
  descriptor.vertIndicesPerFace = vertices.data();
  Options options;
  options.SetVtxBoundaryInterpolation(Options::VTX_BOUNDARY_EDGE_ONLY);
  const std::unique_ptr<TopologyRefiner> refiner(TopologyRefinerFactory<TopologyDescriptor>::Create(
      descriptor, {OpenSubdiv::Sdc::SCHEME_LOOP, options}));
  TopologyRefiner::UniformOptions uniform(1);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);
  std::vector<Point> from(coarse.size()),
      to(static_cast<std::size_t>(refiner->GetLevel(1).GetNumVertices()));
  for (std::size_t i = 0; i < from.size(); ++i) from[i].at = coarse[i];
  OpenSubdiv::Far::PrimvarRefinerReal<double>(*refiner).Interpolate(1, from, to);
  const auto& base = refiner->GetLevel(0);
  std::vector<Vec3> result(level.vertices + level.edges());
  for (std::uint32_t v = 0; v < level.vertices; ++v) {
    result[v] = to[static_cast<std::size_t>(base.GetVertexChildVertex(static_cast<int>(v)))].at;
  }
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const Side s = level.side[e];
    const int edge = base.FindEdge(static_cast<int>(level.from(s)), static_cast<int>(level.to(s)));
    result[level.vertices + e] = to[static_cast<std::size_t>(base.GetEdgeChildVertex(edge))].at;
  }
  return result;
}

TEST(OpenSubdivOracle, LoopWithoutDetailsIsLoopSubdivision) {
  std::mt19937_64 random(1);
  std::vector<test::CodecBase> bases = test::codec_bases();
  for (unsigned valence = 3; valence <= 14; ++valence) {
    bases.push_back(test::base_of(test::bipyramid(valence)));
  }
  for (const test::CodecBase& base : bases) {
    SCOPED_TRACE(base.name);
    MemoryBudget budget(256u << 20);
    const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 3, budget);
    const WaveletTransform transform(hierarchy, Wavelet::kLoop);
    std::vector<Vec3> x = test::random_values(hierarchy.vertices(0), random);
    for (unsigned j = 0; j < 3; ++j) {
      const std::vector<Vec3> expected = refined(hierarchy.level(j), x);
      x.resize(hierarchy.vertices(j + 1));
      transform.synthesise(j, x);
      for (std::uint32_t v = 0; v < x.size(); ++v) {
        ASSERT_LT(norm(x[v] - expected[v]), 1e-12)
            << "level " << j << ", vertex " << v << " of " << hierarchy.vertices(j);
      }
    }
  }
}

}  // namespace
}  // namespace remaps::codec
