// Which nodes are instances, and which of them stay whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/pipeline/kept_instances.hpp"
#include "tests/instances/scenes.hpp"

namespace fracture::test {
namespace {

const Grass& tuft() {
  static const Grass grass(5);
  return grass;
}

Solid solid_at(const std::vector<Place>& places) { return solid_of_glb(tuft().glb(places)); }

std::uint32_t groups_of(const Solid& solid, std::uint32_t wanted) {
  const PartGroups groups = group_parts(solid, {}, wanted, {});
  return 1 + *std::max_element(groups.of_part.begin(), groups.of_part.end());
}
std::size_t whole_of(const Solid& solid, std::uint32_t wanted) {
  const PartGroups groups = group_parts(solid, {}, wanted, {});
  std::set<std::uint32_t> whole(groups.whole.begin(), groups.whole.end());
  whole.erase(kNoIndex);
  return whole.size();
}

TEST(Instances, HaveAllPartsOfTheirNodeAndComeFromTheLargest) {
  const Solid solid =
      solid_at({{{0, 0, 0}}, {{2, 0, 0}, about_y(1.0), {2, 2, 2}}, {{9, 1, 0}, about_y(-2.0)}});
  ASSERT_TRUE(solid.instances);
  const Instances& found = *solid.instances;
  ASSERT_EQ(found.all.size(), 3u);
  ASSERT_EQ(found.models, std::vector<std::uint32_t>{1});
  for (const Instance& instance : found.all) EXPECT_EQ(instance.parts.size(), 5u);
  EXPECT_EQ(found.all[1].from_model.scale, 1);
  EXPECT_NEAR(found.all[0].from_model.scale, 0.5, 1e-6);
  // the origin of the mesh is at (2, 0, 0) in the model and at (9, 1, 0) in the last instance
  const Vec3d moved = found.all[2].from_model.point({2, 0, 0});
  EXPECT_NEAR(length(moved - Vec3d{9, 1, 0}), 0, 1e-6);
  EXPECT_NEAR(found.all[1].volume, 8 * found.all[0].volume, 1e-5 * found.all[1].volume);
}

TEST(Instances, MirroredAndUnevenlyScaledNodesAreNone) {
  const Solid solid = solid_at(
      {{{0, 0, 0}}, {{2, 0, 0}}, {{4, 0, 0}, about_y(0), {-1, 1, 1}}, {{6, 0, 0}, about_y(0), {1, 1.01, 1}}});
  ASSERT_TRUE(solid.instances);
  ASSERT_EQ(solid.instances->all.size(), 2u);
  EXPECT_EQ(solid.instances->all[0].node, 0u);
  EXPECT_EQ(solid.instances->all[1].node, 1u);
}

TEST(Instances, ASingleNodeIsNone) { EXPECT_FALSE(solid_at({{{0, 0, 0}}}).instances); }

TEST(Instances, AreFoundAfterAChangeOfUnitAndAxes) {
  Expected<Mesh> mesh = import_text(tuft().glb(meadow(4)), MeshFormat::kGlb);
  ASSERT_TRUE(mesh);
  FrameOptions frame;
  frame.unit = LengthUnit::kCentimetre;
  frame.up = UpAxis::kZ;
  ASSERT_TRUE(to_metres_y_up(*mesh, frame));
  Expected<Solid> solid = make_solid(std::make_shared<Mesh>(std::move(*mesh)), {}, {});
  ASSERT_TRUE(solid);
  keep_instances(*solid, {});
  ASSERT_TRUE(solid->instances);
  EXPECT_EQ(solid->instances->all.size(), 4u);
}

TEST(Instances, StayWholeIfTheyAreNoLargerThanTheMeanFragment) {
  const Solid solid = solid_at({{{0, 0, 0}}, {{2, 0, 0}}, {{4, 0, 0}, about_y(0), {2, 2, 2}}});
  // volumes 1 : 1 : 8, so the mean of one fragment is 10, and that of two is 5
  EXPECT_EQ(whole_of(solid, 1), 3u);
  EXPECT_EQ(whole_of(solid, 2), 2u);
  EXPECT_EQ(groups_of(solid, 2), 2u + 5u) << "the blades of the large tuft touch nothing";
  FractureParameters separate;
  separate.instances = InstanceUse::kSeparate;
  EXPECT_TRUE(group_parts(solid, separate, 1, {}).whole.empty());
  separate = {};
  separate.parts = Parts::kApart;
  EXPECT_TRUE(group_parts(solid, separate, 1, {}).whole.empty());
}

TEST(Instances, JoinWhatTheyTouchOnlyIfThatReachesTheNumber) {
  // Two pairs of tufts that stick into each other, and one alone.
  const Solid solid =
      solid_at({{{0, 0, 0}}, {{0.001, 0, 0.001}}, {{3, 0, 0}}, {{3.001, 0, 0.001}}, {{6, 0, 0}}});
  ASSERT_TRUE(solid.instances);
  ASSERT_FALSE(solid.contacts->contacts.empty());
  EXPECT_EQ(whole_of(solid, 5), 1u) << "three groups touch nothing, and five were wanted";
  EXPECT_EQ(whole_of(solid, 2), 5u) << "joining cannot reach two";
  EXPECT_EQ(groups_of(solid, 2), 5u);
  FractureParameters unjoined;
  unjoined.parts = Parts::kInstances;
  const PartGroups groups = group_parts(solid, unjoined, 5, {});
  EXPECT_EQ(1 + *std::max_element(groups.of_part.begin(), groups.of_part.end()), 5u) << "nothing is joined";
  EXPECT_EQ(std::count(groups.whole.begin(), groups.whole.end(), kNoIndex), 0);
}

}  // namespace
}  // namespace fracture::test
