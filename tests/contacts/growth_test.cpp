// The longest time between polls during the search for contacts.
#include <gtest/gtest.h>

#include "tests/contacts/part_meshes.hpp"
#include "tests/support/poll_gaps.hpp"

namespace fracture::test {
namespace {

TEST(ContactGrowth, PollsInTime) {
  std::vector<Mesh> cubes;
  for (int k = 0; k < 1000; ++k)
    cubes.push_back(translated(cube(), {1.0 * (k % 10), 1.0 * (k / 10 % 10), 1.0 * (k / 100)}));
  const Solid grid = solid_of(joined(cubes));
  const Solid spheres =
      solid_of(joined({sphere_with(60'000), translated(sphere_with(60'000), {1, 0.125, 0})}));
  const Solid crowd = solid_of(joined({box({-2, -2, -2}, {2, 2, 2}, 60), sphere_with(60'000)}));
  for (const Solid* solid : {&grid, &spheres, &crowd}) {
    const Polled gaps = polled([&](const Execution& execution) { find_contacts(*solid, 1e-3, execution); });
    EXPECT_LT(gaps.longest_ms, kMostPollGapMs);
    EXPECT_GT(gaps.polls, 20u);
  }
}

}  // namespace
}  // namespace fracture::test
