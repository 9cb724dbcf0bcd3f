// From files to scenes, without a display.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/render/scene.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "tests/client/scenes.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using render::read_scene;
using render::RenderErrorCode;
using render::Result;
using render::Scene;

Result<Scene> read(const std::string& text) { return read_scene(std::as_bytes(std::span(text))); }
Result<Scene> read(const std::vector<std::uint8_t>& bytes) {
  return read_scene(std::as_bytes(std::span(bytes)));
}

GltfPrimitive triangle() {
  GltfPrimitive p;
  p.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  p.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  p.indices = {0, 1, 2};
  return p;
}

glm::vec3 world(const Scene& scene, std::uint32_t index) {
  const render::Vertex& v = scene.vertices[scene.indices[index]];
  return glm::vec3(scene.objects[v.object].transform * glm::vec4(v.position, 1));
}

TEST(LoadScene, FragmentsOfTheServiceKeepIdsPlacesAndTheInteriorMaterial) {
  const FracturedSolid made = two_halves_with_hulls();
  const auto scene = read(write_glb(made, {}));
  ASSERT_TRUE(scene) << scene.error().detail;
  ASSERT_EQ(scene->objects.size(), 2u);  // neither hulls nor the root
  for (std::size_t k = 0; k < 2; ++k) {
    ASSERT_TRUE(scene->objects[k].fragment);
    EXPECT_EQ(scene->objects[k].fragment->id, made.set.fragments[k].id);
    EXPECT_DOUBLE_EQ(scene->objects[k].fragment->volume, made.set.fragments[k].mass.volume);
  }
  ASSERT_EQ(scene->materials.size(), 4u);  // wood, paint, interior, glTF's default
  EXPECT_FALSE(scene->materials[0].interior);
  EXPECT_FALSE(scene->materials[1].interior);
  EXPECT_TRUE(scene->materials[2].interior);
  EXPECT_FALSE(scene->materials[3].interior);
  // The box [0,2] x [0,1] x [0,1], cut at x = 1: that is where the interior surfaces are.
  const render::Sphere sphere = bounding_sphere(*scene, {});
  EXPECT_NEAR(glm::distance(sphere.center, glm::vec3(1, 0.5, 0.5)), 0, 1e-6);
  EXPECT_NEAR(sphere.radius, std::sqrt(6.0) / 2, 1e-6);
  std::size_t interior = 0;
  for (const render::Surface& s : scene->surfaces)
    for (std::uint32_t i = s.first_index; s.material == 2 && i < s.first_index + s.index_count;
         ++i, ++interior)
      EXPECT_FLOAT_EQ(world(*scene, i).x, 1.f);
  EXPECT_EQ(interior, 12u);  // two caps of two triangles
}

TEST(LoadScene, UnrealHullsAreNotShown) {
  GltfOptions options;
  options.ue_collision = UeCollision::kUcx;
  const auto scene = read(write_glb(two_halves_with_hulls(), options));
  ASSERT_TRUE(scene) << scene.error().detail;
  EXPECT_EQ(scene->objects.size(), 2u);
}

TEST(LoadScene, SurfacesAreSortedByMaterialAndCoverTheIndices) {
  const auto scene = read(write_glb(two_halves(), {}));
  ASSERT_TRUE(scene);
  std::uint32_t next = 0, material = 0;
  for (const render::Surface& s : scene->surfaces) {
    EXPECT_EQ(s.first_index, next);
    EXPECT_GE(s.material, material);
    next += s.index_count;
    material = s.material;
  }
  EXPECT_EQ(next, scene->indices.size());
}

TEST(LoadScene, WithoutNormalsTheyAreFlat) {
  GltfPrimitive p = triangle();
  p.normals.clear();
  for (const bool mirrored : {false, true}) {
    const auto scene = read(gltf_text({p}, {{"scale", {mirrored ? -1 : 1, 1, 1}}}));
    ASSERT_TRUE(scene) << scene.error().detail;
    for (const std::uint32_t index : scene->indices)
      EXPECT_EQ(scene->vertices[index].normal, glm::vec3(0, 0, 1));
  }
}

TEST(LoadScene, MirroredNodesTurnTheirTriangles) {
  const auto scene = read(gltf_text({triangle()}, {{"scale", {-1, 1, 1}}}));
  ASSERT_TRUE(scene) << scene.error().detail;
  const glm::vec3 n = glm::cross(world(*scene, 1) - world(*scene, 0), world(*scene, 2) - world(*scene, 0));
  EXPECT_EQ(n, glm::vec3(0, 0, 1));  // still seen from +z
}

TEST(LoadScene, StripsAndFansBecomeTriangles) {
  GltfPrimitive strip;
  strip.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  strip.mode = 5;
  GltfPrimitive fan = strip;
  std::swap(fan.positions[2], fan.positions[3]);
  fan.mode = 6;
  for (const GltfPrimitive& p : {strip, fan}) {
    const auto scene = read(gltf_text({p}));
    ASSERT_TRUE(scene) << scene.error().detail;
    ASSERT_EQ(scene->indices.size(), 6u);
    float area = 0;
    for (std::uint32_t t = 0; t < 6; t += 3) {
      const glm::vec3 n =
          glm::cross(world(*scene, t + 1) - world(*scene, t), world(*scene, t + 2) - world(*scene, t));
      EXPECT_GT(n.z, 0);
      area += 0.5f * n.z;
    }
    EXPECT_FLOAT_EQ(area, 1);
  }
}

TEST(LoadScene, ARefusalSaysWhatAndWhere) {
  const auto expect = [](const Result<Scene>& scene, RenderErrorCode code, const char* words) {
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().code, code);
    EXPECT_THAT(scene.error().detail, testing::HasSubstr(words));
  };
  GltfPrimitive p = triangle();
  p.positions[1].y = std::nanf("");
  expect(read(gltf_text({p})), RenderErrorCode::kMesh, "not-finite: POSITION of vertex 1");
  p = triangle();
  p.indices[2] = 3;
  expect(read(gltf_text({p})), RenderErrorCode::kMesh, "names vertex 3; there are 3");
  p = triangle();
  p.mode = 1;
  expect(read(gltf_text({p})), RenderErrorCode::kMesh, "shows no triangle");
  expect(read(std::string("no glTF")), RenderErrorCode::kMesh, "malformed-mesh");
  expect(read(std::string()), RenderErrorCode::kMesh, "malformed-mesh");
  expect(
      read(gltf_text({triangle()}, nlohmann::json::object(), {{"extensionsRequired", {"EXT_unheard_of"}}})),
      RenderErrorCode::kMesh, "EXT_unheard_of");
  expect(read(gltf_text({triangle()}, nlohmann::json::object(),
                        {{"materials", {{{"pbrMetallicRoughness", {{"roughnessFactor", "rough"}}}}}}})),
         RenderErrorCode::kMesh, "wrong type");
  const auto missing = render::load_scene("/nowhere/at_all.glb");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, RenderErrorCode::kFile);
}

TEST(LoadScene, DamagedFilesNeverCrash) {
  const std::vector<std::uint8_t> good = write_glb(two_halves_with_hulls(), {});
  std::size_t refused = 0;
  for (std::size_t size = 0; size < good.size(); size += 97) {
    const auto scene =
        read(std::vector<std::uint8_t>(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
    EXPECT_FALSE(scene) << "cut at " << size;
    refused += !scene;
  }
  EXPECT_GT(refused, 10u);
  std::mt19937 random(20261121);
  for (int k = 0; k < 400; ++k) {
    std::vector<std::uint8_t> bytes = good;
    for (int flips = 0; flips < 3; ++flips)
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    if (const auto scene = read(bytes)) {
      for (const std::uint32_t index : scene->indices)
        ASSERT_LT(index, scene->vertices.size()) << "round " << k;
      for (const render::Vertex& v : scene->vertices)
        ASSERT_LT(v.object, scene->objects.size()) << "round " << k;
    } else {
      EXPECT_FALSE(scene.error().detail.empty());
    }
  }
}

TEST(LoadScene, MaterialsAreReadAndWhatCannotBeShownIsSaid) {
  const nlohmann::json document = {
      {"materials",
       {{{"name", "pane"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.5}, {"roughnessFactor", 0.25}}},
         {"emissiveFactor", {1, 0.5, 0}},
         {"alphaMode", "MASK"},
         {"alphaCutoff", 0.75},
         {"doubleSided", true},
         {"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}},
           {"KHR_materials_clearcoat", {{"clearcoatFactor", 1}}}}}}}},
      {"extensionsUsed", {"KHR_materials_transmission", "KHR_materials_clearcoat"}}};
  GltfPrimitive p = triangle();
  p.material = 0;
  const auto scene = read(gltf_text({p}, nlohmann::json::object(), document));
  ASSERT_TRUE(scene) << scene.error().detail;
  const render::Material& m = scene->materials[0];
  EXPECT_EQ(m.name, "pane");
  EXPECT_EQ(m.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_FLOAT_EQ(m.metallic, 0.5f);
  EXPECT_FLOAT_EQ(m.roughness, 0.25f);
  EXPECT_EQ(m.emissive, glm::vec3(1, 0.5f, 0));
  EXPECT_EQ(m.alpha_mode, render::AlphaMode::kMask);
  EXPECT_FLOAT_EQ(m.alpha_cutoff, 0.75f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_FLOAT_EQ(m.transmission, 0.9f);
  EXPECT_THAT(scene->warnings, testing::Contains(testing::HasSubstr("KHR_materials_clearcoat")));
  EXPECT_THAT(scene->warnings,
              testing::Not(testing::Contains(testing::HasSubstr("KHR_materials_transmission"))));
}

}  // namespace
}  // namespace fracture::test
