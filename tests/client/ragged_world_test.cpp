// Ragged chunks in Bullet: put where they are without bonds and without gravity, none of them moves by itself.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "client/world/fragments.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/materials/materials.hpp"
#include "tests/client/cubes.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::world {
namespace {

TEST(RaggedChunks, LieStillInBulletWhereTheyAre) {
  for (const char* material : {"stone", "concrete"}) {
    SCOPED_TRACE(material);
    const MaterialPreset& preset = *find_material_preset(material);
    FractureParameters p;
    p.pattern = preset.pattern;
    p.aggregation = preset.aggregation;
    p.roughness = preset.roughness;
    p.hulls = Hulls::kConvex;
    const auto made = test::fracture_mesh(test::torus(48, 24), p);
    const std::vector<std::uint8_t> glb = write_glb(made, {});
    Expected<FragmentSet> set = read_fragments(std::as_bytes(std::span(glb)));
    ASSERT_TRUE(set) << set.error().detail;
    ASSERT_EQ(set->fragments.size(), made.set.fragments.size());
    std::size_t hulls = 0;
    for (const Fragment& f : set->fragments) hulls += f.hulls.size();
    EXPECT_GT(hulls, 2 * set->fragments.size());
    set->bonds.clear();
    WorldSettings settings;
    settings.gravity = glm::dvec3(0);
    World world(settings);
    ObjectSpec whole = test::whole_of(*set);
    whole.pose.position = {0, 10, 0};
    const ObjectId object = world.add_object(whole);
    world.fracture(object, prepare(*set));
    double fastest = 0;
    for (int k = 0; k < 120; ++k) {
      world.step();
      fastest = std::fmax(fastest, world.census().fastest);
    }
    EXPECT_EQ(test::groups_of(world, object), made.set.fragments.size());
    EXPECT_LT(fastest, 1e-3) << "m/s";
    RecordProperty(material, std::to_string(fastest));
    if (std::getenv("FRACTURE_TEST_TELL")) std::printf("%s: fastest %g m/s\n", material, fastest);
  }
}

}  // namespace
}  // namespace fracture::world
