#include "common/bvh/box_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/base/random.hpp"

namespace fracture::test {
namespace {

/// Boxes of all sizes in a unit cube. Some occur twice.
std::vector<Box> random_boxes(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Box> boxes;
  for (std::size_t k = 0; k < count; ++k) {
    Vec3d low, size;
    for (int a = 0; a < 3; ++a) {
      low[a] = random.uniform();
      size[a] = 0.2 * random.uniform() * random.uniform();
    }
    boxes.push_back(k % 7 == 6 ? boxes[k / 2] : Box{low, low + size});
  }
  return boxes;
}

using Pairs = std::multiset<std::pair<std::uint32_t, std::uint32_t>>;

TEST(BoxTree, FindsWhatOverlapsABox) {
  for (const std::size_t count : {0u, 1u, 5u, 300u}) {
    const std::vector<Box> boxes = random_boxes(count, 1);
    const BoxTree tree(boxes);
    for (const Box& query : random_boxes(100, 2)) {
      std::multiset<std::uint32_t> found, expected;
      tree.each_overlapping(query, [&](std::uint32_t k) { found.insert(k); });
      for (std::uint32_t k = 0; k < boxes.size(); ++k)
        if (boxes[k].intersects(query)) expected.insert(k);
      EXPECT_EQ(found, expected);
    }
  }
}

/// Counts the boxes of the tree that overlap the query. The boxes of the items themselves do not count.
std::size_t entered(const BoxTree& tree, const Box& query) {
  std::size_t count = 0;
  tree.each_entered(
      [&](const Box& box) {
        const bool in = box.intersects(query);
        count += in;
        return in;
      },
      [] {}, [](std::uint32_t) {});
  return count;
}

TEST(BoxTree, WhatIsSmallBesideTheWholeIsDividedAllTheSame) {
  constexpr std::uint32_t kBoxes = 20'000;
  for (const double scale : {1.0, 1e-7, 1e-14, 1e-40, 1e-300}) {
    std::vector<Box> boxes;
    std::vector<std::uint32_t> groups{0};
    Random random(5);
    for (std::uint32_t k = 0; k < kBoxes; ++k) {
      const Vec3d at = scale * Vec3d{random.uniform(), random.uniform(), random.uniform()};
      boxes.push_back({at, at + 0.01 * scale * Vec3d{1, 1, 1}});
      groups.push_back(k + 1);
    }
    boxes.push_back({{1, 1, 1}, {1, 1, 1}});  // far away
    groups.push_back(kBoxes + 1);
    const BoxTree alone(boxes), of_one_group(boxes, {0, kBoxes + 1}), of_groups(boxes, groups);
    for (std::uint32_t k = 0; k < kBoxes; k += 1000)
      for (const BoxTree* tree : {&alone, &of_one_group, &of_groups})
        EXPECT_LT(entered(*tree, boxes[k]), 200u) << scale << ": all of it are " << kBoxes;
  }
}

TEST(BoxTree, GoesIntoTheBoxesThatAreWantedAndLeavesThem) {
  const std::vector<Box> boxes = random_boxes(300, 1);
  const BoxTree tree(boxes);
  for (const double limit : {-1.0, 0.3, 2.0}) {
    std::multiset<std::uint32_t> found, expected;
    int depth = 0, deepest = 0;
    tree.each_entered(
        [&](const Box& box) {
          if (box.min.x > limit) return false;
          deepest = std::max(deepest, ++depth);
          return true;
        },
        [&] { --depth; }, [&](std::uint32_t k) { found.insert(k); });
    for (std::uint32_t k = 0; k < boxes.size(); ++k)
      if (boxes[k].min.x <= limit) expected.insert(k);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(depth, 0);
    EXPECT_LT(deepest, 12);  // 300 boxes, halved until few are left
  }
}

TEST(BoxTree, FindsEveryPairOnceHoweverTheWorkIsDivided) {
  for (const std::size_t count : {0u, 1u, 4u, 5u, 400u}) {
    const std::vector<Box> boxes = random_boxes(count, 3);
    const BoxTree tree(boxes);
    Pairs expected;
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
      for (std::uint32_t j = i + 1; j < boxes.size(); ++j)
        if (boxes[i].intersects(boxes[j])) expected.insert({i, j});
    for (const std::size_t tasks : {1u, 16u, 100000u}) {
      Pairs found;
      for (const BoxTree::Task& task : tree.pair_tasks(tasks))
        tree.each_pair(task, [&](std::uint32_t i, std::uint32_t j) { found.insert({i, j}); });
      EXPECT_EQ(found, expected) << count << " boxes, " << tasks << " tasks";
    }
  }
}

TEST(BoxTree, InGroupsFindsEveryPairOfTwoGroupsOnce) {
  const std::vector<Box> boxes = random_boxes(400, 3);
  for (const std::vector<std::uint32_t>& begin :
       {std::vector<std::uint32_t>{0, 400}, {0, 1, 400}, {0, 0, 3, 7, 7, 100, 101, 250, 400, 400}}) {
    const BoxTree tree(boxes, begin);
    const auto group = [&](std::uint32_t k) {
      return std::upper_bound(begin.begin(), begin.end(), k) - begin.begin();
    };
    Pairs expected;
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
      for (std::uint32_t j = i + 1; j < boxes.size(); ++j)
        if (group(i) != group(j) && boxes[i].intersects(boxes[j])) expected.insert({i, j});
    for (const std::size_t tasks : {1u, 16u, 100000u}) {
      Pairs found;
      for (const BoxTree::Task& task : tree.pair_tasks(tasks))
        tree.each_pair(task, [&](std::uint32_t i, std::uint32_t j) { found.insert({i, j}); });
      EXPECT_EQ(found, expected) << begin.size() << " groups, " << tasks << " tasks";
    }
    std::set<std::uint32_t> all;
    tree.each_overlapping({{-1, -1, -1}, {2, 2, 2}}, [&](std::uint32_t k) { all.insert(k); });
    EXPECT_EQ(all.size(), boxes.size());
  }
}

TEST(BoxTree, FindsTheNearestAndLooksAtFew) {
  const std::vector<Box> boxes = random_boxes(1000, 4);
  const BoxTree tree(boxes);
  Random random(5);
  for (int n = 0; n < 100; ++n) {
    const Vec3d p{random.uniform(), random.uniform(), random.uniform()};
    for (const double most : {0.01, 5.0}) {
      double expected = most;
      for (const Box& box : boxes) expected = std::min(expected, std::sqrt(square_distance(box, p)));
      int looked = 0;
      EXPECT_EQ(tree.nearest(p, most, 1e-12,
                             [&](std::uint32_t k) {
                               ++looked;
                               return std::sqrt(square_distance(boxes[k], p));
                             }),
                expected);
      EXPECT_LT(looked, 100);
    }
  }
}

}  // namespace
}  // namespace fracture::test
