// Compares the filter of in_sphere with exact arithmetic. Every result that the filter calls certain must be
// right.
#include "common/delaunay/circumsphere.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/random.hpp"
#include "common/delaunay/big_tetrahedron.hpp"
#include "common/exact/in_sphere.hpp"
#include "common/exact/orient3d.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture {
namespace {

using delaunay_detail::Circumsphere;
using delaunay_detail::circumsphere;
using delaunay_detail::Edge;
using delaunay_detail::Two;

Vec3d anywhere(Random& random) {
  return {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
}

struct Family {
  std::string name;
  std::function<std::array<Vec3d, 4>(Random&)> corners;
  Vec3d at;              ///< position of its points
  double least_certain;  ///< smallest share of random points of the box that the filter must decide
  double scale = 1;
};

std::array<Vec3d, 4> random_corners(Random& random) {
  return {anywhere(random), anywhere(random), anywhere(random), anywhere(random)};
}

// Four points of a circle, lifted a little. The volume shrinks until the filter is certain of nothing.
std::array<Vec3d, 4> sliver(Random& random) {
  const double lift = std::ldexp(1.0, -static_cast<int>(random.below(50)));
  std::array<Vec3d, 4> p;
  for (int k = 0; k < 4; ++k) {
    const double angle = 1.6 * k + 0.3 * random.uniform();
    p[static_cast<std::size_t>(k)] = {0.4 * std::cos(angle), 0.4 * std::sin(angle), lift * random.uniform()};
  }
  return p;
}

// A small facet, and a corner at the distance of the big tetrahedron's corners.
std::array<Vec3d, 4> needle(Random& random) {
  const double size = std::ldexp(1.0, -static_cast<int>(random.below(40)));
  const Vec3d at = anywhere(random);
  return {at, at + size * anywhere(random), at + size * anywhere(random), anywhere(random)};
}

// Four points close together, somewhere in the box.
std::array<Vec3d, 4> cluster(Random& random) {
  const double size = std::ldexp(1.0, -static_cast<int>(random.below(40)));
  const Vec3d at = anywhere(random);
  return {at, at + size * anywhere(random), at + size * anywhere(random), at + size * anywhere(random)};
}

class CircumsphereFilter : public testing::TestWithParam<Family> {};

TEST_P(CircumsphereFilter, IsRightWhereItIsCertain) {
  const Family& family = GetParam();
  Random random(20261128);
  Box box;
  for (const double side : {-0.5, 0.5}) box.add(family.at + family.scale * Vec3d{side, side, side});
  const BigTetrahedron big = big_tetrahedron(box);
  const auto normalized = [&](const Vec3d& p) { return (1 / big.half) * (p - big.center); };
  std::size_t asked = 0, certain = 0;
  for (int round = 0; round < test::repetitions(3000); ++round) {
    std::array<Vec3d, 4> p = family.corners(random);
    for (Vec3d& v : p) v = family.at + family.scale * v;
    const int sign = exact::orient3d(p[0], p[1], p[2], p[3]);
    if (sign == 0) continue;
    if (sign < 0) std::swap(p[2], p[3]);
    const auto edge = [&](std::size_t k) {
      const Vec3d to = p[k] - p[0];
      return Edge<double>{{to.x, to.y, to.z}, dot(to, to)};
    };
    const Circumsphere<double> sphere =
        circumsphere<double>(normalized(p[0]), 1 / big.half, edge(1), edge(2), edge(3));
    const auto radius2 = static_cast<double>(static_cast<float>(sphere.radius2));
    const Vec3d center{sphere.center.x, sphere.center.y, sphere.center.z};
    const auto ask = [&](const Vec3d& q) {
      const Vec3d d = normalized(q) - center;
      const double beyond = dot(d, d) - radius2;
      if (!(std::fabs(beyond) > delaunay_detail::kMargin * radius2)) return false;
      EXPECT_EQ(beyond<0, exact::in_sphere_exact(p[0], p[1], p[2], p[3], q, {})> 0)
          << family.name << ", round " << round << ": " << q.x << ' ' << q.y << ' ' << q.z;
      return true;
    };
    for (int k = 0; k < 4; ++k) {
      ++asked;
      certain += ask(family.at + family.scale * anywhere(random));
    }
    // Points that approach the sphere, from far outside the margin to inside it.
    if (std::isnan(radius2)) continue;
    const Vec3d middle = big.center + big.half * center;
    for (int k = 4; k < 40; ++k) {
      const Vec3d way = anywhere(random);
      const double radius = big.half * std::sqrt(radius2) * (1 + std::ldexp(k % 2 == 0 ? 1.0 : -1.0, -k));
      ask(middle + (radius / length(way)) * way);
    }
  }
  EXPECT_GE(static_cast<double>(certain), family.least_certain * static_cast<double>(asked));
}

INSTANTIATE_TEST_SUITE_P(
    All, CircumsphereFilter,
    testing::Values(Family{"random", random_corners, {}, 0.999}, Family{"slivers", sliver, {}, 0.3},
                    Family{"needles", needle, {}, 0.3}, Family{"clusters", cluster, {}, 0.3},
                    Family{"far_from_the_origin", random_corners, {1e9, -3e10, 7e8}, 0.999, 100},
                    Family{"far_clusters", cluster, {1e9, -3e10, 7e8}, 0.1, 100},
                    Family{"small", random_corners, {}, 0.999, 1e-30},
                    Family{"too_small_for_doubles_to_the_sixth", random_corners, {}, 0, 1e-60},
                    Family{"large", random_corners, {}, 0.999, 1e12}),
    [](const auto& one) { return one.param.name; });

TEST(Circumsphere, TwoAtATimeAreTheSame) {
  Random random(7);
  for (int round = 0; round < test::repetitions(1000); ++round) {
    const std::array<Vec3d, 4> p = round % 2 == 0 ? random_corners(random) : sliver(random),
                               q = needle(random);
    const auto one = [](const Vec3d& to) { return Edge<double>{{to.x, to.y, to.z}, dot(to, to)}; };
    const auto both = [&](std::size_t k) {
      const Edge<double> a = one(p[k] - p[0]), b = one(q[k] - q[0]);
      return Edge<Two>{{Two{a.to.x, b.to.x}, Two{a.to.y, b.to.y}, Two{a.to.z, b.to.z}}, Two{a.lift, b.lift}};
    };
    const Vec3d corner = anywhere(random);
    const Circumsphere<Two> two = circumsphere<Two>(corner, 0.5, both(1), both(2), both(3));
    for (int lane = 0; lane < 2; ++lane) {
      const auto& from = lane == 0 ? p : q;
      const Circumsphere<double> single = circumsphere<double>(
          corner, 0.5, one(from[1] - from[0]), one(from[2] - from[0]), one(from[3] - from[0]));
      EXPECT_EQ(single.center.x, two.center.x[lane]);
      EXPECT_EQ(single.center.y, two.center.y[lane]);
      EXPECT_EQ(single.center.z, two.center.z[lane]);
      EXPECT_TRUE(single.radius2 == two.radius2[lane] ||
                  (std::isnan(single.radius2) && std::isnan(two.radius2[lane])));
    }
  }
}

}  // namespace
}  // namespace fracture
