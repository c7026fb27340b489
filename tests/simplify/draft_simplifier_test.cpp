#include "remaps/simplify/draft_simplifier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "simplify/replay_log.h"

namespace remaps::simplify {
namespace {

using test::Shape;
using test::SimplifiedShape;
using test::simplify_options;

SimplifiedShape draft(const Shape& shape, const SimplifyOptions& options,
                      const std::vector<std::uint8_t>& locked = {}) {
  return test::simplify_shape(shape, options, locked, true);
}

TEST(DraftSimplifier, RemovesVerticesDownToTheTarget) {
  for (const Shape& shape : test::scan_shapes()) {
    for (const std::size_t target : {shape.position.size(), shape.position.size() / 10}) {
      SCOPED_TRACE(shape.name + " to " + std::to_string(target));
      const SimplifiedShape run = draft(shape, simplify_options(target));
      EXPECT_EQ(run.left, target);
      EXPECT_EQ(run.removed.size(), shape.position.size() - target);
      EXPECT_EQ(test::patch_defect(run.patch), "");
      const Topology topology = test::count_surface(test::alive_faces(run.patch)).topology;
      EXPECT_EQ(topology.euler_characteristic(), shape.euler_characteristic);
      EXPECT_EQ(topology.components, static_cast<std::uint64_t>(shape.components));
      EXPECT_EQ(topology.boundary_loops, static_cast<std::uint64_t>(shape.boundary_loops));
    }
  }
}

TEST(DraftSimplifier, WritesRecordsThatObeyTheRulesAndReplay) {
  for (const Shape& shape : test::scan_shapes()) {
    SCOPED_TRACE(shape.name);
    const SimplifyOptions options = simplify_options(0);
    const SimplifiedShape run = draft(shape, options);
    EXPECT_LT(run.left, shape.position.size() / 20) << "stopped early";
    replay(shape, run, options);
  }
  const Shape shape = test::bumpy(test::icosphere(4), 0.1, 0.01, 6);
  SimplifyOptions strict = simplify_options(100);
  strict.max_valence = 8;
  strict.fan_floor = strict.wedge_floor = 0.15;
  const SimplifiedShape run = draft(shape, strict);
  EXPECT_GT(run.log.size(), 1000u);
  replay(shape, run, strict);
}

TEST(DraftSimplifier, KeepsLoadsPositiveAndInTheirOrderOfSize) {
  for (const Shape& shape : test::scan_shapes()) {
    SCOPED_TRACE(shape.name);
    const SimplifiedShape before = draft(shape, simplify_options(shape.position.size()));
    const SimplifiedShape run = draft(shape, simplify_options(shape.position.size() / 10));
    double sum_before = 0;
    double sum = 0;
    for (const float load : before.segment.load) sum_before += load;
    for (LocalIndex f = 0; f < run.patch.face_slots(); ++f) {
      if (!run.patch.face_alive(f)) continue;
      ASSERT_GT(run.segment.load[f], 0);
      sum += run.segment.load[f];
    }
    EXPECT_GT(sum, 10 * sum_before);  // evenly spread loads grow as the square of the faces' share
    EXPECT_LT(sum, 10'000 * sum_before);
  }
}

TEST(DraftSimplifier, WritesTheSameLogFromBuffersUsedBefore) {
  DraftSimplifier used;
  for (const Shape& shape : test::scan_shapes()) {
    SimplifiedShape run = draft(shape, simplify_options(shape.position.size()));
    const SimplifyOptions options = simplify_options(shape.position.size() / 8);
    used.run(options, run.segment, run.patch, shape.position.size(), run.log, run.removed);
    const SimplifiedShape fresh = draft(shape, options);
    EXPECT_EQ(run.removed, fresh.removed) << shape.name;
    EXPECT_TRUE(std::equal(run.log.words().begin(), run.log.words().end(),
                           fresh.log.words().begin(), fresh.log.words().end()));
  }
}

TEST(DraftSimplifier, NeverRemovesALockedVertex) {
  const Shape shape = test::bumpy(test::torus(40, 20), 0.05, 0.004, 7);
  std::mt19937_64 random(1);
  std::vector<std::uint8_t> locked(shape.position.size());
  for (std::uint8_t& l : locked) l = random() % 3 == 0;
  const SimplifiedShape run = draft(shape, simplify_options(0), locked);
  for (const LocalIndex v : run.removed) EXPECT_FALSE(locked[v]);
  EXPECT_GT(run.removed.size(), shape.position.size() / 3);
  const SimplifiedShape none =
      draft(shape, simplify_options(0), std::vector<std::uint8_t>(shape.position.size(), 1));
  EXPECT_TRUE(none.removed.empty());
}

}  // namespace
}  // namespace remaps::simplify
