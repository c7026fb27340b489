#include "remaps/repair/orientation_join.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/temp_files.h"

namespace remaps::repair {
namespace {

class OrientationJoinTest : public test::TempFiles {
 protected:
  OrientationJoin make() { return {directory() / "shared", 1000, 1 << 16, budget_}; }

  MemoryBudget budget_{std::uint64_t{16} << 20};
};

TEST_F(OrientationJoinTest, TurnsTheFewestFacesOfAComponent) {
  OrientationJoin join = make();
  // Parts 0 and 1 share a face that they see the other way round: 10 + 1 faces against 2 + 6.
  EXPECT_EQ(
      join.add(std::vector<OrientedPart>{{10, 2}, {3, 4}}, std::vector<SharedFace>{{7, 0, false}}),
      0u);
  EXPECT_EQ(join.add(std::vector<OrientedPart>{{6, 1}}, std::vector<SharedFace>{{7, 0, true}}), 2u);
  EXPECT_FALSE(join.finish());
  EXPECT_EQ(join.component_faces(0), 19u);
  EXPECT_EQ(join.component_faces(2), 19u);
  EXPECT_FALSE(join.turns(0)) << "11 run like its first face, 8 do not";
  EXPECT_TRUE(join.turns(2));
  EXPECT_EQ(join.component_faces(1), 7u);
  EXPECT_TRUE(join.turns(1)) << "3 run like its first face, 4 do not";
  EXPECT_EQ(join.components_below(7), 0u);
  EXPECT_EQ(join.components_below(8), 1u);
  EXPECT_EQ(join.components_below(20), 2u);
}

TEST_F(OrientationJoinTest, FindsWhatCannotBeOriented) {
  OrientationJoin join = make();
  join.add(std::vector<OrientedPart>{{5, 0}},
           std::vector<SharedFace>{{1, 0, false}, {2, 0, false}});
  join.add(std::vector<OrientedPart>{{5, 0}}, std::vector<SharedFace>{{1, 0, false}, {2, 0, true}});
  const std::optional<FaceId> face = join.finish();
  ASSERT_TRUE(face);
  EXPECT_TRUE(*face == 1 || *face == 2);
}

TEST_F(OrientationJoinTest, RefusesMorePartsThanItsBudgetHolds) {
  MemoryBudget small(1 << 20);
  OrientationJoin join(directory() / "small", 1000, 1 << 12, small);
  const std::vector<OrientedPart> many(200'000);
  EXPECT_THROW(join.add(many, {}), BudgetError);
}

}  // namespace
}  // namespace remaps::repair
