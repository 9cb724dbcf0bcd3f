// Cuts of solids by planes, against volumes by hand.
#include "common/physics/polyhedron.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>

#include "tests/physics/bent_shapes.hpp"
#include "tests/support/figures.hpp"

namespace fracture::test {
namespace {

Polyhedron solid_of(const Mesh& mesh) {
  Polyhedron solid;
  for (const Vec3f& p : mesh.positions) solid.points.push_back(to_double(p));
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) solid.edges.push_back({t[k], t[(k + 1) % 3]});
    const Vec3d n = cross(solid.points[t[1]] - solid.points[t[0]], solid.points[t[2]] - solid.points[t[0]]);
    solid.faces.push_back({static_cast<std::uint32_t>(solid.edges.size()), (1 / length(n)) * n});
  }
  return solid;
}

/// Directed edges without as many the other way.
std::size_t open_edges(const Polyhedron& solid) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sum;
  for (const auto& [from, to] : solid.edges)
    sum[{std::min(from, to), std::max(from, to)}] += from < to ? 1 : -1;
  return static_cast<std::size_t>(
      std::count_if(sum.begin(), sum.end(), [](const auto& e) { return e.second != 0; }));
}

class Cuts : public testing::Test {
 protected:
  /// The bodies, each closed and with the volume that the cut says.
  std::vector<Polyhedron> cut(const Polyhedron& solid, const CutPlane& plane) {
    cutter_.cut(solid, plane, 1e-7, pacer_);
    std::vector<Polyhedron> out;
    for (const PolyhedronCutter::Body& body : cutter_.bodies()) {
      cutter_.write(body, out.emplace_back(), pacer_);
      EXPECT_EQ(open_edges(out.back()), 0u);
      EXPECT_NEAR(volume_of(out.back(), pacer_), body.volume, 1e-9);
      EXPECT_EQ(out.back().points.size(), cutter_.corners(body).size());
    }
    return out;
  }
  double volume(std::size_t body) const { return cutter_.bodies()[body].volume; }

  PolyhedronCutter cutter_;
  Pacer pacer_{kUninterrupted};
};

Mesh frame() {
  return grid_solid(
      {{{0, 1, 3, 4}, {0, 1, 3, 4}, {0, 1}}}, [](int i, int j, int) { return i != 1 || j != 1; }, 2);
}
Mesh bowl() {  // 4 x 4 x 2 with a pit of 2 x 2 x 1
  return grid_solid(
      {{{0, 1, 3, 4}, {0, 1, 3, 4}, {0, 1, 2}}},
      [](int i, int j, int k) { return i != 1 || j != 1 || k == 0; }, 2);
}

TEST_F(Cuts, ABoxGivesTwo) {
  const auto parts = cut(solid_of(box({0, 0, 0}, {1, 1, 1}, 3)), {{0, 0, 1}, 0.25});
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_NEAR(volume(0), 0.25, 1e-12);
  EXPECT_NEAR(volume(1), 0.75, 1e-12);
  EXPECT_NEAR(cutter_.cut_area(), 1, 1e-12);
}

TEST_F(Cuts, APlaneThatMissesOrTouchesGivesOne) {
  const Polyhedron solid = solid_of(box({0, 0, 0}, {1, 1, 1}, 2));
  for (const double z : {-1.0, 0.0, 1.0, 2.0}) {
    EXPECT_EQ(cut(solid, {{0, 0, 1}, z}).size(), 1u) << z;
    EXPECT_NEAR(volume(0), 1, 1e-12);
  }
}

TEST_F(Cuts, AcrossAFrameHangTogetherAsTheyLie) {
  const auto halves = cut(solid_of(frame()), {{1, 0, 0}, 2});  // two halves of a frame, with two ends each
  ASSERT_EQ(halves.size(), 2u);
  EXPECT_NEAR(volume(0), 6, 1e-12);
  EXPECT_NEAR(cutter_.cut_area(), 2, 1e-12);
  const auto quarters = cut(halves[0], {{0, 1, 0}, 2});  // the ends in one plane go to different quarters
  ASSERT_EQ(quarters.size(), 2u);
  EXPECT_NEAR(volume(0), 3, 1e-12);
  EXPECT_NEAR(volume(1), 3, 1e-12);
}

TEST_F(Cuts, AlongAnInnerFaceOfAFrameTwoBarsAreTwoBodies) {
  for (const double side : {1.0, -1.0}) {
    const auto c = cut(solid_of(frame()), {{side, 0, 0}, side * 1});
    ASSERT_EQ(c.size(), 2u);
    const std::size_t rest = volume(0) > volume(1) ? 0 : 1;
    EXPECT_NEAR(volume(1 - rest), 4, 1e-12);
    EXPECT_NEAR(volume(rest), 8, 1e-12);
    cut(c[rest], {{side, 0, 0}, side * 3});
    ASSERT_EQ(cutter_.bodies().size(), 3u);
    std::vector<double> volumes{volume(0), volume(1), volume(2)};
    std::sort(volumes.begin(), volumes.end());
    EXPECT_NEAR(volumes[0], 2, 1e-12);
    EXPECT_NEAR(volumes[1], 2, 1e-12);
    EXPECT_NEAR(volumes[2], 4, 1e-12);
  }
}

TEST_F(Cuts, ThroughTheWallOfABowlThePitStaysOpen) {
  ASSERT_EQ(cut(solid_of(bowl()), {{0, 0, 1}, 1.5}).size(), 2u);
  EXPECT_NEAR(volume(0), 16 + 6, 1e-12);
  EXPECT_NEAR(volume(1), 6, 1e-12);
  EXPECT_NEAR(cutter_.cut_area(), 12, 1e-12);
}

// Two legs, each with a pit that leads into a cavity above both. The cut goes through legs and pits.
TEST_F(Cuts, AHoleBelongsToTheBodyAroundIt) {
  const Mesh table =
      grid_solid({{{0, 1, 2, 3, 5, 6, 7, 8}, {0, 1, 2, 3}, {0, 1, 2, 3, 4, 5}}}, [](int i, int j, int k) {
        const bool is_pit = (k == 1 || k == 2) && j == 1 && (i == 1 || i == 5);
        const bool is_cavity = k == 3 && j == 1 && i >= 1 && i <= 5;
        return !is_pit && !is_cavity && (k > 1 || i != 3);
      });
  ASSERT_EQ(cut(solid_of(table), {{0, 0, 1}, 1.5}).size(), 3u);
  EXPECT_NEAR(volume(0), 9 + 4, 1e-12);
  EXPECT_NEAR(volume(1), 9 + 4, 1e-12);
  EXPECT_NEAR(volume(2), 8 + 22 + 18 + 24, 1e-12);
}

TEST_F(Cuts, AtTheBottomOfABowlThePitsFloorIsNoPartOfTheWall) {
  for (const double up : {1.0, -1.0}) {
    ASSERT_EQ(cut(solid_of(bowl()), {{0, 0, up}, up * 1}).size(), 2u);
    const std::size_t wall = up > 0 ? 1 : 0;
    EXPECT_NEAR(volume(1 - wall), 16, 1e-12);
    EXPECT_NEAR(volume(wall), 12, 1e-12);
    for (const Vec3d& p : cutter_.corners(cutter_.bodies()[wall]))
      EXPECT_FALSE(p.x > 1 && p.x < 3 && p.y > 1 && p.y < 3) << p.x << " " << p.y;
  }
}

TEST_F(Cuts, OfManyPlanesThePartsAddUp) {
  for (const Mesh& mesh : {bowl(), torus(24, 12), menger_sponge(2)}) {
    std::vector<Polyhedron> parts{solid_of(mesh)};
    const double whole = volume_of(mesh);
    const Box box = box_of(mesh);
    for (const Vec3d& direction : {Vec3d{1, 0, 0}, Vec3d{0.6, 0.8, 0}, Vec3d{0, 0.8, -0.6}, Vec3d{0, 0, 1}}) {
      std::vector<Polyhedron> next;
      for (const Polyhedron& part : parts)
        for (Polyhedron& made : cut(part, {direction, dot(direction, box.center())}))
          next.push_back(std::move(made));
      parts = std::move(next);
      double sum = 0;
      for (const Polyhedron& part : parts) sum += volume_of(part, pacer_);
      EXPECT_NEAR(sum, whole, 1e-6 * whole);
    }
    EXPECT_GE(parts.size(), 10u);
  }
}

}  // namespace
}  // namespace fracture::test
