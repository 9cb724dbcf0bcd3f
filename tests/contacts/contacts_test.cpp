// Whole contact graphs: walls, order, threads, interruption.
#include "common/contacts/contacts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <stop_token>
#include <utility>

#include "tests/contacts/part_meshes.hpp"

namespace fracture::test {
namespace {

constexpr double kLong = 0.25, kHigh = 0.0625, kDeep = 0.125;  // metres, the size of a brick

/// Bricks in running bond along x and y. Odd courses are shifted by half a brick along x. The part number is
/// row * columns + column.
Mesh wall(int rows, int columns) {
  std::vector<Mesh> bricks;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double x = kLong * column + (row % 2 == 1 ? kLong / 2 : 0), y = kHigh * row;
      bricks.push_back(box({x, y, 0}, {x + kLong, y + kHigh, kDeep}));
    }
  return joined(bricks);
}

TEST(ContactGraph, OfAWallOfAThousandBricksHasEachJointOnce) {
  constexpr int kRows = 25, kColumns = 40;
  const ContactGraph graph = contacts_of(solid_of(wall(kRows, kColumns)), kHigh / 64);
  EXPECT_EQ(graph.gap, kHigh / 64);
  std::map<std::pair<int, int>, double> expected;  // areas
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const int brick = row * kColumns + column;
      if (column + 1 < kColumns) expected[{brick, brick + 1}] = kHigh * kDeep;
      if (row + 1 == kRows) continue;
      // Above each brick lie the brick of the same column and the one before or after it.
      const int beside = row % 2 == 1 ? column + 1 : column - 1;
      expected[{brick, brick + kColumns}] = kLong / 2 * kDeep;
      if (beside >= 0 && beside < kColumns)
        expected[{brick, (row + 1) * kColumns + beside}] = kLong / 2 * kDeep;
    }
  ASSERT_EQ(graph.contacts.size(), expected.size());
  auto next = expected.begin();
  for (const Contact& c : graph.contacts) {
    ASSERT_EQ(std::pair(static_cast<int>(c.a), static_cast<int>(c.b)), next->first);
    ASSERT_EQ(c.kind, ContactKind::kTouching);
    ASSERT_NEAR(c.area, next->second, 1e-15);
    ASSERT_EQ(c.normal, c.b - c.a == 1 ? (Vec3d{1, 0, 0}) : (Vec3d{0, 1, 0}));
    ++next;
  }
}

TEST(ContactGraph, OfATurnedWallIsThatOfTheWall) {
  const Mesh straight = wall(12, 12);
  const Turn turn = rational_turn();
  const ContactGraph graph = contacts_of(solid_of(straight), kHigh / 64),
                     turned_graph = contacts_of(solid_of(turned(straight, turn)), kHigh / 64);
  ASSERT_EQ(turned_graph.contacts.size(), graph.contacts.size());
  for (std::size_t k = 0; k < graph.contacts.size(); ++k) {
    const Contact &c = graph.contacts[k], &t = turned_graph.contacts[k];
    ASSERT_EQ(std::pair(t.a, t.b), std::pair(c.a, c.b));
    ASSERT_EQ(t.kind, c.kind);
    ASSERT_NEAR(t.area, c.area, 1e-4 * c.area);
    ASSERT_LT(length(t.normal - turned(c.normal, turn)), 1e-4);
    ASSERT_LT(length(t.place - turned(c.place, turn)), 1e-5);
  }
}

TEST(ContactGraph, OfAskewBoardsHasTheBoardsSideBySide) {
  // Their axis-parallel boxes all overlap.
  std::vector<Mesh> boards;
  for (int k = 0; k < 40; ++k)
    boards.push_back(turned(box({0, 0.125 * k, 0}, {16, 0.125 * (k + 1), 0.125}), rational_turn()));
  const ContactGraph graph = contacts_of(boards, 1e-3);
  ASSERT_EQ(graph.contacts.size(), 39u);
  for (std::uint32_t k = 0; k < 39; ++k) {
    EXPECT_EQ(std::pair(graph.contacts[k].a, graph.contacts[k].b), std::pair(k, k + 1));
    EXPECT_NEAR(graph.contacts[k].area, 16 * 0.125, 1e-3);
  }
}

TEST(ContactGraph, OfAGridOfCubesHasFacesEdgesAndCorners) {
  std::vector<Mesh> cubes;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z) cubes.push_back(translated(cube(), {1.0 * x, 1.0 * y, 1.0 * z}));
  const ContactGraph graph = contacts_of(cubes, 1e-3);
  std::size_t faces = 0;
  for (const Contact& c : graph.contacts) {
    EXPECT_TRUE(c.area == 0 || c.area == 1) << c.area;
    faces += c.area == 1;
  }
  EXPECT_EQ(faces, 3u * 3 * 4 * 4);
  // Counts pairs of cubes whose distance is -1, 0 or 1 steps on each axis. There are (4 + 2 · 3)³ ordered
  // pairs, minus each cube with itself.
  EXPECT_EQ(graph.contacts.size(), (10u * 10 * 10 - 64) / 2);
}

/// Bricks, boards, overlapping spheres and a nested sphere.
Solid mixed_solid() {
  std::vector<Mesh> meshes{wall(10, 10)};
  for (int k = 0; k < 6; ++k) meshes.push_back(translated(sphere_with(900, 0.25), {0.3 * k, 0.7, 0.1}));
  meshes.push_back(translated(sphere_with(100, 0.1), {0, 0.7, 0.1}));
  return solid_of(joined(meshes));
}

TEST(ContactGraph, DoesNotDependOnTheThreads) {
  const Solid solid = mixed_solid();
  const ContactGraph one = contacts_of(solid, 2e-3);
  EXPECT_GT(one.contacts.size(), 280u);
  for (const int threads : {2, 3, 8}) {
    Execution execution;
    execution.threads = threads;
    EXPECT_EQ(find_contacts(solid, 2e-3, execution).contacts, one.contacts) << threads;
  }
}

TEST(ContactGraph, IsTheSameSeenFromTheOtherPart) {
  const Mesh a = sphere_with(800),
             b = turned(translated(box({0, 0, 0}, {1, 1.5, 0.75}, 3), {0.5, 0.125, -0.25}), rational_turn());
  for (const double gap : {0.0, 0.01}) {
    const ContactGraph ab = contacts_of({a, b}, gap), ba = contacts_of({b, a}, gap);
    ASSERT_EQ(ab.contacts.size(), 1u);
    ASSERT_EQ(ba.contacts.size(), 1u);
    const Contact &x = ab.contacts[0], &y = ba.contacts[0];
    EXPECT_EQ(x.kind, y.kind);
    EXPECT_NEAR(x.area, y.area, 1e-12);
    EXPECT_NEAR(x.volume, y.volume, 1e-12);
    EXPECT_LT(length(x.normal + y.normal), 1e-9);
    EXPECT_LT(length(x.place - y.place), 1e-9);
  }
}

// The pieces of a contact add up to its area, both by their corners and by their stated areas.
TEST(ContactGraph, KeepsTheSurfaceOfEachContactInPieces) {
  const ContactGraph graph = contacts_of(mixed_solid(), 2e-3);
  ASSERT_EQ(graph.first_piece.size(), graph.contacts.size() + 1);
  ASSERT_EQ(graph.first_piece.back(), graph.pieces.size());
  for (std::size_t k = 0; k < graph.contacts.size(); ++k) {
    double stated = 0, seen = 0;
    for (std::uint32_t p = graph.first_piece[k]; p < graph.first_piece[k + 1]; ++p) {
      const auto& [a, b, c, d] = graph.pieces[p].corners;
      stated += graph.pieces[p].area;
      seen += 0.5 * (length(cross(b - a, c - a)) + length(cross(c - a, d - a)));
    }
    EXPECT_NEAR(stated, graph.contacts[k].area, 1e-5 * graph.contacts[k].area) << k;
    EXPECT_NEAR(seen, graph.contacts[k].area, 1e-3 * graph.contacts[k].area) << k;
  }
}

TEST(ContactGraph, EndsWhenItIsToldTo) {
  const Solid solid = mixed_solid();
  std::uint64_t polls = 0;
  Execution counting;
  counting.watch = [&] { ++polls; };
  find_contacts(solid, 2e-3, counting);
  ASSERT_GT(polls, 20u);
  for (std::uint64_t at = 0; at < polls; at += 5) {
    std::stop_source source;
    std::uint64_t seen = 0;
    Execution execution;
    execution.stop = source.get_token();
    execution.watch = [&] {
      if (seen++ == at) source.request_stop();
    };
    EXPECT_THROW(find_contacts(solid, 2e-3, execution), Interrupted);
    EXPECT_EQ(seen, at + 1);
  }
}

TEST(ContactGraph, CountsItsContacts) {
  const Solid solid = mixed_solid();
  Allowance wide(0, 1ull << 40, [](std::uint64_t) { return Allowance::Answer::kGranted; });
  Execution execution;
  execution.allowance = &wide;
  const std::size_t contacts = find_contacts(solid, 2e-3, execution).contacts.size();
  EXPECT_EQ(contacts, wide.made(Product::kContacts));
  Allowance narrow(0, 1000, [](std::uint64_t) { return Allowance::Answer::kNever; });
  execution.allowance = &narrow;
  EXPECT_THROW(find_contacts(solid, 2e-3, execution), Interrupted);
}

}  // namespace
}  // namespace fracture::test
