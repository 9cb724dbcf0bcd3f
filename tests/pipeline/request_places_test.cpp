#include "common/sites/request_places.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/bvh/surface_tree.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// A shell of 2 m around an empty room of 1.8 m.
Solid room() {
  return solid_of(joined({scaled(cube(), {2, 2, 2}), reversed(scaled(cube(), {1.8f, 1.8f, 1.8f}))}));
}

double distance_to(const Solid& solid, const Vec3d& p) {
  double least = HUGE_VAL;
  for (const auto& [a, b, c] : solid.triangles)
    least =
        std::min(least, distance_to_triangle(p, to_double(solid.positions[a]), to_double(solid.positions[b]),
                                             to_double(solid.positions[c])));
  return least;
}

void expect_near(const std::vector<Vec3d>& places, const std::vector<Vec3d>& expected) {
  ASSERT_EQ(places.size(), expected.size());
  for (std::size_t k = 0; k < places.size(); ++k) EXPECT_LT(length(places[k] - expected[k]), 1e-9) << k;
}

struct Placed {
  std::vector<Vec3d> impacts;
  Remarks remarks;
};
Placed placed(const Solid& solid, SitePattern pattern) {
  Placed result;
  put_impacts_on(solid, pattern, result.remarks, {});
  const std::span<const Vec3d> impacts = impacts_of(pattern);
  result.impacts.assign(impacts.begin(), impacts.end());
  return result;
}

TEST(RequestPlaces, TheDefaultImpactIsOnTheWallOfAHollowBody) {
  const Solid solid = room();
  const Placed hollow = placed(solid, ImpactPattern{});
  ASSERT_EQ(hollow.impacts.size(), 1u);
  EXPECT_LT(distance_to(solid, hollow.impacts[0]), 1e-6);
  EXPECT_NEAR(length(hollow.impacts[0]), 0.9, 1e-6) << "the inner side of the wall";
  EXPECT_TRUE(any_has(hollow.remarks.notes, "No impact point is set"));
  EXPECT_TRUE(hollow.remarks.warnings.empty());
  const Placed full = placed(solid_of(cube()), ImpactPattern{});
  EXPECT_EQ(full.impacts, (std::vector<Vec3d>{{0, 0, 0}}));
  EXPECT_TRUE(full.remarks.empty());
  EXPECT_TRUE(placed(solid, RadialPattern{}).impacts.empty()) << "it has a default centre of its own";
}

TEST(RequestPlaces, WithTheDefaultImpactPiecesAreSmallestNearThePlaceThatIsHit) {
  const Solid solid = room();
  FractureParameters p;
  p.pattern = ImpactPattern{.radius = 0.5};
  p.sites = 60;
  const Fractured f = fracture_solid(solid, p);
  ASSERT_EQ(f.diagram.impacts.size(), 1u);
  const auto near = std::count_if(f.diagram.sites.begin(), f.diagram.sites.end(),
                                  [&](const Vec3d& s) { return length(s - f.diagram.impacts[0]) <= 0.5; });
  EXPECT_GE(near, 45) << "0.8 of 60 sites are near the impact";
}

TEST(RequestPlaces, AnImpactFarOutsideIsMovedToTheSurfaceAndTheUnitIsSuggested) {
  const Solid solid = solid_of(cube());  // 1 m, about the origin
  const Placed centimetres = placed(solid, ImpactPattern{.impacts = {{50, 0.1, 0}}});
  expect_near(centimetres.impacts, {{0.5, 0.1, 0}});
  ASSERT_EQ(centimetres.remarks.warnings.size(), 1u);
  const std::string& warning = centimetres.remarks.warnings[0];
  for (const char* part : {"50,0.1,0", "49.5 m", "0.5,0.1,0", "'impacts'", "centimetres"})
    EXPECT_NE(warning.find(part), std::string::npos) << part << " is not in: " << warning;
  const Placed millimetres = placed(solid, BrickPattern{.impacts = {{0, 400, 0}, {0.2, 0, 0}, {9, 0, 0}}});
  expect_near(millimetres.impacts, {{0, 0.5, 0}, {0.2, 0, 0}, {0.5, 0, 0}});
  EXPECT_TRUE(any_has(millimetres.remarks.warnings, "millimetres"));
  EXPECT_TRUE(any_has(millimetres.remarks.warnings, "1 further impact"));
  const Placed unknown = placed(solid, RadialPattern{.impacts = {{1, 0, 0}}});
  expect_near(unknown.impacts, {{0.5, 0, 0}});
  EXPECT_TRUE(any_has(unknown.remarks.warnings, "Move 'impacts' onto the mesh"));
}

TEST(RequestPlaces, AnImpactInTheSolidOrNearItStaysWhereItIs) {
  for (const Vec3d& impact : {Vec3d{0, 0, 0}, Vec3d{0.49, -0.2, 0.1}, Vec3d{0.59, 0, 0}}) {
    const Placed near = placed(solid_of(cube()), ImpactPattern{.impacts = {impact}});
    EXPECT_EQ(near.impacts, std::vector<Vec3d>{impact});
    EXPECT_TRUE(near.remarks.empty());
  }
  // The middle of the room is outside the solid, 0.9 m from its wall.
  EXPECT_NEAR(length(placed(room(), ImpactPattern{.impacts = {{0, 0, 0}}}).impacts[0]), 0.9, 1e-6);
}

TEST(RequestPlaces, PointsWithoutEffectAreNamed) {
  const auto warnings = [](std::vector<Vec3d> points) {
    FractureParameters p;
    p.pattern = PointsPattern{std::move(points)};
    return fracture_mesh(cube(), p).report.remarks.warnings;
  };
  EXPECT_TRUE(warnings({{0.1, 0, 0}, {-0.1, 0, 0}, {0.55, 0, 0}}).empty());
  const auto equal = warnings({{0.1, 0, 0}, {0.1, 0, 0}, {0.1, 0, 0}});
  EXPECT_TRUE(any_has(equal, "2 of the 'points' have the same positions as others"));
  const auto outside = warnings({{10, 0, 0}, {20, 0, 0}});
  EXPECT_TRUE(any_has(outside, "None of the 'points' is inside the mesh"));
  EXPECT_TRUE(any_has(outside, "10,0,0 looks like centimetres"));
  const auto one = warnings({{0.1, 0, 0}, {-0.1, 0, 0}, {-30, 0, 0}});
  EXPECT_TRUE(any_has(one, "1 of the 'points' is far outside the mesh"));
}

}  // namespace
}  // namespace fracture::test
