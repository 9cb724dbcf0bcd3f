// Expects that the inner side of a wall is closed: each edge occurs once in each direction, and each place is
// one corner.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>
#include <utility>

#include "common/hollow/inner_surface.hpp"

namespace fracture::hollow_detail {

inline void expect_closed(const InnerSurface& s) {
  EXPECT_FALSE(s.triangles.empty());
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : s.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NE(t[k], t[(k + 1) % 3]);
      ++edges[{t[k], t[(k + 1) % 3]}];
    }
  for (const auto& [edge, n] : edges) {
    ASSERT_EQ(n, 1);
    ASSERT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
  std::set<std::array<float, 3>> places;
  for (const Vec3f& p : s.positions) places.insert({p.x, p.y, p.z});
  EXPECT_EQ(places.size(), s.positions.size()) << "corners at one place";
}

}  // namespace fracture::hollow_detail
