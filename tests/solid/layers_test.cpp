#include "common/solid/layers.hpp"

#include <gtest/gtest.h>

#include "common/base/random.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::solid_detail {
namespace {

std::vector<Part> parts_of(const std::vector<Box>& boxes) {
  std::vector<Part> parts(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) parts[i].box = boxes[i];
  return parts;
}

/// The definition, computed over all pairs.
std::vector<std::uint32_t> greedy_layers(const std::vector<Part>& parts) {
  std::vector<std::uint32_t> order(parts.size()), layer(parts.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return parts[a].box.min.x < parts[b].box.min.x; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    std::vector<bool> taken(parts.size());
    for (std::size_t j = 0; j < k; ++j)
      if (parts[order[j]].box.intersects(parts[order[k]].box)) taken[layer[order[j]]] = true;
    while (taken[layer[order[k]]]) ++layer[order[k]];
  }
  return layer;
}

Box box_at(double x, double y, double z, double a, double b, double c) {
  return {{x, y, z}, {x + a, y + b, z + c}};
}

/// Boxes of many shapes. On a small lattice many of them touch in faces, edges and corners.
std::vector<Box> random_boxes(std::uint64_t seed) {
  Random random(seed);
  const std::uint64_t count = 1 + random.below(120), lattice = 2 + random.below(12),
                      longest = 1 + random.below(12);
  const bool bars = random.below(3) == 0;
  std::vector<Box> boxes;
  for (std::uint64_t i = 0; i < count; ++i) {
    double v[6];
    for (int k = 0; k < 3; ++k) v[k] = static_cast<double>(random.below(lattice));
    for (int k = 3; k < 6; ++k) v[k] = static_cast<double>(random.below(longest));
    if (bars) v[3 + random.below(3)] = static_cast<double>(lattice);
    boxes.push_back(box_at(v[0], v[1], v[2], v[3], v[4], v[5]));
  }
  return boxes;
}

TEST(Layers, AreThoseOfTheGreedyColouringByAllPairs) {
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(test::repetitions(2000)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::vector<Part> parts = parts_of(random_boxes(seed));
    const std::vector<std::uint32_t> expected = greedy_layers(parts);
    const std::uint32_t layers = assign_layers(parts, {});
    std::uint32_t most = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      ASSERT_EQ(parts[i].layer, expected[i]) << "part " << i;
      most = std::max(most, expected[i] + 1);
    }
    ASSERT_EQ(layers, most);
  }
}

TEST(Layers, DoNotDependOnTheLayersThatThePartsHadBefore) {
  std::vector<Part> parts = parts_of(random_boxes(7)), again = parts;
  for (Part& part : again) part.layer = 1000;
  EXPECT_EQ(assign_layers(parts, {}), assign_layers(again, {}));
  for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(parts[i].layer, again[i].layer);
}

TEST(Layers, NoPartsHaveNone) {
  std::vector<Part> parts;
  EXPECT_EQ(assign_layers(parts, {}), 0u);
}

// -- work, in polls; a poll counts as a few thousand steps

/// side × side bricks in a wall across x. So all of them overlap in x and none touch.
std::vector<Box> wall(int side) {
  std::vector<Box> boxes;
  for (int y = 0; y < side; ++y)
    for (int z = 0; z < side; ++z) boxes.push_back(box_at(0, 1.1 * y + 0.5 * (z % 2), z, 1, 1, 0.9));
  return boxes;
}
/// Bars whose boxes all touch one another.
std::vector<Box> bars(int count) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) boxes.push_back(box_at(i, -i, i, 1e6, 1e6, 1e6));
  return boxes;
}
/// Nested boxes, and a small box next to them that is placed in between: the latest box of its layer touches
/// no other.
std::vector<Box> nested_and_small(int count) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    boxes.push_back({{-1e6 + i, -1e6 + i, -1e6 + i}, {1e6 - i, 1e6 - i, 1e6 - i}});
    boxes.push_back(box_at(-1e6 + i + 0.25, 2e6, 2e6, 0.5, 1, 1));
  }
  return boxes;
}

std::uint64_t polls_of(const std::vector<Box>& boxes, std::uint32_t expected_layers) {
  std::vector<Part> parts = parts_of(boxes);
  test::PollGaps gaps;
  EXPECT_EQ(assign_layers(parts, gaps.execution()), expected_layers);
  return gaps.polls();
}

TEST(Layers, FourTimesTheBricksOfAWallAreAboutFourTimesTheWork) {
  const std::uint64_t few = polls_of(wall(100), 1), many = polls_of(wall(200), 1);
  EXPECT_GT(few, 50u) << "work is polled";
  EXPECT_LT(many, 6 * few);
}

TEST(Layers, FourTimesTheBarsThatAllTouchAreAboutFourTimesTheWork) {
  const std::uint64_t few = polls_of(bars(10'000), 10'000), many = polls_of(bars(40'000), 40'000);
  EXPECT_GT(few, 20u) << "work is polled";
  EXPECT_LT(many, 6 * few);
}

TEST(Layers, ASmallBoxBetweenDoesNotMakeNestedOnesQuadratic) {
  const std::uint64_t few = polls_of(nested_and_small(10'000), 10'000),
                      many = polls_of(nested_and_small(40'000), 40'000);
  EXPECT_GT(few, 20u) << "work is polled";
  EXPECT_LT(many, 6 * few);
}

}  // namespace
}  // namespace fracture::solid_detail
