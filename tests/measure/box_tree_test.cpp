#include "remaps/measure/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <random>
#include <vector>

namespace remaps {
namespace {

std::vector<FloatBox> random_boxes(std::size_t n, float size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> coordinate(-1, 1), extent(0, size);
  std::vector<FloatBox> boxes;
  for (std::size_t i = 0; i < n; ++i) {
    const Float3 low{coordinate(random), coordinate(random), coordinate(random)};
    boxes.push_back(
        {low, {low.x + extent(random), low.y + extent(random), low.z + extent(random)}});
  }
  return boxes;
}

void build(BoxTree& tree, const std::vector<FloatBox>& boxes) {
  FloatBox around;
  for (const FloatBox& box : boxes) around.add(box);
  tree.build(static_cast<std::uint32_t>(boxes.size()), around,
             [&](std::uint32_t i) { return boxes[i]; });
}

/// The distance of the nearest of all items that a search meets whose visitor lowers the reach to
/// what it has seen.
float search_nearest(const BoxTree& tree, const std::vector<FloatBox>& boxes, const Float3& p) {
  float reach2 = std::numeric_limits<float>::max();
  tree.search(p, reach2, [&](std::uint32_t item) {
    reach2 = std::min(reach2, box_distance2(boxes[item], {p, p}));
  });
  return reach2;
}

void expect_nearest(const std::vector<FloatBox>& boxes, unsigned seed) {
  BoxTree tree;
  build(tree, random_boxes(300, 1, 99));  // what was there before leaves no trace
  build(tree, boxes);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> coordinate(-2, 2);
  for (int i = 0; i < 100; ++i) {
    const Float3 p{coordinate(random), coordinate(random), coordinate(random)};
    float least = std::numeric_limits<float>::infinity();
    for (const FloatBox& box : boxes) least = std::min(least, box_distance2(box, {p, p}));
    EXPECT_EQ(search_nearest(tree, boxes, p), least) << boxes.size();
  }
}

TEST(BoxTree, FindsTheNearestAtEverySize) {
  for (const std::size_t n :
       std::initializer_list<std::size_t>{1, 2, 15, 16, 17, 255, 256, 257, 4096, 4097, 10'000}) {
    expect_nearest(random_boxes(n, 0.05f, 1), 2);
  }
}

TEST(BoxTree, FindsTheNearestOfEqualAndFlatAndHugeBoxes) {
  expect_nearest(std::vector<FloatBox>(500, random_boxes(1, 1, 3)[0]), 4);
  expect_nearest(random_boxes(500, 0, 5), 6);
  std::vector<FloatBox> mixed = random_boxes(1'000, 0.01f, 7);
  mixed[500] = {{-50, -50, 3}, {50, 50, 3}};
  expect_nearest(mixed, 8);
  std::vector<FloatBox> dots(100);
  for (FloatBox& dot : dots) dot = {{1, 1, 1}, {1, 1, 1}};
  expect_nearest(dots, 9);
}

TEST(BoxTree, VisitsEachItemOnceWhereReachHasNoEnd) {
  const std::vector<FloatBox> boxes = random_boxes(3'000, 0.1f, 10);
  BoxTree tree;
  build(tree, boxes);
  std::vector<int> visits(boxes.size(), 0);
  float reach2 = std::numeric_limits<float>::max();
  tree.search({}, reach2, [&](std::uint32_t item) { ++visits[item]; });
  EXPECT_EQ(visits, std::vector<int>(boxes.size(), 1));
}

}  // namespace
}  // namespace remaps
