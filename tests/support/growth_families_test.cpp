// Proves that the families are as described: closed if they should be, as large as requested, the same for
// the same seed.
#include "tests/support/growth_families.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/figures.hpp"

namespace fracture::test {
namespace {

/// Edges that are not used equally often in both directions.
std::size_t unbalanced_edges(const Mesh& mesh) {
  std::map<std::array<std::uint32_t, 2>, int> balance;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  std::size_t n = 0;
  for (const auto& [edge, sum] : balance) n += sum != 0;
  return n;
}

class EveryGrowthFamily : public testing::TestWithParam<std::size_t> {
 protected:
  const GrowthFamily& family() const { return growth_families()[GetParam()]; }
};

TEST_P(EveryGrowthFamily, IsClosedAndOutwardExceptTheOneWithHoles) {
  for (const std::uint32_t size : {6u, 54u}) {
    const GrowthInput input = family().make(size, 3);
    ASSERT_EQ(input.mesh.material.size(), input.mesh.triangles.size());
    ASSERT_EQ(input.mesh.node.size(), input.mesh.triangles.size());
    EXPECT_NE(input.sites.empty(), input.uniform == 0) << "sites that are given, or a number of them";
    if (std::string(family().name) == "holes") {
      EXPECT_GT(unbalanced_edges(input.mesh), 0u);
      continue;
    }
    EXPECT_EQ(unbalanced_edges(input.mesh), 0u) << size;
    // A shape that crosses itself may turn inside out, and one family contains an inverted cube.
    const std::string name = family().name;
    if (name == "scribble" || name == "lissajous" || name == "thin_boxes") continue;
    EXPECT_GT(volume_of(input.mesh), 0) << size;
  }
}

TEST_P(EveryGrowthFamily, GrowsInProportion) {
  const auto weight = [&](std::uint32_t size) {
    const GrowthInput input = family().make(size, 3);
    return static_cast<double>(input.mesh.triangles.size() + input.sites.size() + input.uniform);
  };
  // A fixed part is allowed, so the weight may grow less than the size. It may grow at most 8.8 times for
  // eight times the size.
  const double small = weight(240), large = weight(8 * 240);
  EXPECT_LE(large, 8.8 * small);
  EXPECT_GE(large, 1.5 * small);
}

TEST_P(EveryGrowthFamily, IsAFunctionOfSizeAndSeed) {
  const GrowthInput one = family().make(40, 5), two = family().make(40, 5);
  EXPECT_EQ(one.mesh.positions, two.mesh.positions);
  EXPECT_EQ(one.mesh.triangles, two.mesh.triangles);
  EXPECT_EQ(one.sites, two.sites);
}

INSTANTIATE_TEST_SUITE_P(Growth, EveryGrowthFamily, testing::Range<std::size_t>(0, growth_families().size()),
                         [](const auto& family) { return growth_families()[family.param].name; });

}  // namespace
}  // namespace fracture::test
