#include "remaps/pipeline/error_control.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "remaps/base/errors.h"
#include "remaps/pipeline/remesh.h"
#include "support/remesh_job.h"
#include "support/temp_files.h"

namespace remaps::pipeline {
namespace {

class ErrorControl : public test::TempFiles {
 protected:
  RemeshOptions options(double most, ErrorKind kind = ErrorKind::kL2) const {
    const auto input = directory() / "in.ply";
    test::write_lists(test::scan(BaseShape::kTorus, 8'000), input);
    RemeshOptions o = test::remesh_options(directory(), input);
    o.measure = true;
    o.samples = 20'000;
    o.goal.most = most;
    o.goal.kind = kind;
    return o;
  }
  static Report run(const RemeshOptions& o) {
    Progress progress;
    return remesh(o, progress);
  }
};

TEST_F(ErrorControl, ChoosesTheLowestLevelThatMeetsIt) {
  for (const ErrorKind kind : {ErrorKind::kL2, ErrorKind::kMax}) {
    const auto error_at = [&](unsigned level) {
      RemeshOptions o = options(0);
      o.level = level;
      const Report report = run(o);
      return kind == ErrorKind::kL2
                 ? report.error->l2()
                 : std::max(report.error->max_forward, report.error->max_backward);
    };
    const double at_2 = error_at(2), at_3 = error_at(3);
    ASSERT_LT(at_3, at_2);
    for (const auto& [most, level] : {std::pair{at_2, 2u}, {0.99 * at_2, 3u}, {at_3, 3u}}) {
      const Report report = run(options(most, kind));
      EXPECT_EQ(report.level, level);
      EXPECT_EQ(report.attempts.back().level, level);
      EXPECT_EQ(report.output_faces, report.base_faces << (2 * level));
      const test::MeshLists output = test::read_lists(directory() / "out.ply");
      EXPECT_EQ(output.triangle.size(), report.output_faces);
    }
  }
}

TEST_F(ErrorControl, TakesALargerBaseWhereNoLevelDoes) {
  RemeshOptions o = options(0);
  o.base_vertices = 60;
  o.level = 1;
  const double at_1 = run(o).error->l2();
  o.goal.most = 0.8 * at_1;
  o.goal.max_faces = 1500;  // level 2 of some 120 faces would be 1920
  const Report report = run(o);
  EXPECT_EQ(report.base_vertices, 240u);
  EXPECT_LE(report.error->l2(), o.goal.most);
  EXPECT_LE(report.output_faces, 1500u);
  EXPECT_GE(report.attempts.size(), 2u);
}

TEST_F(ErrorControl, RefusesWhatCannotBeMetAndLeavesNothing) {
  RemeshOptions o = options(1e-9);
  o.goal.max_faces = 3000;
  try {
    run(o);
    ADD_FAILURE() << "that cannot be met";
  } catch (const GeometryError& error) {
    EXPECT_NE(std::string(error.what()).find("at most 3000 faces"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(entries_in(directory()), 1u);
}

}  // namespace
}  // namespace remaps::pipeline
