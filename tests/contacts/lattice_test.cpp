// Boxes on a coarse lattice. Most share planes, edges and corners, and their common area and volume are
// known.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/random.hpp"
#include "tests/contacts/part_meshes.hpp"

namespace fracture::test {
namespace {

struct Pair {
  std::array<int, 3> low_a, high_a, low_b, high_b;
};

Mesh mesh_of(const std::array<int, 3>& low, const std::array<int, 3>& high, int n) {
  return box({1.0 * low[0], 1.0 * low[1], 1.0 * low[2]}, {1.0 * high[0], 1.0 * high[1], 1.0 * high[2]}, n);
}

/// The area of box `a` that is strictly inside b.
double area_inside(const std::array<int, 3>& low_a, const std::array<int, 3>& high_a,
                   const std::array<int, 3>& low_b, const std::array<int, 3>& high_b) {
  double area = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
    const int wide = std::min(high_a[u], high_b[u]) - std::max(low_a[u], low_b[u]),
              high = std::min(high_a[v], high_b[v]) - std::max(low_a[v], low_b[v]);
    for (const int plane : {low_a[k], high_a[k]})
      if (plane > low_b[k] && plane < high_b[k]) area += 1.0 * std::max(0, wide) * std::max(0, high);
  }
  return area;
}

TEST(ContactLattice, BoxesHaveTheAreasAndVolumesOfTheirIntervals) {
  Random random(7);
  const auto interval = [&](int& low, int& high) {
    low = static_cast<int>(random.below(5));
    high = low + 1 + static_cast<int>(random.below(4));
  };
  std::size_t overlapping = 0, touching = 0, apart = 0;
  for (int round = 0; round < 3000; ++round) {
    SCOPED_TRACE(round);
    Pair p{};
    for (std::size_t k = 0; k < 3; ++k) {
      interval(p.low_a[k], p.high_a[k]);
      interval(p.low_b[k], p.high_b[k]);
    }
    if (p.low_a == p.low_b && p.high_a == p.high_b) continue;
    // Uses triangles of many sizes, so that edges meet faces, edges and corners.
    const Solid a = solid_of(mesh_of(p.low_a, p.high_a, 1 + round % 3)),
                b = solid_of(mesh_of(p.low_b, p.high_b, 1 + round % 4));
    const ContactGraph graph = contacts_of(both(a, b), 1.0 / 1024);
    double volume = 1, face = 1;
    int touched = 0;
    bool parted = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const int common = std::min(p.high_a[k], p.high_b[k]) - std::max(p.low_a[k], p.low_b[k]);
      parted |= common < 0;
      touched += common == 0;
      volume *= common;
      if (common != 0) face *= common;
    }
    if (parted) {
      ++apart;
      ASSERT_TRUE(graph.contacts.empty());
      continue;
    }
    ASSERT_EQ(graph.contacts.size(), 1u);
    const Contact& c = graph.contacts[0];
    if (touched > 0) {
      ++touching;
      ASSERT_EQ(c.kind, ContactKind::kTouching);
      ASSERT_NEAR(c.area, touched == 1 ? face : 0, 1e-5);  // thirds are rounded
      continue;
    }
    ++overlapping;
    ASSERT_EQ(c.kind, ContactKind::kOverlapping);
    ASSERT_NEAR(c.volume, volume, 1e-4);
    const double of_a = area_inside(p.low_a, p.high_a, p.low_b, p.high_b),
                 of_b = area_inside(p.low_b, p.high_b, p.low_a, p.high_a);
    const double least = std::min(of_a, of_b);
    ASSERT_NEAR(c.area, least > 0 ? least : std::max(of_a, of_b), 1e-4);
  }
  EXPECT_GT(overlapping, 500u);
  EXPECT_GT(touching, 500u);
  EXPECT_GT(apart, 200u);
}

}  // namespace
}  // namespace fracture::test
