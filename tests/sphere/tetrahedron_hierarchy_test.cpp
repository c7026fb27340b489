#include "remaps/sphere/tetrahedron_hierarchy.h"

#include <gtest/gtest.h>

#include <set>

#include "remaps/base/errors.h"
#include "sphere/sphere_shapes.h"

namespace remaps::sphere {
namespace {

LocalTriangle from_least(LocalTriangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

/// The surface that the insertions make of the tetrahedron.
std::vector<LocalTriangle> undo(const TetrahedronHierarchy& h) {
  const auto& c = h.corner;
  std::set<LocalTriangle> faces;
  for (const LocalTriangle& t :
       {LocalTriangle{c[0], c[1], c[2]}, LocalTriangle{c[0], c[3], c[1]},
        LocalTriangle{c[1], c[3], c[2]}, LocalTriangle{c[2], c[3], c[0]}}) {
    faces.insert(from_least(t));
  }
  for (std::size_t i = 0; i < h.vertex.size(); ++i) {
    const std::span<const LocalIndex> ring = h.ring_of(i);
    for (std::size_t k = 1; k + 1 < ring.size(); ++k) {
      EXPECT_EQ(faces.erase(from_least({ring[0], ring[k], ring[k + 1]})), 1u) << "insertion " << i;
    }
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const LocalTriangle t{h.vertex[i], ring[k], ring[(k + 1) % ring.size()]};
      EXPECT_TRUE(faces.insert(from_least(t)).second) << "insertion " << i;
    }
  }
  return {faces.begin(), faces.end()};
}

TEST(TetrahedronHierarchy, UndoneItIsTheSurface) {
  const Progress progress;
  for (const test::Shape& shape : test::spherical_shapes()) {
    SCOPED_TRACE(shape.name);
    const TetrahedronHierarchy h =
        simplify_to_tetrahedron(shape.position, shape.triangle, progress);
    EXPECT_EQ(h.vertex.size(), shape.position.size() - 4);
    EXPECT_EQ(h.start.size(), h.vertex.size() + 1);
    EXPECT_EQ(undo(h), test::normalized(shape.triangle));
  }
}

TEST(TetrahedronHierarchy, RefusesWhatIsNoSphere) {
  const Progress progress;
  test::Shape unused = test::octahedron();
  unused.position.push_back({});
  const test::Shape two = test::together(test::octahedron(), test::torus(5, 5));
  for (const test::Shape& shape : {test::torus(5, 5), test::disk(3), unused, two}) {
    EXPECT_THROW(simplify_to_tetrahedron(shape.position, shape.triangle, progress), GeometryError)
        << shape.name;
  }
}

}  // namespace
}  // namespace remaps::sphere
