// Which of several fragments in a cell a point belongs to.
#include "common/structure/islands.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/structure/in_contact.hpp"

namespace fracture::test {
namespace {

constexpr double kRounding = 1e-6;

// Two bars in a row along x, 2 m apart.
FragmentSet two_bars() {
  return fracture_solid(solid_in_contact({box({-4, 0, 0}, {-1, 1, 1}), box({1, 0, 0}, {4, 1, 1})}),
                        cut_by({{0, 0, 0}}))
      .set;
}

TEST(Islands, APointOnNoIslandBelongsToTheNearest) {
  const FragmentSet set = two_bars();
  ASSERT_EQ(set.fragments.size(), 2u);
  const std::vector<const Fragment*> fragments{&set.fragments[0], &set.fragments[1]};
  const bool left_first = set.fragments[0].mass.center_of_mass.x < 0;
  const std::uint32_t left = left_first ? 0 : 1, right = 1 - left;
  const Execution execution;
  Islands islands(fragments, kRounding, execution);
  const std::array<std::uint32_t, 2> both{0, 1};
  const auto pick = [&](const Vec3d& place) { return islands.pick(0, both, place, true); };
  EXPECT_EQ(pick({-0.5, 0.5, 0.5}), left) << "0.5 m from one, 1.5 m from the other";
  EXPECT_EQ(pick({0.25, 0.5, 0.5}), right);
  EXPECT_EQ(pick({-2, 1.5, 0.5}), left);
  EXPECT_EQ(pick({2, 0.5, -1.5}), right);
  EXPECT_EQ(pick({-4.5, 0.5, 2}), left);
  EXPECT_EQ(pick({3, 0.5, 0.5}), right) << "inside";
}

TEST(Islands, EquallyNearIslandsGiveTheFirst) {
  const FragmentSet set = two_bars();
  const std::vector<const Fragment*> fragments{&set.fragments[0], &set.fragments[1]};
  const Execution execution;
  Islands islands(fragments, kRounding, execution);
  const std::array<std::uint32_t, 2> both{0, 1}, turned{1, 0};
  EXPECT_EQ(islands.pick(0, both, {0, 0.5, 0.5}, true), 0u);
  EXPECT_EQ(islands.pick(1, turned, {0, 0.5, 0.5}, true), 1u);
}

}  // namespace
}  // namespace fracture::test
