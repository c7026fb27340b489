#include "remaps/simplify/simplifier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "remaps/simplify/sampling_load.h"
#include "simplify/replay_log.h"
#include "support/cut_shape.h"
#include "support/shapes.h"
#include "support/simplified_shape.h"
#include "support/surface_check.h"

namespace remaps::simplify {
namespace {

using test::scan_shapes;
using test::Shape;
using test::SimplifiedShape;
using test::simplify_options;
using test::simplify_shape;

TEST(Simplifier, RemovesVerticesDownToTheTarget) {
  for (const Shape& shape : scan_shapes()) {
    for (const std::size_t target :
         {shape.position.size(), shape.position.size() / 2, std::size_t{40}}) {
      SCOPED_TRACE(shape.name + " to " + std::to_string(target));
      const SimplifiedShape run = simplify_shape(shape, simplify_options(target));
      EXPECT_EQ(run.left, target);
      EXPECT_EQ(run.removed.size(), shape.position.size() - target);
      EXPECT_EQ(run.log.size(), run.removed.size());
      std::size_t alive = 0;
      for (LocalIndex v = 0; v < run.patch.vertex_slots(); ++v) alive += run.patch.vertex_alive(v);
      EXPECT_EQ(alive, target);
      EXPECT_EQ(test::patch_defect(run.patch), "");
      const Topology topology = test::count_surface(test::alive_faces(run.patch)).topology;
      EXPECT_EQ(topology.euler_characteristic(), shape.euler_characteristic);
      EXPECT_EQ(topology.components, static_cast<std::uint64_t>(shape.components));
      EXPECT_EQ(topology.boundary_loops, static_cast<std::uint64_t>(shape.boundary_loops));
    }
  }
}

TEST(Simplifier, WritesRecordsThatObeyTheRulesAndReplay) {
  for (const Shape& shape : scan_shapes()) {
    SCOPED_TRACE(shape.name);
    SimplifyOptions options = simplify_options(0);
    const SimplifiedShape run = simplify_shape(shape, options);
    EXPECT_LT(run.left, 40u) << "stopped early";
    replay(shape, run, options);
  }
}

TEST(Simplifier, ObeysStricterRules) {
  const Shape shape = test::bumpy(test::icosphere(4), 0.1, 0.01, 6);
  SimplifyOptions options = simplify_options(100);
  options.max_valence = 8;
  options.fan_floor = options.wedge_floor = 0.15;
  options.thorough_below = 1000;
  const SimplifiedShape run = simplify_shape(shape, options);
  EXPECT_GT(run.log.size(), 1000u);
  replay(shape, run, options);
}

TEST(Simplifier, WritesTheSameLogTwice) {
  for (const Shape& shape : scan_shapes()) {
    const SimplifiedShape a = simplify_shape(shape, simplify_options(30));
    const SimplifiedShape b = simplify_shape(shape, simplify_options(30));
    EXPECT_TRUE(std::equal(a.log.words().begin(), a.log.words().end(), b.log.words().begin(),
                           b.log.words().end()))
        << shape.name;
    EXPECT_EQ(a.removed, b.removed);
  }
}

TEST(Simplifier, GivesTheSameFromBuffersUsedBefore) {
  const std::vector<Shape> shapes = scan_shapes();
  Simplifier used;
  for (const Shape& shape : shapes) {
    SimplifiedShape run;
    run.segment = test::whole_segment(shape);
    run.patch.build(shape.position.size(), run.segment.own_vertices, shape.triangle);
    const SimplifyOptions options = simplify_options(50);
    initialize_loads(run.patch, test::diagonal_of(shape), run.segment);
    used.run(options, run.segment, run.patch, shape.position.size(), run.log, run.removed);
    EXPECT_EQ(run.removed, simplify_shape(shape, options).removed) << shape.name;
  }
}

TEST(Simplifier, NeverRemovesALockedVertex) {
  const Shape shape = test::bumpy(test::torus(40, 20), 0.05, 0.004, 7);
  for (const std::uint64_t seed : {1u, 2u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::vector<std::uint8_t> locked(shape.position.size());
    for (std::uint8_t& l : locked) l = random() % 3 == 0;
    const SimplifiedShape run = simplify_shape(shape, simplify_options(0), locked);
    for (const LocalIndex v : run.removed) EXPECT_FALSE(locked[v]);
    EXPECT_GT(run.removed.size(), shape.position.size() / 2);
    EXPECT_EQ(run.left, shape.position.size() - run.removed.size());
  }
  const SimplifiedShape none = simplify_shape(shape, simplify_options(0),
                                              std::vector<std::uint8_t>(shape.position.size(), 1));
  EXPECT_TRUE(none.removed.empty());
}

TEST(Simplifier, LeavesMoreOfWhatIsCurved) {
  // A bump in the middle of a flat sheet must keep a larger share of the vertices than the plain.
  Shape shape = test::disk(40);
  for (Vec3& p : shape.position) {
    const double r = std::hypot(p.x, p.y);
    if (r < 0.3) p.z = 0.3 * std::pow(std::cos(r / 0.3 * 1.5707963), 2);
  }
  const SimplifiedShape run = simplify_shape(shape, simplify_options(200));
  std::size_t inside = 0;
  std::size_t inside_before = 0;
  for (LocalIndex v = 0; v < shape.position.size(); ++v) {
    const bool in = std::hypot(shape.position[v].x, shape.position[v].y) < 0.3;
    inside_before += in;
    inside += in && run.patch.vertex_alive(v);
  }
  EXPECT_GT(double(inside) / 200, 2 * double(inside_before) / double(shape.position.size()));
}

TEST(Simplifier, StopsAtTheLeastThatTheTopologyAllows) {
  for (const Shape& shape : {test::tetrahedron(), test::annulus(3, 1)}) {
    const SimplifiedShape run = simplify_shape(shape, simplify_options(0));
    EXPECT_EQ(run.left, shape.position.size()) << shape.name;
  }
}

}  // namespace
}  // namespace remaps::simplify
