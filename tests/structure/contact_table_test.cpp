#include "common/fragment/contact_table.hpp"

#include <gtest/gtest.h>

#include <map>

#include "common/base/random.hpp"

namespace fracture {
namespace {

using Areas = std::map<std::uint32_t, double>;

TEST(ContactTable, IsTheGraphWithItsNodesMerged) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const auto below = [&](double n) { return static_cast<std::uint32_t>(random.uniform() * n); };
    const std::uint32_t nodes = 2 + below(60), edges = below(300);
    Pacer pacer(kUninterrupted);
    ContactTable table(nodes, edges, pacer);
    std::vector<Areas> expected(nodes);
    for (std::uint32_t k = 0; k < edges; ++k) {
      const std::uint32_t a = below(nodes), b = below(nodes);
      if (a == b) continue;
      table.add(a, b, k);  // integers, whose sums do not depend on the order
      expected[a][b] += k;
      expected[b][a] += k;
    }
    std::vector<std::uint32_t> left(nodes);
    for (std::uint32_t n = 0; n < nodes; ++n) left[n] = n;
    for (;;) {
      for (const std::uint32_t n : left) {
        Areas found;
        table.visit(n, [&](std::uint32_t other, double area) {
          EXPECT_TRUE(found.emplace(other, area).second) << other << " stands there twice";
        });
        EXPECT_EQ(found, expected[n]) << "node " << n << ", seed " << seed;
        EXPECT_EQ(table.degree(n), expected[n].size());
      }
      if (left.size() < 2) break;
      const std::uint32_t at = below(static_cast<double>(left.size()));
      const std::uint32_t gone = left[at];
      left.erase(left.begin() + at);
      const std::uint32_t kept = left[below(static_cast<double>(left.size()))];
      table.merge(kept, gone);
      for (const auto& [other, area] : expected[gone]) {
        expected[other].erase(gone);
        if (other == kept) continue;
        expected[kept][other] += area;
        expected[other][kept] += area;
      }
      expected[gone].clear();
    }
  }
}

}  // namespace
}  // namespace fracture
