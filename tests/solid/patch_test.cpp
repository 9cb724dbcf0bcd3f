#include "common/solid/patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>

#include "common/base/random.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture {
namespace {

/// Expects that each element of the patch is the element of the whole that it names.
void expect_part_of(const Solid& whole, const SolidPatch& patch) {
  const Solid& s = patch.solid;
  EXPECT_TRUE(std::is_sorted(patch.vertices.begin(), patch.vertices.end()));
  EXPECT_TRUE(std::is_sorted(patch.parts.begin(), patch.parts.end()));
  ASSERT_EQ(s.positions.size(), patch.vertices.size());
  ASSERT_EQ(s.parts.size(), patch.parts.size());
  ASSERT_EQ(s.triangles.size(), patch.triangles.size());
  for (std::size_t v = 0; v < s.positions.size(); ++v)
    EXPECT_EQ(s.positions[v], whole.positions[patch.vertices[v]]);
  for (std::uint32_t p = 0; p < s.parts.size(); ++p) {
    EXPECT_EQ(patch.local_part(patch.parts[p]), p);
    EXPECT_EQ(s.parts[p].volume, whole.parts[patch.parts[p]].volume);
    EXPECT_LT(s.parts[p].layer, s.layers);
    for (std::uint32_t q = 0; q < p; ++q)  // layers keep their order
      EXPECT_EQ(s.parts[q].layer < s.parts[p].layer,
                whole.parts[patch.parts[q]].layer < whole.parts[patch.parts[p]].layer);
  }
  for (std::size_t k = 0; k < s.triangles.size(); ++k) {
    const std::uint32_t t = patch.triangles[k];
    EXPECT_EQ(patch.parts[s.part[k]], whole.part[t]);
    EXPECT_EQ(s.wedges[k], whole.wedges[t]);
    EXPECT_EQ(s.material[k], whole.material[t]);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(patch.vertices[s.triangles[k][c]], whole.triangles[t][c]);
      const auto& ends = s.edge_vertices[s.edges[k][c]];
      EXPECT_LT(ends[0], ends[1]);
      EXPECT_EQ(patch.vertices[ends[0]], std::min(whole.triangles[t][c], whole.triangles[t][(c + 1) % 3]));
      EXPECT_EQ(patch.vertices[ends[1]], std::max(whole.triangles[t][c], whole.triangles[t][(c + 1) % 3]));
      for (std::size_t j = 0; j < k; ++j)  // one edge has one number
        for (std::size_t d = 0; d < 3; ++d)
          EXPECT_EQ(s.edges[k][c] == s.edges[j][d], whole.edges[t][c] == whole.edges[patch.triangles[j]][d]);
    }
  }
}

TEST(SolidPatch, OfSomeTriangles) {
  const Solid whole = test::solid_of(test::cube_field(2));
  ASSERT_GT(whole.parts.size(), 3u);
  Random random(5);
  for (int round = 0; round < 20; ++round) {
    std::vector<std::uint32_t> some;
    for (std::uint32_t t = 0; t < whole.triangles.size(); ++t)
      if (random() % 5 == 0) some.push_back(t);
    const std::vector<std::uint32_t> further{3, 0, 3};
    const SolidPatch patch = patch_of(whole, some, further, {});
    EXPECT_EQ(patch.triangles, some);
    EXPECT_TRUE(std::binary_search(patch.parts.begin(), patch.parts.end(), 3u));
    EXPECT_EQ(patch.solid.source, whole.source);
    expect_part_of(whole, patch);
  }
}

TEST(SolidPatch, OfAllAndOfNone) {
  const Solid whole = test::solid_of(test::torus(12, 6));
  std::vector<std::uint32_t> all(whole.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  const SolidPatch patch = patch_of(whole, all, {}, {});
  EXPECT_EQ(patch.solid.positions, whole.positions);
  EXPECT_EQ(patch.solid.triangles, whole.triangles);
  EXPECT_EQ(patch.solid.edges, whole.edges);
  EXPECT_EQ(patch.solid.edge_vertices, whole.edge_vertices);
  const SolidPatch none = patch_of(whole, {}, {}, {});
  EXPECT_TRUE(none.solid.triangles.empty() && none.parts.empty());
  EXPECT_EQ(none.solid.layers, 0u);
}

}  // namespace
}  // namespace fracture
