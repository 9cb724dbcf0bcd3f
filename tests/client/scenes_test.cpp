// Built-in meshes and scenes, as values.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "client/scenes/scene.hpp"

namespace fracture::scenes {
namespace {

/// Number of edges without a partner in the opposite direction; 0 if the mesh is closed and consistently
/// oriented.
std::size_t open_edges(const SurfaceMesh& mesh) {
  using Point = std::array<float, 3>;
  std::map<std::pair<Point, Point>, int> edges;
  const auto point = [&](std::uint32_t v) {
    return Point{mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z};
  };
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{point(t[k]), point(t[(k + 1) % 3])}];
  std::size_t open = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    open += back == edges.end() || back->second != count;
  }
  return open;
}

double volume(const SurfaceMesh& mesh) { return world::solid_mass(mesh.positions, mesh.triangles, 1).mass; }

TEST(SolidShapes, ABoxIsClosedAndHasItsVolume) {
  EXPECT_EQ(open_edges(box({2, 3, 4})), 0u);
  EXPECT_NEAR(volume(box({2, 3, 4})), 24, 1e-5);
  EXPECT_EQ(open_edges(box({2, 3, 4}, 0.25f)), 0u);
  EXPECT_LT(volume(box({2, 3, 4}, 0.25f)), 24);
  EXPECT_GT(volume(box({2, 3, 4}, 0.25f)), 22);
}

TEST(SolidShapes, ACrateIsClosedAndHollow) {
  const SurfaceMesh mesh = crate(1, 0.1f, 0.05f, 0.1f);
  EXPECT_EQ(open_edges(mesh), 0u);
  // The cube minus the six panels and the cavity.
  EXPECT_NEAR(volume(mesh), 1 - 6 * 0.8 * 0.8 * 0.05 - 0.8 * 0.8 * 0.8, 1e-5);
}

TEST(SolidShapes, WhatIsTurnedIsClosed) {
  Turned cylinder;
  cylinder.profile = {{1, 0}, {1, 2}};
  cylinder.segments = 64;
  EXPECT_EQ(open_edges(turned(cylinder)), 0u);
  const double angle = 2 * 3.14159265358979 / 64;
  EXPECT_NEAR(volume(turned(cylinder)), 2 * 64 * 0.5 * std::sin(angle), 1e-4);
  cylinder.flutes = 16;
  cylinder.groove = 0.1f;
  cylinder.fluted_to = 2;
  EXPECT_EQ(open_edges(turned(cylinder)), 0u);
  EXPECT_LT(volume(turned(cylinder)), 6);
}

class Scenes : public testing::TestWithParam<std::string> {};

TEST_P(Scenes, StandOnTheGroundWithinTheirBounds) {
  const Expected<Scene> scene = make_scene(GetParam());
  ASSERT_TRUE(scene) << scene.error().detail;
  EXPECT_EQ(scene->name, GetParam());
  ASSERT_FALSE(scene->objects.empty());
  for (const SceneObject& object : scene->objects) {
    EXPECT_GT(object.density * object.mesh->unit_mass.mass, 0.1) << object.name;
    EXPECT_GT(object.strength, 0);
    for (const world::Hull& hull : object.mesh->hulls)
      for (const glm::dvec3& p : hull) {
        const glm::dvec3 at = object.pose.point(p);
        EXPECT_GT(at.y, -1e-3) << object.name;
        EXPECT_LT(glm::distance(at, glm::dvec3(scene->bounds.center)), scene->bounds.radius) << object.name;
      }
    const nlohmann::json asked = fracture_parameters(object, {{0, 0, 0}, {0, -1, 0}, 10, 100}, 7, {});
    EXPECT_EQ(asked["seed"], 7);
    EXPECT_LE(asked.dump().size(), 4096u);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Scenes, testing::ValuesIn(scene_names()),
                         [](const auto& scene) { return scene.param; });

TEST(View, ComesCloserAndStaysThere) {
  Scene scene;
  scene.eye = {0, 2, 8};
  scene.target = {0, 1, 0};
  EXPECT_EQ(view_at(scene, 5).eye, scene.eye);
  scene.closer = {1, 3, {{0, 1, 4}, {1, 0, 0}}};
  EXPECT_EQ(view_at(scene, 0.9).eye, scene.eye);
  EXPECT_EQ(view_at(scene, 2).eye, glm::vec3(0, 1.5f, 6));
  EXPECT_EQ(view_at(scene, 2).target, glm::vec3(0.5f, 0.5f, 0));
  EXPECT_EQ(view_at(scene, 30).eye, glm::vec3(0, 1, 4));
  EXPECT_EQ(view_at(scene, 30).target, glm::vec3(1, 0, 0));
}

// The picture's field of view: 50 degrees high, 16 to 9.
TEST(View, HasAllOfTheMonkeyUntilItLands) {
  const Scene scene = make_scene("monkey").value();
  const SceneObject& monkey = scene.objects.at(0);
  const glm::mat4 projection = glm::perspective(glm::radians(50.f), 16.f / 9, 0.05f, 300.f);
  for (double t = 0; t <= 0.72; t += 0.04) {
    const View view = view_at(scene, t);
    const glm::mat4 matrix = projection * glm::lookAt(view.eye, view.target, glm::vec3(0, 1, 0));
    for (const world::Hull& hull : monkey.mesh->hulls)  // together they contain the whole mesh
      for (const glm::dvec3& point : hull) {
        const glm::dvec3 fallen = monkey.pose.point(point) - glm::dvec3(0, 0.5 * 9.81 * t * t, 0);
        const glm::vec4 seen = matrix * glm::vec4(glm::vec3(fallen), 1);
        EXPECT_LT(std::fabs(seen.x / seen.w), 1) << t;
        EXPECT_LT(std::fabs(seen.y / seen.w), 1) << t;
      }
  }
}

TEST(Scene, AnUnknownOneIsRefusedByName) {
  const Expected<Scene> scene = make_scene("castle");
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().detail.find("castle"), std::string::npos);
}

TEST(Scene, AMaterialIsForEverythingAndKeepsTheAnchors) {
  Expected<Scene> scene = make_scene("panes");
  ASSERT_TRUE(scene);
  for (const std::string& material : material_names()) {
    set_material(*scene, material);
    for (const SceneObject& object : scene->objects) {
      EXPECT_EQ(object.breakage.parameters["material"], material);
      EXPECT_TRUE(object.breakage.parameters.contains("anchor_points"));
    }
  }
}

TEST(PreparationQuery, HasTheMaterialsOfParts) {
  Expected<Scene> scene = make_scene("panes");
  ASSERT_TRUE(scene);
  set_material(*scene, "wood");
  const SceneObject& object = scene->objects[0];
  const std::string plain = preparation_query(object, nlohmann::json::object());
  EXPECT_EQ(plain.find("assign"), std::string::npos);
  EXPECT_EQ(preparation_query(object, {{"assign", "Window_*:glass"}}), plain + "&assign=Window_%2A%3Aglass");
  nlohmann::json entry;
  entry["node"] = "W";
  entry["material"] = "glass";
  nlohmann::json listed;
  listed["assign"] = nlohmann::json::array({entry});
  EXPECT_EQ(preparation_query(object, listed),
            plain + "&assign=%5B%7B%22material%22%3A%22glass%22%2C%22node%22%3A%22W%22%7D%5D");
  listed["assign"] = std::string(5000, 'x') + ":glass";
  EXPECT_EQ(preparation_query(object, listed), plain) << "the request would be refused";
}

TEST(FractureParameters, GrowWithTheEnergy) {
  SceneObject object;
  object.breakage = {{{"material", "stone"}}, true, true, 80, 0.5, 1000};
  const auto at = [&](double energy) {
    return fracture_parameters(object, {{0.1, 0.2, 0.3}, {0, 0, -1}, 10, energy}, 1, {});
  };
  EXPECT_EQ(at(1000)["sites"], 80);
  EXPECT_NEAR(at(1000)["radius"].get<double>(), 0.5, 1e-9);
  EXPECT_EQ(at(8000)["sites"], 160);  // the cube root of 8 is 2
  EXPECT_NEAR(at(8000)["radius"].get<double>(), 1, 1e-9);
  EXPECT_EQ(at(1e9)["sites"], 160);  // limited
  EXPECT_EQ(at(0)["sites"], 48);
  EXPECT_EQ(at(1000)["impacts"].dump(), "[[0.1,0.2,0.3]]");
}

TEST(FractureParameters, ThePanelHasTheLastWord) {
  SceneObject object;
  object.breakage = {{{"material", "ceramic"}}, true, true, 80, 0.5, 1000};
  const nlohmann::json asked =
      fracture_parameters(object, {}, 1, {{"pattern", "slice"}, {"sites", 5}, {"spacing", 0.1}});
  EXPECT_EQ(asked["pattern"], "slice");
  EXPECT_EQ(asked["sites"], 5);
  EXPECT_FALSE(asked.contains("impacts"));  // the pattern slice takes no impacts
  EXPECT_FALSE(asked.contains("radius"));
}

}  // namespace
}  // namespace fracture::scenes
