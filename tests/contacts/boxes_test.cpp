// Contacts of boxes, computed by hand. Coordinates are multiples of powers of two, so that nothing is
// rounded.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/contacts/part_meshes.hpp"

namespace fracture::test {
namespace {

constexpr double kGap = 1.0 / 1024;

void expect_near(const Vec3d& p, const Vec3d& q, double tolerance = 1e-12) {
  EXPECT_NEAR(p.x, q.x, tolerance);
  EXPECT_NEAR(p.y, q.y, tolerance);
  EXPECT_NEAR(p.z, q.z, tolerance);
}

/// Returns the only contact of the graph, and expects that it has exactly one.
Contact only_contact(const ContactGraph& graph) {
  EXPECT_EQ(graph.contacts.size(), 1u);
  if (graph.contacts.size() != 1) return {};
  const Contact& contact = graph.contacts[0];
  EXPECT_EQ(contact.a, 0u);
  EXPECT_EQ(contact.b, 1u);
  EXPECT_NEAR(length(contact.normal), 1, 1e-12);
  return contact;
}

TEST(Contacts, OfOnePartAreNone) { EXPECT_TRUE(contacts_of({cube()}, kGap).contacts.empty()); }

TEST(Contacts, OfALegThatGoesIntoATopAreTheFootprintAndTheCommonVolume) {
  const Mesh top = box({0, 0, 1}, {1, 1, 1.0625}), leg = box({0.125, 0.25, 0}, {0.1875, 0.3125, 1.015625});
  const Contact c = only_contact(contacts_of({top, leg}, kGap));
  EXPECT_EQ(c.kind, ContactKind::kOverlapping);
  // The end of the leg and four strips are inside the top. The footprint, inside the leg, is smaller.
  const double side = 0.0625, depth = 0.015625;
  EXPECT_NEAR(c.area, side * side, 1e-15);
  EXPECT_NEAR(c.volume, side * side * depth, 1e-16);
  expect_near(c.normal, {0, 0, -1});
  // The end and the footprint are equally large, and the strips are in the middle between them.
  expect_near(c.place, {0.15625, 0.28125, 1 + depth / 2});
}

TEST(Contacts, OfBoxesThatTouchAreTheCommonPartOfTheirFaces) {
  const Contact c = only_contact(contacts_of({cube(), box({0, -0.25, 0.5}, {1, 2, 1.5})}, kGap));
  EXPECT_EQ(c.kind, ContactKind::kTouching);
  EXPECT_DOUBLE_EQ(c.area, 0.5 * 0.75);
  EXPECT_EQ(c.volume, 0);
  expect_near(c.normal, {0, 0, 1});
  expect_near(c.place, {0.25, 0.125, 0.5});
}

TEST(Contacts, OfFacesInManyTrianglesAreThoseOfFacesInFew) {
  const Contact c = only_contact(contacts_of({cube(7), box({0, -0.25, 0.5}, {1, 2, 1.5}, 5)}, kGap));
  EXPECT_NEAR(c.area, 0.5 * 0.75, 1e-6);  // sevenths are rounded
  expect_near(c.place, {0.25, 0.125, 0.5}, 1e-6);
  expect_near(c.normal, {0, 0, 1}, 1e-6);
}

TEST(Contacts, ReachAcrossTheGapAndNoFarther) {
  const auto apart = [](double distance, double gap) {
    return contacts_of({cube(), translated(cube(), {1 + distance, 0.5, 0})}, gap);
  };
  const Contact c = only_contact(apart(kGap / 2, kGap));
  EXPECT_EQ(c.kind, ContactKind::kTouching);
  EXPECT_DOUBLE_EQ(c.area, 0.5);
  expect_near(c.normal, {1, 0, 0});
  expect_near(c.place, {0.5 + kGap / 4, 0.25, 0});
  EXPECT_DOUBLE_EQ(only_contact(apart(kGap, kGap)).area, 0.5);
  EXPECT_TRUE(apart(kGap * 1.001, kGap).contacts.empty());
  EXPECT_DOUBLE_EQ(only_contact(apart(0, 0)).area, 0.5);
  EXPECT_TRUE(apart(kGap / 256, 0).contacts.empty());
}

TEST(Contacts, AlongAnEdgeOrAtACornerHaveNoArea) {
  const Contact edge = only_contact(contacts_of({cube(), translated(cube(), {1, 0.5, 1})}, kGap));
  EXPECT_EQ(edge.kind, ContactKind::kTouching);
  EXPECT_EQ(edge.area, 0);
  expect_near(edge.place, {0.5, 0.25, 0.5});
  expect_near(edge.normal, (2.0 / 3) * Vec3d{1, 0.5, 1});  // from centre to centre
  const Contact corner = only_contact(contacts_of({cube(), translated(cube(), {1, -1, 1})}, kGap));
  EXPECT_EQ(corner.area, 0);
  expect_near(corner.place, {0.5, -0.5, 0.5});
  expect_near(corner.normal, (1 / std::sqrt(3.0)) * Vec3d{1, -1, 1});
}

TEST(Contacts, AcrossAnEdgeReachAsFarAsTheGapMeasuredStraight) {
  // Moves a cube sideways and up: by 0.6 and 0.8 of the distance between the edges.
  const auto apart = [](double d) {
    return contacts_of({cube(), translated(cube(), {1 + 0.6 * d, 0, 1 + 0.8 * d})}, 0.125);
  };
  EXPECT_EQ(only_contact(apart(0.1249)).area, 0);
  EXPECT_TRUE(apart(0.1251).contacts.empty());
}

TEST(Contacts, OfAPartInsideAnotherAreItsWholeSurface) {
  const Mesh inner = box({-0.25, -0.25, -0.125}, {0.25, 0.25, 0.25});
  for (const bool swapped : {false, true}) {
    const Contact c =
        only_contact(contacts_of(swapped ? std::vector{inner, cube()} : std::vector{cube(), inner}, kGap));
    EXPECT_EQ(c.kind, ContactKind::kOverlapping);
    EXPECT_DOUBLE_EQ(c.area, 2 * 0.25 + 4 * 0.5 * 0.375);
    EXPECT_DOUBLE_EQ(c.volume, 0.5 * 0.5 * 0.375);
    expect_near(c.place, {0, 0, 0.0625});
    expect_near(c.normal, {0, 0, swapped ? -1.0 : 1.0});
  }
}

TEST(Contacts, OfAPartInACavityAreWhatTouchesItsWalls) {
  const Mesh hollow =
      joined({box({-1, -1, -1}, {1, 1, 1}), reversed(box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}))});
  EXPECT_TRUE(contacts_of({hollow, box({-0.25, -0.25, -0.25}, {0.25, 0.25, 0.25})}, kGap).contacts.empty());
  const Contact c = only_contact(contacts_of({hollow, box({-0.25, -0.25, -0.5}, {0.25, 0.5, 0.25})}, kGap));
  EXPECT_EQ(c.kind, ContactKind::kTouching);
  EXPECT_DOUBLE_EQ(c.area, 0.5 * 0.75 + 0.5 * 0.75);  // floor and wall
  expect_near(c.normal, std::sqrt(0.5) * Vec3d{0, -1, 1});
  // The bar goes through the wall of the cavity: a quarter of it is in the wall.
  const Contact stuck =
      only_contact(contacts_of({hollow, box({-0.25, -0.25, -0.75}, {0.25, 0.25, 0.25})}, kGap));
  EXPECT_EQ(stuck.kind, ContactKind::kOverlapping);
  EXPECT_DOUBLE_EQ(stuck.volume, 0.5 * 0.5 * 0.25);
  EXPECT_DOUBLE_EQ(stuck.area, 0.25);
}

TEST(Contacts, OfAPartAndItsCopyAreTheWholePart) {
  const Solid one = solid_of(cube());
  const Contact c = only_contact(contacts_of(both(one, one), kGap));
  EXPECT_EQ(c.kind, ContactKind::kOverlapping);
  EXPECT_DOUBLE_EQ(c.volume, 1);
  EXPECT_DOUBLE_EQ(c.area, 6);
}

TEST(Contacts, OfFlushBoxesDoNotDependOnTheSideThatIsFlush) {
  // A peg that goes into a block and is flush with one of its sides, in each direction.
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      Vec3d low{-0.25, -0.25, -0.25}, high{0.25, 0.25, 0.25};
      (sign > 0 ? high : low)[axis] = 0.5 * sign;             // flush
      (sign > 0 ? high : low)[(axis + 1) % 3] = 0.75 * sign;  // sticks out
      for (const bool swapped : {false, true}) {
        const Contact c = only_contact(contacts_of(
            swapped ? std::vector{box(low, high), cube()} : std::vector{cube(), box(low, high)}, kGap));
        EXPECT_EQ(c.kind, ContactKind::kOverlapping);
        EXPECT_NEAR(c.volume, 0.75 * 0.75 * 0.5, 1e-14) << axis << sign;
        EXPECT_NEAR(c.area, 0.75 * 0.5, 1e-14) << axis << sign;  // where the peg leaves the block
        Vec3d normal{};
        normal[(axis + 1) % 3] = swapped ? -sign : sign;
        EXPECT_GT(dot(c.normal, normal), 0.5) << axis << sign;
      }
    }
}

TEST(Contacts, OfTurnedBoxesAreThoseOfTheBoxes) {
  const Turn turn = rational_turn();
  const auto of = [&](const Mesh& a, const Mesh& b) {
    return only_contact(contacts_of({turned(a, turn), turned(b, turn)}, kGap));
  };
  const Contact touching = of(cube(), box({0, -0.25, 0.5}, {1, 2, 1.5}));
  EXPECT_EQ(touching.kind, ContactKind::kTouching);
  EXPECT_EQ(touching.volume, 0);
  EXPECT_NEAR(touching.area, 0.5 * 0.75, 1e-6);
  expect_near(touching.normal, turn[2], 1e-6);
  expect_near(touching.place, turned({0.25, 0.125, 0.5}, turn), 1e-6);
  const Contact many = of(cube(9), box({0, -0.25, 0.5}, {1, 2, 1.5}, 8));  // too large for the plane test
  EXPECT_EQ(many.kind, ContactKind::kTouching);
  EXPECT_NEAR(many.area, 0.5 * 0.75, 1e-6);
  const Contact overlapping = of(cube(), box({0, -0.25, 0.25}, {1, 2, 1.5}));
  EXPECT_EQ(overlapping.kind, ContactKind::kOverlapping);
  EXPECT_NEAR(overlapping.volume, 0.5 * 0.75 * 0.25, 1e-6);
  // Each has three faces inside the other: the lid and two strips.
  EXPECT_NEAR(overlapping.area, 0.5 * 0.75 + 0.25 * (0.5 + 0.75), 1e-6);
  expect_near(overlapping.place, turned({0.25, 0.125, 0.375}, turn), 1e-6);
}

TEST(Contacts, FarFromTheOriginAreThoseAtIt) {
  const Vec3d far{65536, -131072, 65536};  // floats have steps of 2^-7 and 2^-6 there
  const auto of = [&](const Mesh& b) {
    return only_contact(contacts_of({translated(cube(), far), translated(b, far)}, 0.0625));
  };
  const Contact touching = of(box({0, -0.25, 0.5}, {1, 2, 1.5}));
  EXPECT_EQ(touching.kind, ContactKind::kTouching);
  EXPECT_DOUBLE_EQ(touching.area, 0.5 * 0.75);
  expect_near(touching.place, far + Vec3d{0.25, 0.125, 0.5});
  const Contact overlapping = of(box({0, -0.25, 0.25}, {1, 2, 1.5}));
  EXPECT_EQ(overlapping.kind, ContactKind::kOverlapping);
  EXPECT_NEAR(overlapping.volume, 0.5 * 0.75 * 0.25, 1e-12);
}

// At 8192 times the size, a step of floats is as wide as the gap, and one step on each axis is below two steps.
TEST(Contacts, AreTheSameWhereverThePartsAre) {
  constexpr double kStep = 0x1p-10;
  const auto moved = [](double up, const Vec3d& by) {
    return contacts_of({translated(box({0, 0, 0}, {1, 1, 1}), by),
                        translated(box({0.5, -0.25, 1 + up}, {1.5, 2, 2 + up}), by)},
                       kStep);
  };
  for (const Vec3d& by : {Vec3d{8192, 8192, 8192}, Vec3d{-8194, 0, 8192}})
    for (const double steps : {-256.0, -2.0, 0.0, 1.0, 3.0}) {
      SCOPED_TRACE(steps);
      const ContactGraph here = moved(steps * kStep, {}), there = moved(steps * kStep, by);
      EXPECT_EQ(here.contacts.size(), steps < 2 ? 1u : 0u);
      ASSERT_EQ(there.contacts.size(), here.contacts.size());
      if (here.contacts.empty()) continue;
      const Contact &x = here.contacts[0], &y = there.contacts[0];
      EXPECT_EQ(x.kind, steps < 0 ? ContactKind::kOverlapping : ContactKind::kTouching);
      EXPECT_EQ(y.kind, x.kind);
      EXPECT_EQ(y.measure, x.measure);
      EXPECT_NEAR(y.area, x.area, 1e-9);
      EXPECT_NEAR(y.volume, x.volume, 1e-9);
      expect_near(y.normal, x.normal, 1e-9);
      expect_near(y.place, x.place + by, 1e-9);
    }
}

TEST(Contacts, OfAnEdgeThatStandsOnAFaceAreTwoStripsAsWideAsTheGap) {
  // A square bar that rests on its edge, from x = -1/2 to 1/2. Its sides rise at 45 degrees, so the strip of
  // each side within the gap is as wide as the gap.
  Mesh bar = box({-0.5, 0, 0}, {0.5, 0.25, 0.25});
  for (Vec3f& p : bar.positions) p = {p.x, p.y - p.z, p.y + p.z + 0.5f};
  const Contact c = only_contact(contacts_of({cube(), bar}, 0.0625));
  EXPECT_EQ(c.kind, ContactKind::kTouching);
  EXPECT_NEAR(c.area, 2 * 0.0625, 1e-6);
  expect_near(c.normal, {0, 0, 1}, 1e-6);
  expect_near(c.place, {0, 0, c.place.z}, 1e-6);
}

TEST(Contacts, OfATurnedEdgeContactHaveNoArea) {
  const Turn turn = rational_turn();
  const Contact c =
      only_contact(contacts_of({turned(cube(), turn), turned(translated(cube(), {1, 0.5, 1}), turn)}, kGap));
  EXPECT_EQ(c.kind, ContactKind::kTouching);
  EXPECT_NEAR(c.area, 0, 1e-9);
}

}  // namespace
}  // namespace fracture::test
