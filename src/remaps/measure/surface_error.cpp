#include "remaps/measure/surface_error.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/base/workers.h"
#include "remaps/measure/closest_point_tree.h"
#include "remaps/measure/surface_sampler.h"

namespace remaps {
namespace {

constexpr std::uint64_t kLeastMemory = 1 << 20;
constexpr std::size_t kPointsPerTask = 4096;
constexpr std::uint64_t kTreeBytes = ClosestPointTree::kPeakBytesPerTriangle;

/// How the memory is shared out.
struct MemoryPlan {
  explicit MemoryPlan(std::uint64_t bytes) {
    if (bytes < kLeastMemory) throw BudgetError("measuring takes at least 1 MiB of memory");
    points = bytes / 4 / sizeof(SurfacePoint);
    // A tree of the scouts of one surface, and the scouts of both waiting for their turn.
    constexpr std::uint64_t kScoutBytes = kTreeBytes + 4 * sizeof(TrianglePositions);
    scouts = std::min<std::uint64_t>(bytes / 16 / kScoutBytes, 1 << 16);
    tree_triangles = (bytes - points * sizeof(SurfacePoint) - scouts * kScoutBytes) / kTreeBytes;
    tree_triangles = std::min<std::uint64_t>(tree_triangles, kNoIndex - 1);
  }

  std::uint64_t points;          // of a block
  std::uint64_t scouts;          // of a surface
  std::uint64_t tree_triangles;  // of a part of a surface
};

/// A surface as one or more trees that are in memory one after another.
class TreeSequence {
 public:
  TreeSequence(const TriangleSource& surface, const SurfaceSummary& summary, const MemoryPlan& plan,
               unsigned threads)
      : surface_(surface),
        scouts_(summary.scouts),
        part_size_(std::min(plan.tree_triangles, summary.triangles)),
        parts_((summary.triangles + part_size_ - 1) / part_size_),
        threads_(threads) {}

  /// How many trees a pass shows.
  std::uint64_t size() const { return parts_ == 1 ? 1 : parts_ + 1; }

  /// Shows a tree of scouts, if there is more than one part, and a tree of each part.
  void pass(FunctionRef<void(const ClosestPointTree&)> show) {
    if (parts_ == 1) {
      if (!kept_) stream_parts([&](ClosestPointTree& tree) { kept_ = std::move(tree); });
      show(*kept_);
      return;
    }
    if (!kept_) kept_.emplace(scouts_, threads_);
    show(*kept_);
    stream_parts([&](ClosestPointTree& tree) {
      show(tree);
      part_ = std::move(tree).release();
    });
  }

 private:
  void stream_parts(FunctionRef<void(ClosestPointTree&)> take) {
    const auto finish_part = [&] {
      ClosestPointTree tree(std::move(part_), threads_);
      part_ = {};
      take(tree);
      part_.clear();
    };
    part_.reserve(part_size_);
    surface_([&](std::span<const TrianglePositions> chunk) {
      while (!chunk.empty()) {
        const std::size_t n = std::min<std::size_t>(chunk.size(), part_size_ - part_.size());
        part_.insert(part_.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(n));
        chunk = chunk.subspan(n);
        if (part_.size() == part_size_) finish_part();
      }
    });
    if (!part_.empty()) finish_part();
    part_ = {};
  }

  const TriangleSource& surface_;
  const std::vector<TrianglePositions>& scouts_;
  const std::size_t part_size_;
  const std::uint64_t parts_;
  const unsigned threads_;
  std::optional<ClosestPointTree> kept_;
  std::vector<TrianglePositions> part_;
};

/// Sums over the samples of one surface, in the units of the file.
struct DistanceSums {
  double squares = 0, distances = 0, max2 = 0;
  std::uint64_t samples = 0;

  void add(std::span<const SurfacePoint> points) {
    for (const SurfacePoint& point : points) {
      max2 = std::max(max2, point.distance2);
      if (point.is_corner()) continue;
      squares += point.distance2;
      distances += std::sqrt(point.distance2);
      ++samples;
    }
  }
  double l2() const { return std::sqrt(squares / static_cast<double>(samples)); }
  double mean() const { return distances / static_cast<double>(samples); }
};

/// Lowers the distances of a few points to what a tree has nearer.
void approach(std::span<SurfacePoint> points, const ClosestPointTree& tree) {
  LocalIndex hint = kNoIndex;
  for (std::size_t i = 0; i < points.size(); ++i) {
    SurfacePoint& point = points[i];
    if (i > 0 && point.position == points[i - 1].position) {  // a corner that triangles share
      point.distance2 = points[i - 1].distance2;
      continue;
    }
    const ClosestPoint found = tree.closest(point.position, point.distance2, hint);
    if (found.triangle == kNoIndex) continue;
    hint = found.triangle;
    point.distance2 = found.distance2;
  }
}

/// Distances from one surface to another: one direction of the measure.
class Direction {
 public:
  Direction(const TriangleSource& from, const SurfaceSummary& from_summary,
            const TriangleSource& to, const SurfaceSummary& to_summary,
            const SurfaceErrorOptions& options, const MemoryPlan& memory)
      : from_(from),
        summary_(from_summary),
        plan_{.samples = std::max<std::uint64_t>(options.samples, 1),
              .seed = options.seed,
              .corners = 3 * from_summary.triangles <= options.samples},
        block_size_(std::min(memory.points, plan_.points(from_summary))),
        trees_(to, to_summary, memory, options.threads),
        options_(options) {}

  /// @param begun  the fraction of the whole job that is done before this direction, which is a
  /// half of it
  DistanceSums measure(double begun) {
    const std::uint64_t n = plan_.points(summary_);
    const std::uint64_t blocks = (n + block_size_ - 1) / block_size_;
    const double step = 0.5 / static_cast<double>(blocks * trees_.size());
    DistanceSums sums;
    std::vector<SurfacePoint> points;
    for (std::uint64_t first = 0; first < n; first += block_size_) {
      const std::uint64_t last = std::min(n, first + block_size_);
      sample_surface(from_, summary_, plan_, first, last, points, options_.progress);
      trees_.pass([&](const ClosestPointTree& tree) {
        approach_all(points, tree);
        begun += step;
        if (options_.progress != nullptr) options_.progress->advance(std::min(begun, 1.0));
      });
      sums.add(points);
    }
    return sums;
  }

 private:
  void approach_all(std::span<SurfacePoint> points, const ClosestPointTree& tree) const {
    const std::size_t tasks = (points.size() + kPointsPerTask - 1) / kPointsPerTask;
    run_ordered(tasks, options_.threads, [&](std::size_t i, unsigned) -> Commit {
      if (options_.progress != nullptr) options_.progress->check();
      const std::size_t first = i * kPointsPerTask;
      approach(points.subspan(first, std::min(kPointsPerTask, points.size() - first)), tree);
      return [] {};
    });
  }

  const TriangleSource& from_;
  const SurfaceSummary& summary_;
  const SamplingPlan plan_;
  const std::uint64_t block_size_;
  TreeSequence trees_;
  const SurfaceErrorOptions& options_;
};

}  // namespace

SurfaceError measure_surface_error(const TriangleSource& original, const TriangleSource& remesh,
                                   const SurfaceErrorOptions& options) {
  const MemoryPlan memory(options.memory_bytes);
  if (options.progress != nullptr) options.progress->begin("measure");
  const SurfaceSummary of_original = summarise_surface(original, memory.scouts, options.progress);
  const SurfaceSummary of_remesh = summarise_surface(remesh, memory.scouts, options.progress);

  const DistanceSums forward =
      Direction(original, of_original, remesh, of_remesh, options, memory).measure(0);
  const DistanceSums backward =
      Direction(remesh, of_remesh, original, of_original, options, memory).measure(0.5);

  const double diagonal = of_original.box.diagonal();
  return {.diagonal = diagonal,
          .l2_forward = forward.l2() / diagonal,
          .mean_forward = forward.mean() / diagonal,
          .max_forward = std::sqrt(forward.max2) / diagonal,
          .l2_backward = backward.l2() / diagonal,
          .mean_backward = backward.mean() / diagonal,
          .max_backward = std::sqrt(backward.max2) / diagonal,
          .samples_forward = forward.samples,
          .samples_backward = backward.samples};
}

}  // namespace remaps
