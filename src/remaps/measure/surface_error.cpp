#include "remaps/measure/surface_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/base/workers.h"
#include "remaps/measure/surface_sampler.h"
#include "remaps/mesh/closest_point_tree.h"
#include "remaps/mesh/point_triangle.h"

namespace remaps {
namespace {

constexpr std::uint64_t kLeastMemory = 1 << 20;
constexpr std::size_t kPointsPerTask = 4096;
constexpr std::uint64_t kTreeBytes = ClosestPointTree::kPeakBytesPerTriangle;

/// A tree of the scouts of one surface, and the scouts of both, in vectors that may be half empty.
constexpr std::uint64_t kScoutBytes = kTreeBytes + 4 * sizeof(TrianglePositions);

/// How many scouts a surface may have.
std::uint64_t scouts_within(std::uint64_t memory_bytes) {
  return std::min<std::uint64_t>(memory_bytes / 16 / kScoutBytes, 1 << 16);
}

/// How the memory is shared out in one direction.
struct MemoryPlan {
  /// @param triangles  of the surface that is searched
  /// @param points     on the other
  MemoryPlan(std::uint64_t bytes, std::uint64_t triangles, std::uint64_t points) {
    const std::uint64_t available = bytes - scouts_within(bytes) * kScoutBytes;
    const std::uint64_t whole = triangles * kTreeBytes;
    // If the whole surface does not fit, every block costs a build of all its parts: few blocks,
    // then.
    const std::uint64_t share = whole <= available / 4 * 3 ? available - whole : available / 2;
    block_points = std::min(points, share / sizeof(SurfacePoint));
    part_triangles = (available - block_points * sizeof(SurfacePoint)) / kTreeBytes;
    part_triangles = std::min<std::uint64_t>({part_triangles, triangles, kNoIndex - 1});
  }

  std::uint64_t block_points;    // that are in memory at a time
  std::uint64_t part_triangles;  // of the surface that is searched, in a tree at a time
};

/// A surface as one or more trees that are in memory one after another.
class TreeSequence {
 public:
  TreeSequence(const TriangleSource& surface, const SurfaceSummary& summary,
               std::uint64_t part_triangles, unsigned threads)
      : surface_(surface),
        scouts_(summary.scouts),
        part_size_(part_triangles),
        parts_((summary.triangles + part_size_ - 1) / part_size_),
        threads_(parts_ > 1 && part_size_ < kLeastForThreads ? 1 : threads) {}

  /// How many trees a pass shows at most.
  std::uint64_t size() const { return parts_ == 1 ? 1 : parts_ + 1; }

  /// Shows a tree of scouts, if there is more than one part, and then a tree of each part.
  ///
  /// @param wanted  asked with the box of a part before its tree is built; it is left out at a no
  void pass(FunctionRef<bool(const Box3&)> wanted,
            FunctionRef<void(const ClosestPointTree&)> show) {
    if (parts_ == 1) {
      if (!kept_) {
        stream_parts([&](std::vector<TrianglePositions>& part) {
          kept_.emplace(std::move(part), threads_);
        });
      }
      if (!kept_) throw GeometryError("the surface changed between two passes");
      show(*kept_);
      return;
    }
    if (!kept_) kept_.emplace(scouts_, threads_);
    show(*kept_);
    stream_parts([&](std::vector<TrianglePositions>& part) {
      if (!wanted(box_of(part))) return;
      ClosestPointTree tree(std::move(part), threads_);
      show(tree);
      part = std::move(tree).release();
    });
  }

 private:
  /// Smaller parts are built by one thread: memory that Embree's own threads free stays in their
  /// arenas.
  static constexpr std::uint64_t kLeastForThreads = 1 << 19;

  static Box3 box_of(std::span<const TrianglePositions> part) {
    Box3 box;
    for (const TrianglePositions& triangle : part) {
      for (const Vec3& corner : triangle) box.add(corner);
    }
    return box;
  }

  void stream_parts(FunctionRef<void(std::vector<TrianglePositions>&)> take) const {
    std::vector<TrianglePositions> part;
    part.reserve(part_size_);
    surface_([&](std::span<const TrianglePositions> chunk) {
      while (!chunk.empty()) {
        const std::size_t n = std::min<std::size_t>(chunk.size(), part_size_ - part.size());
        part.insert(part.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(n));
        chunk = chunk.subspan(n);
        if (part.size() < part_size_) continue;
        take(part);
        part.clear();
      }
    });
    if (!part.empty()) take(part);
  }

  const TriangleSource& surface_;
  const std::vector<TrianglePositions>& scouts_;
  const std::size_t part_size_;
  const std::uint64_t parts_;
  const unsigned threads_;
  std::optional<ClosestPointTree> kept_;
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

/// Whether something in the box could be nearer to one of the points than what it has.
bool any_near(std::span<const SurfacePoint> points, const Box3& box) {
  return std::any_of(points.begin(), points.end(), [&](const SurfacePoint& point) {
    return box_distance2(point.position, box) * (1 - 1e-9) <= point.distance2;
  });
}

/// Distances from one surface to another: one direction of the measure.
class Direction {
 public:
  Direction(const TriangleSource& from, const SurfaceSummary& from_summary,
            const TriangleSource& to, const SurfaceSummary& to_summary,
            const SurfaceErrorOptions& options)
      : from_(from),
        summary_(from_summary),
        plan_{.samples = std::max<std::uint64_t>(options.samples, 1),
              .seed = options.seed,
              .corners = 3 * from_summary.triangles <= options.samples},
        memory_(options.memory_bytes, to_summary.triangles, plan_.points(from_summary)),
        trees_(to, to_summary, memory_.part_triangles, options.threads),
        options_(options) {}

  /// @param begun  the fraction of the whole job that is done before this direction, which is a
  /// half of it
  DistanceSums measure(double begun) {
    const std::uint64_t n = plan_.points(summary_);
    const std::uint64_t blocks = (n + memory_.block_points - 1) / memory_.block_points;
    DistanceSums sums;
    std::vector<SurfacePoint> points;
    for (std::uint64_t block = 0; block < blocks; ++block) {
      const std::uint64_t first = block * memory_.block_points;
      const std::uint64_t last = std::min(n, first + memory_.block_points);
      sample_surface(from_, summary_, plan_, first, last, points, options_.progress);
      std::uint64_t shown = 0;
      trees_.pass([&](const Box3& box) { return any_near(points, box); },
                  [&](const ClosestPointTree& tree) {
                    approach_all(points, tree);
                    const double share =
                        static_cast<double>(++shown) / static_cast<double>(trees_.size());
                    report(begun + 0.5 * (static_cast<double>(block) + share) /
                                       static_cast<double>(blocks));
                  });
      sums.add(points);
    }
    report(begun + 0.5);
    return sums;
  }

 private:
  void report(double fraction) const {
    if (options_.progress != nullptr) options_.progress->advance(fraction);
  }

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
  const MemoryPlan memory_;
  TreeSequence trees_;
  const SurfaceErrorOptions& options_;
};

}  // namespace

SurfaceError measure_surface_error(const TriangleSource& original, const TriangleSource& remesh,
                                   const SurfaceErrorOptions& options) {
  if (options.memory_bytes < kLeastMemory) {
    throw BudgetError("measuring takes at least 1 MiB of memory");
  }
  const std::uint64_t scouts = scouts_within(options.memory_bytes);
  if (options.progress != nullptr) options.progress->begin("measure");
  const SurfaceSummary of_original = summarise_surface(original, scouts, options.progress);
  const SurfaceSummary of_remesh = summarise_surface(remesh, scouts, options.progress);

  const DistanceSums forward =
      Direction(original, of_original, remesh, of_remesh, options).measure(0);
  const DistanceSums backward =
      Direction(remesh, of_remesh, original, of_original, options).measure(0.5);

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
