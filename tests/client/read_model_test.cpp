// From files to models, without a display.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/render/model.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "tests/client/models.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using render::Model;
using render::read_model;

Expected<Model> read(const std::string& text) { return read_model(std::as_bytes(std::span(text))); }
Expected<Model> read(const std::vector<std::uint8_t>& bytes) {
  return read_model(std::as_bytes(std::span(bytes)));
}

GltfPrimitive triangle() {
  GltfPrimitive p;
  p.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  p.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  p.indices = {0, 1, 2};
  return p;
}

glm::vec3 world(const Model& model, std::uint32_t index) {
  const render::Vertex& v = model.vertices[model.indices[index]];
  return glm::vec3(model.objects[v.object].transform * glm::vec4(v.position, 1));
}

TEST(ReadModel, FragmentsOfTheServiceKeepIdsPlacesAndTheInteriorMaterial) {
  const FracturedSolid made = two_halves_with_hulls();
  const auto model = read(write_glb(made, {}));
  ASSERT_TRUE(model) << model.error().detail;
  ASSERT_EQ(model->objects.size(), 2u);  // neither hulls nor the root
  for (std::size_t k = 0; k < 2; ++k) {
    ASSERT_TRUE(model->objects[k].fragment);
    EXPECT_EQ(model->objects[k].fragment->id, made.set.fragments[k].id);
    EXPECT_DOUBLE_EQ(model->objects[k].fragment->volume, made.set.fragments[k].mass.volume);
  }
  ASSERT_EQ(model->materials.size(), 4u);  // wood, paint, interior, and glTF's default
  EXPECT_FALSE(model->materials[0].interior);
  EXPECT_FALSE(model->materials[1].interior);
  EXPECT_TRUE(model->materials[2].interior);
  EXPECT_FALSE(model->materials[3].interior);
  // The box [0,2] x [0,1] x [0,1], cut at x = 1, where the interior surfaces are.
  const render::Sphere sphere = bounding_sphere(*model, {});
  EXPECT_NEAR(glm::distance(sphere.center, glm::vec3(1, 0.5, 0.5)), 0, 1e-6);
  EXPECT_NEAR(sphere.radius, std::sqrt(6.0) / 2, 1e-6);
  std::size_t interior = 0;
  for (const render::Surface& s : model->surfaces)
    for (std::uint32_t i = s.first_index; s.material == 2 && i < s.first_index + s.index_count;
         ++i, ++interior)
      EXPECT_FLOAT_EQ(world(*model, i).x, 1.f);
  EXPECT_EQ(interior, 12u);  // two caps of two triangles
}

TEST(ReadModel, UnrealHullsAreNotShown) {
  GltfOptions options;
  options.ue_collision = UeCollision::kUcx;
  const auto model = read(write_glb(two_halves_with_hulls(), options));
  ASSERT_TRUE(model) << model.error().detail;
  EXPECT_EQ(model->objects.size(), 2u);
}

TEST(ReadModel, SurfacesAreSortedByMaterialAndCoverTheIndices) {
  const auto model = read(write_glb(two_halves(), {}));
  ASSERT_TRUE(model);
  std::uint32_t next = 0, material = 0;
  for (const render::Surface& s : model->surfaces) {
    EXPECT_EQ(s.first_index, next);
    EXPECT_GE(s.material, material);
    next += s.index_count;
    material = s.material;
  }
  EXPECT_EQ(next, model->indices.size());
}

TEST(ReadModel, WithoutNormalsTheyAreFlat) {
  GltfPrimitive p = triangle();
  p.normals.clear();
  for (const bool mirrored : {false, true}) {
    const auto model = read(gltf_text({p}, {{"scale", {mirrored ? -1 : 1, 1, 1}}}));
    ASSERT_TRUE(model) << model.error().detail;
    for (const std::uint32_t index : model->indices)
      EXPECT_EQ(model->vertices[index].normal, glm::vec3(0, 0, 1));
  }
}

TEST(ReadModel, MirroredNodesTurnTheirTriangles) {
  const auto model = read(gltf_text({triangle()}, {{"scale", {-1, 1, 1}}}));
  ASSERT_TRUE(model) << model.error().detail;
  const glm::vec3 n = glm::cross(world(*model, 1) - world(*model, 0), world(*model, 2) - world(*model, 0));
  EXPECT_EQ(n, glm::vec3(0, 0, 1));  // still seen from +z
}

TEST(ReadModel, StripsAndFansBecomeTriangles) {
  GltfPrimitive strip;
  strip.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  strip.mode = 5;
  GltfPrimitive fan = strip;
  std::swap(fan.positions[2], fan.positions[3]);
  fan.mode = 6;
  for (const GltfPrimitive& p : {strip, fan}) {
    const auto model = read(gltf_text({p}));
    ASSERT_TRUE(model) << model.error().detail;
    ASSERT_EQ(model->indices.size(), 6u);
    float area = 0;
    for (std::uint32_t t = 0; t < 6; t += 3) {
      const glm::vec3 n =
          glm::cross(world(*model, t + 1) - world(*model, t), world(*model, t + 2) - world(*model, t));
      EXPECT_GT(n.z, 0);
      area += 0.5f * n.z;
    }
    EXPECT_FLOAT_EQ(area, 1);
  }
}

TEST(ReadModel, ARefusalSaysWhatAndWhere) {
  const auto expect = [](const Expected<Model>& model, ErrorCode code, const char* words) {
    ASSERT_FALSE(model);
    EXPECT_EQ(model.error().code, code);
    EXPECT_THAT(model.error().detail, testing::HasSubstr(words));
  };
  GltfPrimitive p = triangle();
  p.positions[1].y = std::nanf("");
  expect(read(gltf_text({p})), ErrorCode::kNotFinite, "POSITION of vertex 1");
  p = triangle();
  p.indices[2] = 3;
  expect(read(gltf_text({p})), ErrorCode::kMalformedMesh, "refers to vertex 3, but there are 3");
  p = triangle();
  p.mode = 1;
  expect(read(gltf_text({p})), ErrorCode::kEmptyMesh, "contains no triangles");
  expect(read(std::string("no glTF")), ErrorCode::kMalformedMesh, "glTF");
  expect(read(std::string()), ErrorCode::kMalformedMesh, "glTF");
  expect(
      read(gltf_text({triangle()}, nlohmann::json::object(), {{"extensionsRequired", {"EXT_unheard_of"}}})),
      ErrorCode::kUnsupportedFeature, "EXT_unheard_of");
  expect(read(gltf_text({triangle()}, nlohmann::json::object(),
                        {{"materials", {{{"pbrMetallicRoughness", {{"roughnessFactor", "rough"}}}}}}})),
         ErrorCode::kMalformedMesh, "wrong type");
  const auto missing = render::load_model("/nowhere/at_all.glb");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kFileAccess);
}

TEST(ReadModel, DamagedFilesNeverCrash) {
  const std::vector<std::uint8_t> good = write_glb(two_halves_with_hulls(), {});
  std::size_t refused = 0;
  for (std::size_t size = 0; size < good.size(); size += 97) {
    const auto model =
        read(std::vector<std::uint8_t>(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
    EXPECT_FALSE(model) << "cut at " << size;
    refused += !model;
  }
  EXPECT_GT(refused, 10u);
  std::mt19937 random(20261121);
  for (int k = 0; k < 400; ++k) {
    std::vector<std::uint8_t> bytes = good;
    for (int flips = 0; flips < 3; ++flips)
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    if (const auto model = read(bytes)) {
      for (const std::uint32_t index : model->indices)
        ASSERT_LT(index, model->vertices.size()) << "round " << k;
      for (const render::Vertex& v : model->vertices)
        ASSERT_LT(v.object, model->objects.size()) << "round " << k;
    } else {
      EXPECT_FALSE(model.error().detail.empty());
    }
  }
}

TEST(ReadModel, MaterialsAreReadAndWhatCannotBeShownIsSaid) {
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
  const auto model = read(gltf_text({p}, nlohmann::json::object(), document));
  ASSERT_TRUE(model) << model.error().detail;
  const render::Material& m = model->materials[0];
  EXPECT_EQ(m.name, "pane");
  EXPECT_EQ(m.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_FLOAT_EQ(m.metallic, 0.5f);
  EXPECT_FLOAT_EQ(m.roughness, 0.25f);
  EXPECT_EQ(m.emissive, glm::vec3(1, 0.5f, 0));
  EXPECT_EQ(m.alpha_mode, render::AlphaMode::kMask);
  EXPECT_FLOAT_EQ(m.alpha_cutoff, 0.75f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_FLOAT_EQ(m.transmission, 0.9f);
  EXPECT_THAT(model->warnings, testing::Contains(testing::HasSubstr("KHR_materials_clearcoat")));
  EXPECT_THAT(model->warnings,
              testing::Not(testing::Contains(testing::HasSubstr("KHR_materials_transmission"))));
}

}  // namespace
}  // namespace fracture::test
