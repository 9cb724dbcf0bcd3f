// Ragged chunks in Bullet: placed without bonds and without gravity, none of them moves by itself.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "client/world/fragments.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "common/materials/materials.hpp"
#include "tests/client/cubes.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::world {
namespace {

/// The highest speed of any piece within two seconds, m/s.
double fastest_at_rest(const Mesh& mesh, const MaterialPreset& preset) {
  FractureParameters p;
  p.pattern = preset.pattern;
  p.aggregation = preset.aggregation;
  p.anisotropy = {.stretch = preset.stretch, .grain_of = GrainOf::kPart};
  p.roughness = preset.roughness;
  p.hulls = Hulls::kConvex;
  const auto made = test::fracture_mesh(mesh, p);
  const std::vector<std::uint8_t> glb = write_glb(made, {});
  Expected<FragmentSet> set = read_fragments(std::as_bytes(std::span(glb)));
  if (!set) throw std::runtime_error(set.error().detail);
  EXPECT_EQ(set->fragments.size(), made.set.fragments.size());
  std::size_t hulls = 0;
  for (const Fragment& f : set->fragments) hulls += f.hulls.size();
  EXPECT_GT(hulls, 3 * set->fragments.size() / 2);
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
  return fastest;
}

TEST(RaggedChunks, LieStillInBulletWhereTheyAre) {
  const std::pair<const char*, Mesh> shapes[] = {{"ring", test::torus(48, 24)},
                                                 {"wall", test::box({0, 0, 0}, {2.4, 1.5, 0.24}, 4)},
                                                 {"column", test::box({0, 0, 0}, {0.5, 3, 0.5}, 4)}};
  for (const char* material : {"stone", "concrete", "metal"})
    for (const auto& [name, mesh] : shapes) {
      SCOPED_TRACE(std::string(material) + ", " + name);
      const double fastest = fastest_at_rest(mesh, *find_material_preset(material));
      EXPECT_LT(fastest, 1e-3) << "m/s";
      if (std::getenv("FRACTURE_TEST_TELL")) std::printf("%s, %s: fastest %g m/s\n", material, name, fastest);
    }
}

}  // namespace
}  // namespace fracture::world
