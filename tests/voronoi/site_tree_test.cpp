#include "common/voronoi/site_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/base/random.hpp"

namespace fracture::test {
namespace {

struct Family {
  const char* name;
  std::vector<Vec3d> points;
};

std::vector<Family> families() {
  Random random(1);
  std::vector<Family> all{{"none", {}},    {"one", {{1, 2, 3}}},
                          {"volume", {}},  {"line", {}},
                          {"lattice", {}}, {"one place", std::vector<Vec3d>(40, Vec3d{0.5, 0.5, 0.5})}};
  for (int k = 0; k < 1000; ++k) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    all[2].points.push_back({x, y, z});
    all[3].points.push_back({0.5, x, 0.5});
    all[4].points.push_back({k % 10 / 10.0, k / 10 % 10 / 10.0, k / 100 / 10.0});
  }
  return all;
}

Vec3d random_point(Random& random) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return {1.5 * x - 0.25, 1.5 * y - 0.25, 1.5 * z - 0.25};
}

TEST(SiteTree, VisitsExactlyThePointsOfTheBall) {
  Random random(2);
  for (const Family& family : families()) {
    SCOPED_TRACE(family.name);
    const SiteTree tree(family.points);
    for (int k = 0; k < 200; ++k) {
      const Vec3d q = random_point(random);
      const double radius = 0.5 * random.uniform(), radius2 = radius * radius;
      std::vector<std::uint32_t> expected, found;
      for (std::uint32_t n = 0; n < family.points.size(); ++n) {
        const Vec3d d = family.points[n] - q;
        if (dot(d, d) <= radius2) expected.push_back(n);
      }
      tree.visit_near(q, radius2, [&](std::uint32_t n, double distance2) {
        const Vec3d d = family.points[n] - q;
        EXPECT_EQ(distance2, dot(d, d));
        found.push_back(n);
        return radius2;
      });
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(SiteTree, AShrinkingBallFindsTheNearestAndLooksAtFew) {
  Random random(3);
  for (const Family& family : families()) {
    if (family.points.size() < 1000) continue;
    SCOPED_TRACE(family.name);
    const SiteTree tree(family.points);
    std::size_t looked_at = 0;
    for (int k = 0; k < 200; ++k) {
      const Vec3d q = random_point(random);
      double least = HUGE_VAL, nearest = HUGE_VAL;
      for (const Vec3d& p : family.points) least = std::min(least, dot(p - q, p - q));
      tree.visit_near(q, HUGE_VAL, [&](std::uint32_t, double distance2) {
        ++looked_at;
        nearest = distance2;
        return distance2;
      });
      EXPECT_EQ(nearest, least);
    }
    EXPECT_LT(looked_at, 200u * 100u) << "of 1000 points each";
  }
}

}  // namespace
}  // namespace fracture::test
