#include "remaps/measure/surface_error.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/measure/piece_tree.h"
#include "remaps/measure/sample_tree.h"
#include "remaps/measure/surface_sampler.h"

namespace remaps {
namespace {

constexpr std::uint64_t kLeastMemory = 1 << 20;

/// A scout, its place along the area, and a tree of scouts.
constexpr std::uint64_t kScoutBytes = sizeof(Vec3) + sizeof(double) + BoxTree::kBytesPerItem;

std::size_t scouts_within(std::uint64_t memory_bytes) {
  return static_cast<std::size_t>(
      std::min<std::uint64_t>(memory_bytes / 16 / kScoutBytes, 1 << 17));
}

/// How the memory is shared out: an eighth for scouts, a quarter for pieces and their trees, the
/// rest for points. The number of threads decides on nothing but itself.
struct MemoryShares {
  MemoryShares(const SurfaceErrorOptions& options, const SurfaceSummary& a,
               const SurfaceSummary& b) {
    const std::uint64_t bytes = options.memory_bytes;
    const std::uint64_t lane =
        PieceTree::kBytesPerTriangle * std::max(a.largest_piece, b.largest_piece);
    threads = static_cast<unsigned>(
        std::clamp<std::uint64_t>(bytes / 4 / lane, 1, std::max(options.threads, 1u)));
    const std::uint64_t lists = (a.pieces.size() + b.pieces.size()) * sizeof(SurfaceSummary::Piece);
    const std::uint64_t other = bytes / 8 + std::max(bytes / 4, lane) + lists;
    points = std::max(bytes - std::min(other, bytes), bytes / 8) / SampleTree::kBytesPerPoint;
  }

  unsigned threads;      // whose pieces have room
  std::uint64_t points;  // of both surfaces at a time
};

/// Sums over the samples of one surface, in the units of the file.
struct DistanceSums {
  double squares = 0, distances = 0, max2 = 0;
  std::uint64_t samples = 0;

  double l2() const { return std::sqrt(squares / static_cast<double>(samples)); }
  double mean() const { return distances / static_cast<double>(samples); }
};

// What a triangle costs in each pass, relative to the others.
constexpr double kSummarised = 1, kSampled = 1, kSampledAndMatched = 3, kMatched = 2;

/// How far the whole job is: triangles that have passed, by their costs.
class Work {
 public:
  Work(Progress* progress, double all) : progress_(progress), all_(all) {}

  void check() const {
    if (progress_ != nullptr) progress_->check();
  }
  void advance(double done) {
    done_ += done;
    if (progress_ != nullptr) progress_->advance(std::min(done_ / all_, 1.0));
  }

 private:
  Progress* progress_;
  double all_;
  double done_ = 0;
};

/// One of the two surfaces, with the points of it that are held at present.
class Side {
 public:
  Side(const SurfacePieces& surface, SurfaceSummary summary, const SurfaceErrorOptions& options)
      : surface_(surface),
        summary_(std::move(summary)),
        plan_{.samples = std::max<std::uint64_t>(options.samples, 1), .seed = options.seed},
        corners_(3 * summary_.triangles <= options.samples ? 3 * summary_.triangles : 0) {}

  const SurfacePieces& surface() const { return surface_; }
  const SurfaceSummary& summary() const { return summary_; }
  std::uint64_t points() const { return plan_.samples + corners_; }

  /// Makes ready to take the points of one of `parts` parts.
  SurfaceSampler begin(std::uint64_t part, std::uint64_t parts) {
    const auto cut = [&](std::uint64_t n, std::uint64_t at) {
      return n / parts * at + std::min(n % parts, at);
    };
    SamplingPlan plan = plan_;
    plan.first_sample = cut(plan_.samples, part);
    plan.last_sample = cut(plan_.samples, part + 1);
    plan.first_corner = cut(corners_, part);
    plan.last_corner = cut(corners_, part + 1);
    waiting_.samples.reserve(plan.last_sample - plan.first_sample);
    waiting_.corners.reserve(plan.last_corner - plan.first_corner);
    expected_ = plan.last_sample - plan.first_sample + plan.last_corner - plan.first_corner;
    return SurfaceSampler(summary_, plan);
  }

  void take(const SurfacePoints& points) {
    waiting_.samples.insert(waiting_.samples.end(), points.samples.begin(), points.samples.end());
    waiting_.corners.insert(waiting_.corners.end(), points.corners.begin(), points.corners.end());
  }

  /// Makes trees of the points taken, and bounds their distances to the other surface.
  void plant(const SurfaceSummary& other, double scale) {
    if (waiting_.samples.size() + waiting_.corners.size() != expected_) {
      throw GeometryError("the surface changed between two passes");
    }
    samples_ = SampleTree(std::exchange(waiting_.samples, {}), SampleTree::Repeats::keep);
    corners_tree_ = SampleTree(std::exchange(waiting_.corners, {}), SampleTree::Repeats::drop);
    samples_.bound_by(other.scouts, scale);
    corners_tree_.bound_by(other.scouts, scale);
  }

  bool any_near(const Box3& box) { return samples_.any_near(box) || corners_tree_.any_near(box); }

  void approach(const PieceTree& piece, SampleTree::Scratch& scratch) {
    samples_.approach(piece, scratch);
    corners_tree_.approach(piece, scratch);
  }

  /// Adds up the distances, and lets go of the points.
  void harvest() {
    for (const SurfacePoint& point : samples_.points()) {
      const double distance2 = point.distance2();
      sums_.max2 = std::max(sums_.max2, distance2);
      sums_.squares += distance2;
      sums_.distances += std::sqrt(distance2);
      ++sums_.samples;
    }
    for (const SurfacePoint& point : corners_tree_.points()) {
      sums_.max2 = std::max(sums_.max2, point.distance2());
    }
    samples_ = {};
    corners_tree_ = {};
  }

  const DistanceSums& sums() const { return sums_; }

 private:
  const SurfacePieces& surface_;
  const SurfaceSummary summary_;
  const SamplingPlan plan_;
  const std::uint64_t corners_;
  std::uint64_t expected_ = 0;
  SurfacePoints waiting_;
  SampleTree samples_, corners_tree_;
  DistanceSums sums_;
};

/// The passes after the first.
class Passes {
 public:
  Passes(double scale, unsigned threads, Work& work)
      : scale_(scale), threads_(threads), work_(work), lanes_(threads) {}

  /// Streams the surface of one side for its own points (`sampler`, if there is one) and past those
  /// of the other (`held`, if there are any).
  void pass(Side& side, const SurfaceSampler* sampler, Side* held) {
    const std::vector<SurfaceSummary::Piece>& pieces = side.summary().pieces;
    const double cost = sampler == nullptr ? kMatched
                        : held == nullptr  ? kSampled
                                           : kSampledAndMatched;
    std::uint64_t passed = 0;
    const auto near = [&](std::size_t i) {
      return held != nullptr && held->any_near(pieces[i].box);
    };
    const auto wanted = [&](std::size_t i) {
      if (i >= pieces.size()) throw GeometryError("the surface changed between two passes");
      return (sampler != nullptr && sampler->touches(i)) || near(i);
    };
    side.surface().stream(threads_, wanted,
                          [&](std::size_t i, const SurfacePiece& piece, unsigned number) -> Commit {
                            work_.check();
                            Lane& lane = lanes_[number];
                            SurfacePoints points;
                            if (sampler != nullptr) sampler->sample(i, piece, lane.areas, points);
                            if (!piece.triangle.empty() && near(i)) {
                              lane.tree.build(piece, scale_);
                              held->approach(lane.tree, lane.scratch);
                            }
                            return [&, i, points = std::move(points)] {
                              side.take(points);
                              const std::uint64_t before = pieces[i].triangles_before;
                              work_.advance(cost * static_cast<double>(before - passed));
                              passed = before;
                            };
                          });
    work_.advance(cost * static_cast<double>(side.summary().triangles - passed));
  }

 private:
  struct Lane {
    PieceTree tree;
    SampleTree::Scratch scratch;
    std::vector<double> areas;
  };

  const double scale_;
  const unsigned threads_;
  Work& work_;
  std::vector<Lane> lanes_;
};

/// A power of two that brings a box about both to a side of about 1.
double scale_for(const SurfaceSummary& a, const SurfaceSummary& b) {
  Box3 box = a.box;
  box.add(b.box.low);
  box.add(b.box.high);
  const Vec3 size = box.high - box.low;
  return std::ldexp(1.0, -std::max(std::ilogb(std::max({size.x, size.y, size.z})), -1000));
}

SurfaceSummary summary_of(const SurfacePieces& surface, const std::string& name, std::size_t scouts,
                          const SurfaceErrorOptions& options) {
  try {
    return summarise_surface(surface, scouts, options.threads, options.progress);
  } catch (const GeometryError& error) {
    throw GeometryError(name + ": " + error.what());
  }
}

}  // namespace

SurfaceError measure_surface_error(const SurfacePieces& original, const SurfacePieces& remesh,
                                   const SurfaceErrorOptions& options) {
  if (options.memory_bytes < kLeastMemory) {
    throw BudgetError("measuring takes at least 1 MiB of memory");
  }
  if (options.progress != nullptr) options.progress->begin("measure");
  const std::size_t scouts = scouts_within(options.memory_bytes);
  const auto summarise = [&](const SurfacePieces& surface, const std::string& name) {
    return Side(surface, summary_of(surface, name, scouts, options), options);
  };
  Side from_original = summarise(original, options.original_name);
  Side from_remesh = summarise(remesh, options.remesh_name);
  const bool original_larger = from_original.summary().triangles >= from_remesh.summary().triangles;
  Side& large = original_larger ? from_original : from_remesh;
  Side& small = original_larger ? from_remesh : from_original;

  const MemoryShares shares(options, large.summary(), small.summary());
  const std::uint64_t parts = (large.points() + small.points() + shares.points - 1) / shares.points;
  const double scale = scale_for(large.summary(), small.summary());
  const auto triangles = [](const Side& side) {
    return static_cast<double>(side.summary().triangles);
  };
  const double first = kSummarised * (triangles(large) + triangles(small));
  const double part_cost =
      kSampledAndMatched * triangles(large) + (kSampled + kMatched) * triangles(small);
  Work work(options.progress, first + part_cost * static_cast<double>(parts));
  work.advance(first);
  Passes passes(scale, shares.threads, work);
  for (std::uint64_t part = 0; part < parts; ++part) {
    const SurfaceSampler on_small = small.begin(part, parts);
    passes.pass(small, &on_small, nullptr);
    small.plant(large.summary(), scale);
    const SurfaceSampler on_large = large.begin(part, parts);
    passes.pass(large, &on_large, &small);
    small.harvest();
    large.plant(small.summary(), scale);
    passes.pass(small, nullptr, &large);
    large.harvest();
  }

  const DistanceSums &forward = from_original.sums(), &backward = from_remesh.sums();
  const double diagonal = from_original.summary().box.diagonal();
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

SurfaceError measure_surface_error(const TriangleSource& original, const TriangleSource& remesh,
                                   const SurfaceErrorOptions& options) {
  return measure_surface_error(StreamedPieces(original, options.memory_bytes),
                               StreamedPieces(remesh, options.memory_bytes), options);
}

}  // namespace remaps
