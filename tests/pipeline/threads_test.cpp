// Tests for TSan: several threads inside a single fracture, and several fractures that share a solid and a
// diagram at the same time.
#include <gtest/gtest.h>

#include <optional>
#include <thread>
#include <vector>

#include "common/pipeline/fracture.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

TEST(FractureThreads, ConcurrentRequestsOnOneSharedSolidAndDiagramGiveTheSameFragments) {
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(torus(32, 16)), {}, {});
  FractureParameters parameters;
  parameters.sites = 80;
  parameters.hulls = Hulls::kConvex;
  StageTimings timings;
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, {}, timings);

  constexpr int kRequests = 4;
  std::vector<std::optional<FracturedSolid>> answers(kRequests);
  std::vector<std::thread> threads;
  for (int k = 0; k < kRequests; ++k)
    threads.emplace_back([&, k] {
      Execution execution;
      execution.threads = 1 + k;  // 1, 2, 3, 4
      StageTimings own;
      if (auto made = fracture(*solid, *diagram, parameters, execution, own))
        answers[static_cast<std::size_t>(k)] = std::move(*made);
    });
  for (std::thread& t : threads) t.join();

  for (const auto& answer : answers) {
    ASSERT_TRUE(answer.has_value());
    ASSERT_EQ(answer->set.fragments.size(), answers[0]->set.fragments.size());
    for (std::size_t f = 0; f < answer->set.fragments.size(); ++f) {
      EXPECT_EQ(answer->set.fragments[f].positions, answers[0]->set.fragments[f].positions);
      EXPECT_EQ(answer->set.fragments[f].indices, answers[0]->set.fragments[f].indices);
      EXPECT_EQ(answer->hulls.of(f)[0].points, answers[0]->hulls.of(f)[0].points);
    }
  }
}

TEST(FractureThreads, BarycentricCellsOnSeveralThreads) {
  const Expected<Solid> solid = make_solid(std::make_shared<Mesh>(torus(16, 8)), {}, {});
  FractureParameters parameters;
  parameters.sites = 20;
  parameters.dual = Dual::kBarycenter;
  StageTimings timings;
  const Expected<Diagram> diagram = make_diagram(*solid, parameters, {}, timings);
  Execution two;
  two.threads = 2;
  const auto a = fracture(*solid, *diagram, parameters, {}, timings),
             b = fracture(*solid, *diagram, parameters, two, timings);
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->set.fragments.size(), b->set.fragments.size());
  for (std::size_t f = 0; f < a->set.fragments.size(); ++f)
    EXPECT_EQ(a->set.fragments[f].positions, b->set.fragments[f].positions);
}

}  // namespace
}  // namespace fracture::test
