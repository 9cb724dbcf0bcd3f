// Openings in Bullet: a ball flies through the opening of a fragment that stays whole, and neither of them notices.
#include <gtest/gtest.h>

#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "client/world/fragments.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "tests/client/cubes.hpp"
#include "tests/physics/bent_shapes.hpp"
#include "tests/support/fractured.hpp"

namespace fracture::world {
namespace {

constexpr double kInside = 0.8;  // of a frame around [-kInside, kInside]² in [-1, 1]², around the z axis

Mesh frame() {
  return test::grid_solid({{{-1, -kInside, kInside, 1}, {-1, -kInside, kInside, 1}, {-0.05, 0.05}}},
                          [](int i, int j, int) { return i != 1 || j != 1; });
}

FragmentSet answer(const Mesh& mesh, PointsPattern sites, double rough, std::uint32_t max_hulls) {
  FractureParameters p;
  p.pattern = std::move(sites);
  p.roughness.amplitude = rough;
  p.hull_limits.count = max_hulls;
  p.hulls = Hulls::kConvex;
  const std::vector<std::uint8_t> glb = write_glb(test::fracture_mesh(mesh, p), {});
  Expected<FragmentSet> set = read_fragments(std::as_bytes(std::span(glb)));
  if (!set) throw std::runtime_error(set.error().detail);
  return *std::move(set);
}

/// A ball thrown along the z axis from two metres in front of `through`: does it get two metres behind on a straight line,
/// while the fragments stay where they are?
bool passes(FragmentSet set, const glm::dvec3& through, double radius) {
  constexpr glm::dvec3 kPlace{0, 10, 0};
  WorldSettings settings;
  settings.gravity = glm::dvec3(0);
  World world(settings);
  ObjectSpec whole = test::whole_of(set);
  whole.pose.position = kPlace;
  const ObjectId object = world.add_object(whole);
  world.fracture(object, prepare(std::move(set)));
  world.throw_ball(kPlace + through - glm::dvec3(0, 0, 2), {0, 0, 8}, radius, 1000);
  for (int k = 0; k < 60; ++k) world.step();
  const glm::dvec3 off = world.balls().at(0).pose.position - kPlace - through - glm::dvec3(0, 0, 2);
  return glm::length(off) < 1e-6 && world.census().fastest < 1e-6;
}

TEST(Openings, ABallFliesThroughAFrame) {
  const FragmentSet whole = answer(frame(), {{{0, 0, 0}}}, 0, 4);
  ASSERT_EQ(whole.fragments.size(), 1u);
  EXPECT_TRUE(passes(whole, {0, 0, 0}, kInside - 0.01));
  EXPECT_FALSE(passes(whole, {0, 0, 0}, kInside + 0.01)) << "it is wider than the opening";
  EXPECT_FALSE(passes(answer(frame(), {{{0, 0, 0}}}, 0, 1), {0, 0, 0}, 0.1)) << "one hull closes the opening";
}

TEST(Openings, ABallFliesBetweenTheHalvesOfAFrame) {
  for (const double rough : {0.0, 0.03}) {
    const FragmentSet halves = answer(frame(), {{{-0.5, 0, 0}, {0.5, 0, 0}}}, rough, 4);
    ASSERT_EQ(halves.fragments.size(), 2u);
    EXPECT_TRUE(passes(halves, {0, 0, 0}, kInside - 0.01)) << rough;
  }
}

// Each half consists of two cells.
TEST(Openings, ABallFliesBetweenHalvesOfSeveralCells) {
  const PointsPattern quarters{{{-0.5, -0.5, 0}, {-0.5, 0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}},
                               {0, 0, 1, 1}};
  for (const double rough : {0.0, 0.03}) {
    const FragmentSet halves = answer(frame(), quarters, rough, 4);
    ASSERT_EQ(halves.fragments.size(), 2u);
    EXPECT_TRUE(passes(halves, {0, 0, 0}, kInside - 0.01)) << rough;
  }
}

// Two frames next to a wall, each in a cell of its own.
TEST(Openings, BallsFlyThroughFramesBesideAWall) {
  const Mesh mesh =
      test::joined({frame(), test::translated(frame(), {2.5, 0, 0}), test::box({4, -1, -0.1}, {6, 1, 0.1})});
  const FragmentSet set = answer(mesh, {{{0, 0, 0}, {2.5, 0, 0}, {5, 0, 0}}}, 0, 4);
  ASSERT_EQ(set.fragments.size(), 3u);
  EXPECT_TRUE(passes(set, {0, 0, 0}, kInside - 0.01));
  EXPECT_TRUE(passes(set, {2.5, 0, 0}, kInside - 0.01));
  EXPECT_FALSE(passes(set, {5, 0, 0}, 0.1));
}

// A hull of a part that takes a third of a turn leaves half of the radius free, and one of a quarter turn seven tenths.
TEST(Openings, ABallFliesThroughARing) {
  const Mesh ring = test::torus(24, 12, 1, 0.1);
  EXPECT_TRUE(passes(answer(ring, {{{0, 0, 0}}}, 0, 4), {0, 0, 0}, 0.4));
  EXPECT_TRUE(passes(answer(ring, {{{0, 0, 0}}}, 0, 8), {0, 0, 0}, 0.6));
}

TEST(Openings, ABallFliesThroughTheHandleOfAMug) {
  const Mesh mug = test::round_solid({0, 0.88, 1, 1.4, 1.6}, 16, {0, 0.15, 0.5, 0.7, 1.5, 1.7, 2},
                                     [](int i, int j, int k) {
                                       if (i == 0) return k == 0;
                                       if (i == 1) return true;
                                       return j == 0 && (i == 2 ? k == 2 || k == 4 : k >= 2 && k <= 4);
                                     });
  // The handle is at x, in the plane of the z axis: turned so that its opening is around z.
  Mesh turned = mug;
  for (Vec3f& p : turned.positions) p = {p.x, p.z, -p.y};
  EXPECT_TRUE(passes(answer(turned, {{{0, 0, 0}}}, 0, 16), {1.15, 1.1, 0}, 0.1));
}

}  // namespace
}  // namespace fracture::world
