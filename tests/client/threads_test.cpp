// Several threads find the same contacts as one, in the same order.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "client/world/crew.hpp"
#include "tests/client/cubes.hpp"

namespace fracture::world {
namespace {

TEST(Crew, EverythingIsDoneOnceWhenItReturns) {
  Crew crew(2);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::atomic<int>> done(64);
    std::atomic<std::size_t> next = 0;
    crew.run([&] {
      for (std::size_t k = next++; k < done.size(); k = next++) ++done[k];
    });
    EXPECT_TRUE(std::all_of(done.begin(), done.end(), [](const auto& count) { return count == 1; })) << round;
  }
}

/// The fingerprints of a heap of loose cubes that fall onto each other, after each tenth of a second.
std::vector<std::uint64_t> heap_with(std::size_t threads) {
  WorldSettings settings;
  settings.threads = threads;
  settings.live_bodies = 1000;
  World world(settings);
  const FragmentSet set = test::cubes(8, 8);
  FragmentSet loose = set;
  loose.bonds.clear();
  for (int k = 0; k < 4; ++k) {
    ObjectSpec spec = test::whole_of(loose);
    spec.pose = {{0.3 * k, 1 + 9.5 * k, 0.2 * k}, glm::angleAxis(0.3 * k, glm::dvec3(0, 0.6, 0.8))};
    world.fracture(world.add_object(spec), prepare(loose));
  }
  std::vector<std::uint64_t> prints;
  for (int tenth = 0; tenth < 20; ++tenth) {
    test::run(world, 0.1);
    prints.push_back(world.fingerprint());
  }
  EXPECT_GT(world.census().groups, 200u);
  return prints;
}

TEST(Threads, AnyNumberOfThemGivesTheSameMotion) {
  const std::vector<std::uint64_t> one = heap_with(1);
  for (const std::size_t threads : {2u, 3u, 3u}) EXPECT_EQ(heap_with(threads), one) << threads;
}

}  // namespace
}  // namespace fracture::world
