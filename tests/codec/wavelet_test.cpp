#include "remaps/codec/wavelet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codec/codec_shapes.h"

namespace remaps::codec {
namespace {

constexpr std::uint64_t kMemory = 256u << 20;
constexpr Wavelet kKinds[] = {Wavelet::kButterfly, Wavelet::kLiftedButterfly, Wavelet::kLoop};

std::string name_of(Wavelet kind) {
  return kind == Wavelet::kButterfly         ? "butterfly"
         : kind == Wavelet::kLiftedButterfly ? "lifted butterfly"
                                             : "loop";
}

void analyse_all(const SubdivisionHierarchy& hierarchy, Wavelet kind, std::vector<Vec3>& x) {
  const WaveletTransform transform(hierarchy, kind);
  for (unsigned j = hierarchy.levels(); j-- > 0;) {
    transform.analyse(j, std::span(x).first(hierarchy.vertices(j + 1)));
  }
}

void synthesise_all(const SubdivisionHierarchy& hierarchy, Wavelet kind, std::vector<Vec3>& x) {
  const WaveletTransform transform(hierarchy, kind);
  for (unsigned j = 0; j < hierarchy.levels(); ++j) {
    transform.synthesise(j, std::span(x).first(hierarchy.vertices(j + 1)));
  }
}

double largest_difference(std::span<const Vec3> a, std::span<const Vec3> b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, norm(a[i] - b[i]));
  return largest;
}

std::vector<test::CodecBase> bases() {
  std::vector<test::CodecBase> all = test::codec_bases();
  for (unsigned valence = 3; valence <= 14; ++valence) {
    all.push_back(test::base_of(test::bipyramid(valence)));
    all.push_back(test::base_of(test::cone(valence)));
  }
  return all;
}

TEST(WaveletTransform, IsInvertible) {
  std::mt19937_64 random(1);
  for (const test::CodecBase& base : bases()) {
    for (const unsigned levels : {1u, 4u}) {
      MemoryBudget budget(kMemory);
      const SubdivisionHierarchy hierarchy(base.vertices(), base.face, levels, budget);
      const std::vector<Vec3> values = test::random_values(hierarchy.vertices(), random);
      for (const Wavelet kind : kKinds) {
        std::vector<Vec3> x = values;
        analyse_all(hierarchy, kind, x);
        synthesise_all(hierarchy, kind, x);
        EXPECT_LT(largest_difference(x, values), 1e-12) << base.name << ", " << name_of(kind);
        synthesise_all(hierarchy, kind, x);
        analyse_all(hierarchy, kind, x);
        EXPECT_LT(largest_difference(x, values), 1e-12) << base.name << ", " << name_of(kind);
      }
    }
  }
}

TEST(WaveletTransform, OfAConstantIsTheConstant) {
  for (const test::CodecBase& base : bases()) {
    MemoryBudget budget(kMemory);
    const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 3, budget);
    for (const Wavelet kind : kKinds) {
      std::vector<Vec3> x(hierarchy.vertices(), Vec3{1, -2, 3});
      analyse_all(hierarchy, kind, x);
      for (std::uint32_t v = 0; v < x.size(); ++v) {
        const Vec3 expected = v < base.vertices() ? Vec3{1, -2, 3} : Vec3{};
        ASSERT_LT(norm(x[v] - expected), 1e-12) << base.name << ", " << name_of(kind);
      }
    }
  }
}

/// A regular torus of n x n vertices, cut open and laid on the plane.
struct PlaneGrid {
  explicit PlaneGrid(unsigned size)
      : n(size), base(test::base_of(test::torus(n, n))), place(base.position.size()) {
    // Neighbours of vertex 0 and so on are found from the faces alone: (row, column) by a walk.
    std::vector<bool> known(place.size(), false);
    known[base.face[0][0]] = known[base.face[0][1]] = known[base.face[0][2]] = true;
    place[base.face[0][1]] = {1, 0, 0};
    place[base.face[0][2]] = {0, 1, 0};
    bool more = true;
    while (more) {
      more = false;
      for (const Face& face : base.face) {
        for (unsigned k = 0; k < 3; ++k) more = spread(face, k, known) || more;
      }
    }
  }

  /// The faces on both sides of an edge are a parallelogram.
  bool spread(const Face& face, unsigned k, std::vector<bool>& known) {
    const std::uint32_t a = face[k], b = face[(k + 1) % 3], c = face[(k + 2) % 3];
    if (!known[a] || !known[b] || !known[c]) return false;
    for (const Face& other : base.face) {
      for (unsigned l = 0; l < 3; ++l) {
        const std::uint32_t d = other[(l + 2) % 3];
        if (other[l] != b || other[(l + 1) % 3] != a || known[d]) continue;
        place[d] = place[a] + place[b] - place[c];
        known[d] = true;
        return true;
      }
    }
    return false;
  }

  unsigned n;
  test::CodecBase base;
  std::vector<Vec3> place;  // (vertices) x and y on the grid
};

/// Places of the fine vertices whose coarse neighbourhood of two rings is not cut by the walk, or
/// none.
std::vector<std::pair<std::uint32_t, Vec3>> whole_edges(const SubdivisionLevel& level,
                                                        std::span<const Vec3> place) {
  std::vector<std::vector<std::uint32_t>> ring(level.vertices);
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const std::uint32_t a = level.from(level.side[e]), b = level.to(level.side[e]);
    ring[a].push_back(b);
    ring[b].push_back(a);
  }
  std::vector<bool> whole(level.vertices, true);
  for (std::uint32_t v = 0; v < level.vertices; ++v) {
    for (const std::uint32_t w : ring[v]) whole[v] = whole[v] && norm(place[v] - place[w]) < 1.9;
  }
  std::vector<std::pair<std::uint32_t, Vec3>> result;
  for (std::uint32_t e = 0; e < level.edges(); ++e) {
    const std::uint32_t a = level.from(level.side[e]), b = level.to(level.side[e]);
    bool all = true;
    for (const std::uint32_t v : {a, b}) {
      for (const std::uint32_t w : ring[v]) all = all && whole[v] && whole[w];
    }
    if (all) result.emplace_back(e, 0.5 * (place[a] + place[b]));
  }
  return result;
}

double monomial(const Vec3& p, unsigned i, unsigned j) {
  return std::pow(p.x, i) * std::pow(p.y, j);
}

TEST(WaveletTransform, ButterflyReproducesCubicsOfTheRegularGrid) {
  const PlaneGrid grid(9);
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(grid.base.vertices(), grid.base.face, 1, budget);
  const auto edges = whole_edges(hierarchy.level(0), grid.place);
  ASSERT_GT(edges.size(), 20u);
  const WaveletTransform transform(hierarchy, Wavelet::kButterfly);
  double of_degree_4 = 0;
  for (unsigned i = 0; i <= 4; ++i) {
    for (unsigned j = 0; i + j <= 4; ++j) {
      std::vector<Vec3> x(hierarchy.vertices());
      for (std::uint32_t v = 0; v < grid.place.size(); ++v) {
        x[v] = {monomial(grid.place[v], i, j), 0, 0};
      }
      transform.synthesise(0, x);
      for (const auto& [e, middle] : edges) {
        const double error = std::fabs(x[grid.base.vertices() + e].x - monomial(middle, i, j));
        if (i + j <= 3) {
          ASSERT_LT(error, 1e-10) << "x^" << i << " y^" << j;
        } else {
          of_degree_4 = std::max(of_degree_4, error);
        }
      }
    }
  }
  EXPECT_GT(of_degree_4, 0.1);
}

TEST(WaveletTransform, LinearFunctionsHaveNoDetails) {
  // Analysis of all kinds at vertices far from where the grid wraps around.
  const PlaneGrid grid(24);
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(grid.base.vertices(), grid.base.face, 1, budget);
  const SubdivisionLevel& level = hierarchy.level(0);
  const auto edges = whole_edges(level, grid.place);
  for (const Wavelet kind : kKinds) {
    std::vector<Vec3> x(hierarchy.vertices());
    std::copy(grid.place.begin(), grid.place.end(), x.begin());
    for (std::uint32_t e = 0; e < level.edges(); ++e) {
      const Side s = level.side[e];
      x[level.vertices + e] = 0.5 * (grid.place[level.from(s)] + grid.place[level.to(s)]);
    }
    WaveletTransform(hierarchy, kind).analyse(0, x);
    // What the wrap disturbs, 24 wide, decays by a third a ring in the coefficients of Loop's; in
    // the other kinds it ends at two rings.
    const bool loop = kind == Wavelet::kLoop;
    std::size_t clean = 0;
    for (const auto& [e, middle] : edges) {
      clean += norm(x[level.vertices + e]) < (loop ? 1e-4 : 1e-12) ? 1u : 0u;
    }
    EXPECT_GE(clean, loop ? edges.size() / 4 : edges.size()) << name_of(kind) << edges.size();
  }
}

/// Weights of a ring about a vertex, from the first edge on: what each neighbour gives the middle
/// of that edge.
std::vector<double> ring_weights(unsigned valence, double& centre) {
  const test::CodecBase coarse = test::base_of(test::bipyramid(valence));
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy first(coarse.vertices(), coarse.face, 1, budget);
  // The pole keeps its number and valence, and all about it is regular.
  const std::vector<Face> faces = test::finest_faces(first);
  const SubdivisionHierarchy hierarchy(first.vertices(), faces, 1, budget);
  const SubdivisionLevel& level = hierarchy.level(0);
  std::uint32_t pole = 0;
  while (hierarchy.valence(pole) != valence) ++pole;
  Side side;
  for (std::uint32_t f = 0; f < level.faces(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (level.vertex[f][k] == pole) side = {f, k};
    }
  }
  const std::uint32_t odd = level.vertices + level.edge[side.face()][side.corner()];
  const WaveletTransform transform(hierarchy, Wavelet::kButterfly);
  const auto weight_of = [&](std::uint32_t v) {
    std::vector<Vec3> x(hierarchy.vertices());
    x[v] = {1, 0, 0};
    transform.synthesise(0, x);
    return x[odd].x;
  };
  centre = weight_of(pole);
  std::vector<double> weights;
  for (Side s = side; weights.size() < valence; s = level.twin_of(s.previous())) {
    weights.push_back(weight_of(level.to(s)));
  }
  return weights;
}

TEST(WaveletTransform, ButterflyHasThePublishedWeightsAtExtraordinaryVertices) {
  double centre = 0;
  // Zorin, Schröder, Sweldens, SIGGRAPH 96: valence 3, 4, and of 5 by their formula.
  const std::vector<double> three = ring_weights(3, centre);
  EXPECT_NEAR(centre, 0.75, 1e-14);
  for (unsigned j = 0; j < 3; ++j) EXPECT_NEAR(three[j], j == 0 ? 5.0 / 12 : -1.0 / 12, 1e-14);
  const std::vector<double> five = ring_weights(5, centre);
  const double expected[] = {0.35, 0.030901699437495, -0.080901699437495, -0.080901699437495,
                             0.030901699437495};
  for (unsigned j = 0; j < 5; ++j) EXPECT_NEAR(five[j], expected[j], 1e-12);
  for (const unsigned valence : {3u, 5u, 7u, 8u, 9u, 10u, 11u, 12u, 13u, 14u}) {
    double sum = 0, cosine = 0, square = 0;
    const std::vector<double> weights = ring_weights(valence, centre);
    for (unsigned j = 0; j < valence; ++j) {
      const double turn = 2 * std::acos(-1.0) * j / valence;
      sum += weights[j];
      cosine += weights[j] * std::cos(turn);
      square += weights[j] * std::cos(2 * turn);
    }
    EXPECT_NEAR(centre, 0.75, 1e-14) << valence;
    EXPECT_NEAR(sum, 0.25, 1e-12) << valence;
    EXPECT_NEAR(cosine, 0.5, 1e-12) << valence;
    if (valence >= 5) {
      EXPECT_NEAR(square, 0.25, 1e-12) << valence;
    }
  }
}

/// Sum over the finest vertices of what a coefficient of 1 makes.
double mean_of_wavelet(const SubdivisionHierarchy& hierarchy, Wavelet kind, std::uint32_t v) {
  std::vector<Vec3> x(hierarchy.vertices());
  x[v] = {1, 0, 0};
  synthesise_all(hierarchy, kind, x);
  double sum = 0;
  for (const Vec3& p : x) sum += p.x;
  return sum;
}

TEST(WaveletTransform, LiftedWaveletsHaveLittleMean) {
  // On a regular mesh Butterfly's have none. Loop's are nearly orthogonal to constants.
  const test::CodecBase base = test::base_of(test::torus(9, 9));
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 2, budget);
  const std::uint32_t v = hierarchy.vertices(0) + 10;
  const double plain = mean_of_wavelet(hierarchy, Wavelet::kButterfly, v);
  EXPECT_GT(plain, 3);
  EXPECT_NEAR(mean_of_wavelet(hierarchy, Wavelet::kLiftedButterfly, v), 0, 1e-12);
  EXPECT_LT(std::fabs(mean_of_wavelet(hierarchy, Wavelet::kLoop, v)), 0.05 * plain);
}

/// Mean square of a base vertex of a valence after analysis of noise of mean square 1.
double noise_gain(Wavelet kind, unsigned valence, std::mt19937_64& random) {
  const test::CodecBase coarse = test::base_of(test::bipyramid(valence));
  MemoryBudget budget(kMemory);
  const SubdivisionHierarchy first(coarse.vertices(), coarse.face, 1, budget);
  const SubdivisionHierarchy hierarchy(first.vertices(), test::finest_faces(first), 1, budget);
  std::normal_distribution<double> normal;
  double sum = 0;
  std::size_t count = 0;
  const WaveletTransform transform(hierarchy, kind);
  for (unsigned round = 0; round < 400; ++round) {
    std::vector<Vec3> x(hierarchy.vertices());
    for (Vec3& p : x) p = {normal(random), normal(random), normal(random)};
    transform.analyse(0, x);
    for (std::uint32_t v = 0; v < first.vertices(); ++v) {
      if (hierarchy.valence(v) != valence) continue;
      sum += norm2(x[v]) / 3;
      ++count;
    }
  }
  return sum / static_cast<double>(count);
}

TEST(WaveletTransform, LoopAnalysisKeepsNoiseNearTheLeast) {
  // Least squares, computed densely: nothing linear that undoes the subdivision has less.
  std::mt19937_64 random(2);
  const double least[] = {3.01, 2.08, 1.58, 1.30, 1.12, 0.99, 0.90, 0.84, 0.78, 0.73};
  for (unsigned valence = 3; valence <= 12; ++valence) {
    const double gain = noise_gain(Wavelet::kLoop, valence, random);
    RecordProperty("gain_" + std::to_string(valence), std::to_string(gain));
    EXPECT_LT(gain, 1.2 * least[valence - 3]) << valence;
  }
}

TEST(WaveletTransform, LoopTreatsBoundariesByThemselves) {
  std::mt19937_64 random(3);
  for (const test::Shape& shape : {test::disk(3), test::annulus(7, 3), test::cone(3)}) {
    const test::CodecBase base = test::base_of(shape);
    MemoryBudget budget(kMemory);
    const SubdivisionHierarchy hierarchy(base.vertices(), base.face, 3, budget);
    std::vector<Vec3> one = test::random_values(hierarchy.vertices(), random), other = one;
    for (std::uint32_t v = 0; v < other.size(); ++v) {
      if (!hierarchy.on_boundary(v)) other[v] = Vec3{7, 7, 7};
    }
    for (const bool analyse : {true, false}) {
      std::vector<Vec3> a = one, b = other;
      for (std::vector<Vec3>* x : {&a, &b}) {
        (analyse ? analyse_all : synthesise_all)(hierarchy, Wavelet::kLoop, *x);
      }
      for (std::uint32_t v = 0; v < a.size(); ++v) {
        if (!hierarchy.on_boundary(v)) continue;
        ASSERT_EQ(a[v], b[v]) << shape.name;
      }
    }
  }
}

}  // namespace
}  // namespace remaps::codec
