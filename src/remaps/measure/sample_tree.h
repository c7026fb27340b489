#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/geometry.h"
#include "remaps/measure/box_tree.h"
#include "remaps/measure/piece_tree.h"
#include "remaps/measure/surface_sampler.h"

namespace remaps {

/// Points of one surface, kept while the triangles of another pass by, and for each of them the
/// distance to the nearest of these triangles so far.
///
/// The points are sorted along a space-filling curve; 16 neighbours are a leaf, 16 neighbouring
/// nodes a node of the next level. A node knows its box and the largest distance of its points. A
/// piece of the other surface descends with its own tree as far as it is nearer than that
/// (`approach`).
class SampleTree {
 public:
  SampleTree() = default;
  enum class Repeats { keep, drop };

  /// @param points   any order; their words are places on a curve
  /// @param repeats  what becomes of points in the same place
  SampleTree(std::vector<SurfacePoint> points, Repeats repeats);

  /// Sets first distances, a little longer than those to points that lie on the other surface.
  ///
  /// @param scouts  one or more
  /// @param scale   of FloatFrame
  void bound_by(std::span<const Vec3> scouts, double scale);

  /// Whether something in the box could be nearer to a point than what it has.
  bool any_near(const Box3& box);

  /// What one thread needs for approach; empty at first.
  struct Scratch {
    struct Found {
      FloatBox box;
      BoxTree::Entry entry;
    };
    std::vector<Found> found;
    // What a leaf has found.
    std::vector<BoxTree::Group> groups;
    std::vector<BoxTree::Entry> entries;
  };

  /// Lowers the distances of the points to what a piece has nearer.
  ///
  /// Threads: any number, on several pieces. In the end each distance is the least of the squared
  /// distances in double to all triangles, whatever the order, since boxes prune only what is
  /// further away.
  void approach(const PieceTree& piece, Scratch& scratch);

  std::span<const SurfacePoint> points() const { return points_; }

  /// What a tree takes for a point.
  static constexpr std::uint64_t kBytesPerPoint = sizeof(SurfacePoint) + 4;

 private:
  static constexpr std::size_t kWidth = 16;

  struct Node {
    Vec3 low, high;
    std::uint64_t bound;  // bits of a squared distance, of no point exceeded
  };

  class Search;

  std::vector<SurfacePoint> points_;
  std::vector<std::vector<Node>> levels_;  // leaves first, the last of one node
};

}  // namespace remaps
