#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "remaps/base/function_ref.h"
#include "remaps/base/geometry.h"

namespace remaps {

/// Three corners of a polygon, by their places in it.
using PolygonCorners = std::array<std::uint32_t, 3>;

/// Cuts polygons into triangles: n corners make n - 2.
///
/// In the plane of the polygon (seen along the coordinate axis nearest to its normal, which keeps
/// all signs) a fan from the first corner is taken if all its triangles are turned as the polygon
/// is; all convex polygons are cut so. Else ears are clipped: corners whose triangle is turned as
/// the polygon and holds no other corner, in the order round the polygon. Where there is none (the
/// polygon crosses itself, or is flat) the rest becomes a fan. The signs of triangles are exact
/// where the differences of coordinates are, as those of floats of like size.
///
/// Cost: n for a fan, up to n^2 else. Source: Meisters, Polygons have ears, 1975.
class PolygonTriangulation {
 public:
  /// @return  valid until the next call
  std::span<const PolygonCorners> cut(std::span<const Vec3> corner);

 private:
  struct Point {
    double x, y;
  };
  bool project(std::span<const Vec3> corner);
  int turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  bool fan_is_sound() const;
  bool is_ear(std::uint32_t b) const;
  void find_ears(std::uint32_t first);
  void clip_ears();

  std::vector<Point> point_;
  // The ring of corners that no ear was clipped at.
  std::vector<std::uint32_t> before_, after_;
  std::vector<std::uint8_t> is_ear_;
  std::vector<PolygonCorners> triangle_;
};

/// Is given the polygons of a reader that have more than three corners: it knows where their
/// corners are. See IndexedMeshReader::set_polygon_cutter.
class PolygonCutter {
 public:
  virtual ~PolygonCutter() = default;
  /// Sends the triangles of a polygon. If a corner is not finite they are a fan from it, so that
  /// all of them go when it is dropped.
  void cut(std::span<const VertexId> corners, FunctionRef<void(const Triangle&)> sink);

 protected:
  virtual Vec3 position(VertexId v) = 0;

 private:
  std::vector<Vec3> position_;
  PolygonTriangulation triangulation_;
};

}  // namespace remaps
