#include "common/structure/anchors.hpp"

#include <gtest/gtest.h>

#include "tests/support/figures.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

/// A tower of five cubes along y. Fragment k reaches from y = k to y = k + 1.
FragmentSet tower() {
  FractureParameters p;
  PointsPattern pattern;
  for (int k = 0; k < 5; ++k) pattern.points.push_back({0.5, k + 0.5, 0.5});
  p.pattern = pattern;
  return fracture_mesh(box({0, 0, 0}, {1, 5, 1}), p).set;
}

std::vector<bool> held(const FragmentSet& set, const Anchors& anchors) {
  const AnchoredFragments anchored = find_anchored(set, anchors, 5);
  std::vector<bool> result;
  for (std::size_t k = 0; k < set.fragments.size(); ++k) result.push_back(anchored.contains(k));
  EXPECT_EQ(anchored.held.size(), set.fragments.size());
  EXPECT_EQ(anchored.count, std::count(result.begin(), result.end(), true));
  return result;
}

TEST(Anchors, PlaneHoldsWhatReachesIntoItsHalfSpace) {
  const FragmentSet set = tower();
  ASSERT_EQ(set.fragments.size(), 5u);
  const auto on_ground = std::vector<bool>{true, false, false, false, false};
  EXPECT_EQ(held(set, {{{{0, 1, 0}, 0}}, {}, {}}), on_ground);
  EXPECT_EQ(held(set, {{{{0, 7, 0}, 0.5}}, {}, {}}), on_ground);  // the length of the normal does not matter
  EXPECT_EQ(held(set, {{{{0, 1, 0}, 1.5}}, {}, {}}), (std::vector<bool>{true, true, false, false, false}));
  EXPECT_EQ(held(set, {{{{0, -1, 0}, -5}}, {}, {}}), (std::vector<bool>{false, false, false, false, true}));
  EXPECT_EQ(held(set, {{{{0, 1, 0}, -0.1}}, {}, {}}), std::vector<bool>(5, false));
}

TEST(Anchors, BoxHoldsWhatItOverlapsEvenWithoutAVertexInside) {
  const FragmentSet set = tower();
  EXPECT_EQ(held(set, {{}, {Box{{0.4, 1.4, 0.9}, {0.6, 1.6, 1.1}}}, {}}),
            (std::vector<bool>{false, true, false, false, false}));  // through the middle of a face
  EXPECT_EQ(held(set, {{}, {Box{{0.4, 2.4, 0.4}, {0.6, 2.6, 0.6}}}, {}}),
            (std::vector<bool>{false, false, true, false, false}));  // completely inside
  EXPECT_EQ(held(set, {{}, {Box{{0.4, 0.5, 0.4}, {0.6, 3.5, 0.6}}}, {}}),
            (std::vector<bool>{true, true, true, true, false}));
  EXPECT_EQ(held(set, {{}, {Box{{1.1, 0, 0}, {2, 5, 1}}}, {}}), std::vector<bool>(5, false));
}

TEST(Anchors, PointHoldsWhatItLiesInOrOn) {
  const FragmentSet set = tower();
  EXPECT_EQ(held(set, {{}, {}, {{0.5, 3.5, 0.5}}}), (std::vector<bool>{false, false, false, true, false}));
  EXPECT_EQ(held(set, {{}, {}, {{1, 0.5, 0.3}}}), (std::vector<bool>{true, false, false, false, false}));
  EXPECT_EQ(held(set, {{}, {}, {{0.5, 1, 0.5}}}), (std::vector<bool>{true, true, false, false, false}));
  EXPECT_EQ(held(set, {{}, {}, {{1.5, 0.5, 0.5}}}), std::vector<bool>(5, false));
}

TEST(Anchors, AreMarkedByThePipelineAndCounted) {
  FractureParameters p;
  p.pattern = PointsPattern{row_of_sites(Box{{0, 0, 0}, {4, 1, 1}}, 4)};
  p.anchors.planes.push_back({{-1, 0, 0}, -4});
  const Fractured made = fracture_mesh(box({0, 0, 0}, {4, 1, 1}), p);
  ASSERT_EQ(made.set.fragments.size(), 4u);
  EXPECT_TRUE(made.anchored.contains(3));
  EXPECT_FALSE(made.anchored.contains(0));
  EXPECT_EQ(made.anchored.count, 1u);
  EXPECT_EQ(made.report.anchored, 1u);
  EXPECT_TRUE(made.report.remarks.empty());
}

TEST(Anchors, ThatHoldNothingAreAWarningThatSaysWhatToDo) {
  FractureParameters p;
  p.sites = 4;
  p.anchors.planes.push_back({{-1, 0, 0}, -40});
  const Fractured made = fracture_mesh(box({0, 0, 0}, {4, 1, 1}), p);
  EXPECT_EQ(made.report.anchored, 0u);
  EXPECT_TRUE(warns(made.report, "No fragment touches an anchor, so nothing is held. Move the anchors"));
  EXPECT_TRUE(made.report.remarks.notes.empty());
}

}  // namespace
}  // namespace fracture::test
