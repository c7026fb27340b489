#include "remaps/resample/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include "remaps/base/workers.h"
#include "remaps/mesh/closest_point_tree.h"

namespace remaps::resample {
namespace {

constexpr std::size_t kBlock = 1 << 14;  // samples a task
constexpr std::uint64_t kMatrixBytesPerFace = 110;

/// A number in [0, 1) from a counter.
double hashed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return double((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

double area_of(const TrianglePositions& t) {
  return 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
}

/// Points spread evenly over a streamed surface: one each `spacing` of area, at a hashed place in
/// its triangle.
class EvenSampler {
 public:
  explicit EvenSampler(double spacing) : spacing_(spacing) {}

  void sample(const TrianglePositions& t, std::vector<Vec3>& out) {
    carry_ += area_of(t);
    while (carry_ >= spacing_) {
      carry_ -= spacing_;
      double u = hashed(2 * count_);
      double v = hashed(2 * count_ + 1);
      ++count_;
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      out.push_back(t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]));
    }
  }

 private:
  double spacing_;
  double carry_ = 0;
  std::uint64_t count_ = 0;
};

/// The normal equations of one round: element matrices a face, right-hand sides a vertex.
class NormalEquations {
 public:
  NormalEquations(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t vertices,
                  double stiffness)
      : triangles_(triangles),
        element_(triangles.size()),
        diagonal_(vertices, stiffness),
        right_(vertices) {}

  /// One sample: its foot point has weights w on a face and lies `residual` short of it.
  void add(std::size_t face, const std::array<double, 3>& w, const Vec3& residual) {
    auto& m = element_[face];
    m[0] += w[0] * w[1];
    m[1] += w[1] * w[2];
    m[2] += w[2] * w[0];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = triangles_[face][i];
      diagonal_[v] += w[i] * w[i];
      right_[v] = right_[v] + w[i] * residual;
    }
  }

  /// Conjugate gradients with the diagonal as preconditioner.
  std::vector<Vec3> solve(unsigned iterations) const {
    const std::size_t n = right_.size();
    std::vector<Vec3> x(n);
    std::vector<Vec3> r = right_;
    std::vector<Vec3> z(n);
    std::vector<Vec3> p(n);
    std::vector<Vec3> ap(n);
    double rz = precondition(r, z);
    const double enough = 1e-8 * rz;
    p = z;
    for (unsigned k = 0; k < iterations && rz > enough; ++k) {
      multiply(p, ap);
      double pap = 0;
      for (std::size_t i = 0; i < n; ++i) pap += dot(p[i], ap[i]);
      if (!(pap > 0)) break;
      const double alpha = rz / pap;
      for (std::size_t i = 0; i < n; ++i) {
        x[i] = x[i] + alpha * p[i];
        r[i] = r[i] - alpha * ap[i];
      }
      const double next = precondition(r, z);
      const double beta = next / rz;
      rz = next;
      for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + beta * p[i];
    }
    return x;
  }

 private:
  double precondition(const std::vector<Vec3>& r, std::vector<Vec3>& z) const {
    double sum = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
      z[i] = (1 / diagonal_[i]) * r[i];
      sum += dot(r[i], z[i]);
    }
    return sum;
  }

  void multiply(const std::vector<Vec3>& x, std::vector<Vec3>& out) const {
    for (std::size_t i = 0; i < x.size(); ++i) out[i] = diagonal_[i] * x[i];
    for (std::size_t f = 0; f < triangles_.size(); ++f) {
      const auto& [a, b, c] = triangles_[f];
      const auto& m = element_[f];
      out[a] = out[a] + m[0] * x[b] + m[2] * x[c];
      out[b] = out[b] + m[0] * x[a] + m[1] * x[c];
      out[c] = out[c] + m[1] * x[b] + m[2] * x[a];
    }
  }

  std::span<const std::array<std::uint32_t, 3>> triangles_;
  std::vector<std::array<double, 3>> element_;  // (f) off-diagonal: corners 0-1, 1-2, 2-0
  std::vector<double> diagonal_;
  std::vector<Vec3> right_;
};

struct Foot {
  std::size_t face;
  std::array<double, 3> weights;
  Vec3 residual;
};

/// Projects a block of samples; neighbours in the stream help each other to a first guess.
std::vector<Foot> project(const ClosestPointTree& tree, std::span<const Vec3> samples) {
  std::vector<Foot> feet;
  feet.reserve(samples.size());
  LocalIndex hint = kNoIndex;
  for (const Vec3& p : samples) {
    const ClosestPoint found = tree.closest(p, std::numeric_limits<double>::infinity(), hint);
    hint = found.triangle;
    const TrianglePositions& t = tree.triangles()[found.triangle];
    const auto& w = found.weights;
    feet.push_back({found.triangle, w, p - (w[0] * t[0] + w[1] * t[1] + w[2] * t[2])});
  }
  return feet;
}

/// Sends all samples through the tree into the equations, a batch of blocks at a time.
void assemble(const ClosestPointTree& tree, const TriangleSource& original, double spacing,
              const FitOptions& options, NormalEquations& equations) {
  const std::size_t batch = kBlock * 4 * std::max(1u, options.threads);
  std::vector<Vec3> waiting;
  const auto flush = [&] {
    const std::size_t blocks = (waiting.size() + kBlock - 1) / kBlock;
    run_ordered(blocks, options.threads, [&](std::size_t i, unsigned) -> Commit {
      if (options.progress != nullptr) options.progress->check();
      const std::span<const Vec3> all(waiting);
      auto feet = std::make_shared<std::vector<Foot>>(
          project(tree, all.subspan(i * kBlock, std::min(kBlock, all.size() - i * kBlock))));
      return [feet, &equations] {
        for (const Foot& foot : *feet) equations.add(foot.face, foot.weights, foot.residual);
      };
    });
    waiting.clear();
  };
  EvenSampler sampler(spacing);
  original([&](std::span<const TrianglePositions> triangles) {
    for (const TrianglePositions& t : triangles) {
      sampler.sample(t, waiting);
      if (waiting.size() >= batch) flush();
    }
  });
  flush();
}

}  // namespace

void fit_vertices(std::span<const std::array<std::uint32_t, 3>> triangles,
                  const TriangleSource& original, const FitOptions& options, MemoryBudget& budget,
                  std::vector<Vec3>& positions) {
  const Reservation reservation = budget.reserve(
      triangles.size() * (ClosestPointTree::kPeakBytesPerTriangle + kMatrixBytesPerFace),
      "fitting the output's vertices (--fit)");
  double area = 0;
  original([&](std::span<const TrianglePositions> part) {
    for (const TrianglePositions& t : part) area += area_of(t);
  });
  if (!(area > 0)) return;
  const double spacing = area / (options.samples_per_vertex * double(positions.size()));
  std::vector<TrianglePositions> corners(triangles.size());
  for (unsigned round = 0; round < options.rounds; ++round) {
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      for (std::size_t i = 0; i < 3; ++i) corners[f][i] = positions[triangles[f][i]];
    }
    ClosestPointTree tree(std::move(corners), options.threads);
    NormalEquations equations(triangles, positions.size(), options.stiffness);
    assemble(tree, original, spacing, options, equations);
    corners = std::move(tree).release();
    const std::vector<Vec3> moves = equations.solve(options.iterations);
    for (std::size_t v = 0; v < positions.size(); ++v) positions[v] = positions[v] + moves[v];
    if (options.progress != nullptr) options.progress->advance(double(round + 1) / options.rounds);
  }
}

}  // namespace remaps::resample
