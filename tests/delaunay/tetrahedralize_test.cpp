#include "common/delaunay/tetrahedralization.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <stop_token>

#include "common/exact/in_sphere.hpp"
#include "common/exact/orient3d.hpp"
#include "tests/delaunay/point_families.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture {
namespace {

using test::point_families;
using test::PointFamily;

// A set of tetrahedra that does not depend on numbering: sorted tuples of coordinates.
using Key = std::array<std::array<double, 3>, 4>;
std::vector<Key> tet_set(const Tetrahedralization& t) {
  std::vector<Key> keys;
  for (const Tetrahedron& tet : t.tets) {
    Key key;
    for (int k = 0; k < 4; ++k) key[k] = {t.points[tet.v[k]].x, t.points[tet.v[k]].y, t.points[tet.v[k]].z};
    std::sort(key.begin(), key.end());
    keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

Box box_of(const std::vector<Vec3d>& points) {
  Box box;
  for (const Vec3d& p : points) box.add(p);
  return box;
}

// Checks the contract of the result from outside: symmetric adjacency, positive tetrahedra, the volume of the
// big tetrahedron, and no site in any sphere (by brute force).
void check(const Tetrahedralization& t, const std::string& name) {
  SCOPED_TRACE(name + ", " + std::to_string(t.site_count()) + " sites");
  ASSERT_EQ(t.tet_of_site.size(), t.points.size());
  for (const SiteId s : ids<SiteId>(t.points.size())) {
    ASSERT_LT(t.tet_of_site[s], t.tets.size());
    const auto& v = t.tets[t.tet_of_site[s]].v;
    ASSERT_NE(std::find(v.begin(), v.end(), s), v.end());
  }
  int hull = 0;
  for (const TetId i : ids<TetId>(t.tets.size())) {
    const Tetrahedron& tet = t.tets[i];
    const auto p = [&](int k) { return t.points[tet.v[k]]; };
    ASSERT_EQ(exact::orient3d(p(0), p(1), p(2), p(3)), 1) << "tetrahedron " << i;
    for (int k = 0; k < 4; ++k) {
      if (tet.n[k] == kNoTet) {
        ++hull;
        continue;
      }
      const Tetrahedron& other = t.tets[tet.n[k]];
      ASSERT_EQ(std::count(other.n.begin(), other.n.end(), i), 1);
      for (int j = 0; j < 4; ++j) {
        if (j == k) continue;
        ASSERT_NE(std::find(other.v.begin(), other.v.end(), tet.v[j]), other.v.end());
      }
    }
    if (t.site_count() <= 130)
      for (const SiteId s : ids<SiteId>(t.points.size())) {
        if (std::find(tet.v.begin(), tet.v.end(), s) != tet.v.end()) continue;
        ASSERT_EQ(exact::in_sphere(p(0), p(1), p(2), p(3), t.points[s]), -1)
            << "site " << s << " in the sphere of tetrahedron " << i;
      }
  }
  ASSERT_EQ(hull, 4);
}

TEST(Tetrahedralize, HasEmptySpheresForEveryFamilyAndSize) {
  for (const PointFamily& family : point_families())
    for (const std::uint32_t n : {0u, 1u, 2u, 3u, 4u, 5u, 8u, 27u, 64u, 125u, 600u}) {
      const std::vector<Vec3d> points = family.make(n, 11 + n);
      const auto result = tetrahedralize(points, box_of(points), {});
      ASSERT_TRUE(result.has_value()) << family.name << ": " << result.error().detail;
      check(*result, family.name);
      if (HasFatalFailure()) return;
    }
}

TEST(Tetrahedralize, GivesTheSameTetrahedraForEveryInsertionOrder) {
  for (const PointFamily& family : point_families())
    for (const std::uint32_t n : {5u, 27u, 125u, 512u}) {
      std::vector<Vec3d> points = family.make(n, 23);
      const Box box = box_of(points);
      const auto reference = tetrahedralize(points, box, {});
      ASSERT_TRUE(reference.has_value());
      Random random(n);
      for (int round = 0; round < 4; ++round) {
        shuffle(points, random);
        const auto shuffled = tetrahedralize(points, box, {});
        ASSERT_TRUE(shuffled.has_value());
        ASSERT_EQ(tet_set(*reference), tet_set(*shuffled)) << family.name << ", " << n << " points";
      }
    }
}

TEST(Tetrahedralize, NumbersSitesInTheCallersOrderAndMergesDuplicatesIntoTheFirst) {
  const std::vector<Vec3d> points{{3, 0, 0}, {1, 1, 1},      {3, 0, 0},     {0, 2, 0},
                                  {1, 1, 1}, {-0.0, 0.0, 0}, {0.0, -0.0, 0}};
  const auto result = tetrahedralize(points, box_of(points), {});
  ASSERT_TRUE(result.has_value());
  const std::vector<std::uint32_t> numbers(result->site_of_input.begin(), result->site_of_input.end());
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{0, 1, 0, 2, 1, 3, 3}));
  EXPECT_EQ(result->duplicates_merged, 3u);
  EXPECT_EQ(result->site_count(), 4u);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(result->points[result->site_of_input[i]], points[i]);
}

TEST(Tetrahedralize, DropsOnlySitesThatOwnNoPointOfTheBox) {
  Box box;
  box.add(Vec3d{0, 0, 0});
  box.add(Vec3d{1, 1, 1});
  std::vector<Vec3d> points = test::random_cube(20, 3);
  points.push_back({50, 0.5, 0.5});
  points.push_back({0.5, -40, 0.5});
  points.push_back({1.01, 0.5, 0.5});  // outside, but close enough to own a slice
  const auto result = tetrahedralize(points, box, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->far_sites_dropped, 2u);
  EXPECT_EQ(result->site_of_input[20], kNoSite);
  EXPECT_EQ(result->site_of_input[21], kNoSite);
  EXPECT_NE(result->site_of_input[22], kNoSite);
  // An independent check at many places of the box: the nearest of all points was never dropped.
  Random random(5);
  for (int i = 0; i < test::repetitions(2000); ++i) {
    Vec3d q;
    for (int a = 0; a < 3; ++a) q[a] = random.uniform();
    std::size_t best = 0;
    for (std::size_t s = 1; s < points.size(); ++s)
      if (length(points[s] - q) < length(points[best] - q)) best = s;
    ASSERT_NE(result->site_of_input[best], kNoSite);
  }
}

TEST(Tetrahedralize, WorksWhenAllSitesLieOutsideTheBox) {
  Box box;
  box.add(Vec3d{0, 0, 0});
  box.add(Vec3d{1, 1, 1});
  for (const PointFamily& family : point_families()) {
    std::vector<Vec3d> points = family.make(30, 2);
    for (Vec3d& p : points) p.x += 5;
    const auto result = tetrahedralize(points, box, {});
    ASSERT_TRUE(result.has_value());
    ASSERT_GE(result->site_count(), 1u);
    check(*result, family.name);
    if (HasFatalFailure()) return;
  }
}

TEST(Tetrahedralize, RefusesCoordinatesThatAreNotFiniteOrOutOfRangeByIndex) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1.1e12, -1e300}) {
    std::vector<Vec3d> points = test::random_cube(5, 1);
    points[3].y = bad;
    const auto result = tetrahedralize(points, box_of(test::random_cube(5, 1)), {});
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, ErrorCode::kNotFinite);
    EXPECT_EQ(result.error().pointer, "/points/3");
  }
}

TEST(Tetrahedralize, TwoSkewLinesEndInTooComplex) {
  std::vector<Vec3d> points;
  for (int i = 0; i < 6000; ++i)
    points.push_back(i % 2 ? Vec3d{i * 1.0, 0, 0} : Vec3d{3000, i - 3000.0, 6000});
  const auto result = tetrahedralize(points, box_of(points), {});
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kTooComplex);
}

TEST(Tetrahedralize, StopsWhenCancelled) {
  std::stop_source source;
  source.request_stop();
  Execution execution;
  execution.stop = source.get_token();
  const std::vector<Vec3d> points = test::random_cube(10, 1);
  EXPECT_THROW((void)tetrahedralize(points, box_of(points), execution), Interrupted);
}

}  // namespace
}  // namespace fracture
