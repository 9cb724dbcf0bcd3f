// The unbroken solid as a second scene, next to the fragments that it breaks into.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/import/import.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/physics/bent_shapes.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

constexpr const char* kRigidBodies = "KHR_physics_rigid_bodies";

/// A sphere with texture coordinates, next to a square frame.
Mesh sphere_and_frame() {
  Mesh frame = grid_solid({{{2, 2.2, 3.8, 4}, {-1, -0.8, 0.8, 1}, {-0.05, 0.05}}},
                          [](int i, int j, int) { return i != 1 || j != 1; });
  return joined({sphere_with_seams(8, 16), frame});
}

Fractured made_of(const Mesh& mesh, bool intact) {
  FractureParameters p;
  p.pattern = PointsPattern{{{-0.5, 0, 0}, {0.5, 0, 0}, {3, 0, 0}}};
  p.hulls = Hulls::kConvex;
  p.intact = intact;
  return fracture_mesh(mesh, p);
}

Glb written(const Fractured& made, GltfOptions options = {}) { return Glb(write_glb(made, options)); }

const json& intact_root(const Glb& file) {
  return file.document["nodes"].at(file.document["scenes"].at(1)["nodes"].at(0).get<std::size_t>());
}
std::vector<json> parts(const Glb& file) {
  std::vector<json> nodes;
  for (const json& index : intact_root(file)["children"])
    nodes.push_back(file.document["nodes"].at(index.get<std::size_t>()));
  return nodes;
}

using Triangle = std::array<std::array<float, 3>, 3>;

Triangle triangle(const std::vector<Vec3f>& points, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  Triangle t;
  std::size_t corner = 0;
  for (const std::uint32_t v : {a, b, c}) t[corner++] = {points[v].x, points[v].y, points[v].z};
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());  // the lowest corner first
  return t;
}

std::multiset<Triangle> triangles_of(const Glb& file, const json& node) {
  std::multiset<Triangle> triangles;
  for (const json& p : file.document["meshes"].at(node["mesh"].get<std::size_t>())["primitives"]) {
    const auto points = file.read<Vec3f>(p["attributes"]["POSITION"]);
    const auto corners = file.read<std::uint16_t>(p["indices"]);
    for (std::size_t t = 0; t < corners.size(); t += 3)
      triangles.insert(triangle(points, corners[t], corners[t + 1], corners[t + 2]));
  }
  return triangles;
}

TEST(IntactScene, IsTheSecondOfTwoAndNotTheDefault) {
  const Glb file = written(made_of(sphere_and_frame(), true));
  EXPECT_EQ(file.document["scene"], 0);
  ASSERT_EQ(file.document["scenes"].size(), 2u);
  EXPECT_EQ(file.document["scenes"][1]["name"], "Intact");
  EXPECT_EQ(intact_root(file)["name"], "Intact");
  EXPECT_EQ(parts(file).size(), 2u);
  std::set<std::string> names;
  for (const json& node : file.document["nodes"]) EXPECT_TRUE(names.insert(node["name"]).second) << node;
  for (const json& part : parts(file)) {
    EXPECT_FALSE(part["extras"].contains("fracture")) << "readers know fragments by it";
    for (const char* key : {"translation", "rotation", "scale", "matrix"}) EXPECT_FALSE(part.contains(key));
  }
}

TEST(IntactScene, HasTheTrianglesOfTheSource) {
  const Mesh mesh = sphere_and_frame();
  const Glb file = written(made_of(mesh, true));
  std::multiset<Triangle> given, found;
  for (const auto& t : mesh.triangles) given.insert(triangle(mesh.positions, t[0], t[1], t[2]));
  for (const json& part : parts(file)) found.merge(triangles_of(file, part));
  EXPECT_EQ(given, found);
}

TEST(IntactScene, HasTheAttributesOfTheSource) {
  const Mesh mesh = sphere_with_seams(8, 16);
  ASSERT_FALSE(mesh.attributes.uvs.empty());
  const Glb file = written(made_of(mesh, true));
  ASSERT_EQ(parts(file).size(), 1u);
  const json& p = file.document["meshes"].at(parts(file)[0]["mesh"].get<std::size_t>())["primitives"][0];
  std::set<std::array<float, 2>> given, found;
  for (const auto& t : mesh.triangles) {
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    if (a == b || b == c || c == a) continue;  // at the poles
    for (const std::uint32_t v : t) given.insert({mesh.attributes.uvs[0][v].x, mesh.attributes.uvs[0][v].y});
  }
  for (const Vec2f& uv : file.read<Vec2f>(p["attributes"]["TEXCOORD_0"])) found.insert({uv.x, uv.y});
  EXPECT_EQ(given, found);
}

TEST(IntactScene, PartsHaveCollidersThatDoNotMove) {
  GltfOptions options;
  options.density = 500;
  const Fractured made = made_of(sphere_and_frame(), true);
  const Glb file = written(made, options);
  const std::vector<json> nodes = parts(file);
  ASSERT_EQ(nodes.size(), 2u);
  EXPECT_FALSE(nodes[0].contains("children")) << "a sphere has one hull";
  EXPECT_TRUE(nodes[0]["extensions"][kRigidBodies]["collider"]["geometry"]["convexHull"]);
  ASSERT_EQ(nodes[1]["children"].size(), 4u) << "a frame has one for each bar";
  std::set<std::size_t> meshes{nodes[0]["extensions"][kRigidBodies]["collider"]["geometry"]["mesh"]};
  for (const json& child : nodes[1]["children"]) {
    const json& node = file.document["nodes"].at(child.get<std::size_t>());
    meshes.insert(node["extensions"][kRigidBodies]["collider"]["geometry"]["mesh"].get<std::size_t>());
    EXPECT_FALSE(node["extensions"][kRigidBodies].contains("motion"));
  }
  EXPECT_EQ(meshes.size(), 5u);
  for (const json& node : nodes) {
    const json extensions = node.value("extensions", json::object());
    EXPECT_FALSE(extensions.value(kRigidBodies, json::object()).contains("motion"));
    EXPECT_NEAR(node["extras"]["intact"]["mass"].get<double>(),
                500 * node["extras"]["intact"]["volume"].get<double>(), 1e-6);
  }
  EXPECT_NEAR(nodes[1]["extras"]["intact"]["volume"].get<double>(), 0.1 * 4 * 0.36, 1e-6);
}

TEST(IntactScene, TheOtherFormatsOfPhysicsHaveItsHullsToo) {
  GltfOptions options;
  options.physics = Physics::kOmi;
  options.ue_collision = UeCollision::kUcx;
  const Fractured made = made_of(sphere_and_frame(), true);
  const Glb file = written(made, options);
  const json& shapes = file.document["extensions"]["OMI_physics_shape"]["shapes"];
  EXPECT_EQ(shapes.size(), made.report.hulls->hulls + 5);
  const std::vector<json> nodes = parts(file);
  ASSERT_EQ(nodes[1]["children"].size(), 8u);
  for (std::size_t k = 0; k < 4; ++k) {
    const json& collider = file.document["nodes"].at(nodes[1]["children"][k].get<std::size_t>());
    const json& ucx = file.document["nodes"].at(nodes[1]["children"][k + 4].get<std::size_t>());
    const std::size_t shape = collider["extensions"]["OMI_physics_body"]["collider"]["shape"];
    EXPECT_EQ(shapes.at(shape)["convex"]["mesh"], ucx["mesh"]);
    EXPECT_EQ(ucx["name"], "UCX_" + nodes[1]["name"].get<std::string>() + "_0" + std::to_string(k));
  }
  EXPECT_EQ(nodes[0]["children"].size(), 1u);
}

TEST(IntactScene, ChangesNothingOfTheFragments) {
  const Mesh mesh = sphere_and_frame();
  const Glb with = written(made_of(mesh, true)), without = written(made_of(mesh, false));
  EXPECT_EQ(without.document["scenes"].size(), 1u);
  for (const char* array : {"nodes", "meshes"})
    for (std::size_t k = 0; k < without.document[array].size(); ++k)
      EXPECT_EQ(with.document[array].at(k), without.document[array][k]) << array << " " << k;
}

TEST(IntactScene, ReadersOfTheDefaultSceneDoNotSeeIt) {
  const Mesh mesh = sphere_and_frame();
  const auto read = [&](bool intact) {
    const std::vector<std::uint8_t> glb = write_glb(made_of(mesh, intact), {});
    return import_mesh(std::as_bytes(std::span(glb)), MeshFormat::kGlb, {}).value();
  };
  const Mesh with = read(true), without = read(false);
  EXPECT_EQ(with.positions, without.positions);
  EXPECT_EQ(with.triangles, without.triangles);
  EXPECT_EQ(with.material, without.material);
  EXPECT_EQ(with.node_names, without.node_names);
}

/// Collision geometry of the first node.
GivenHull hull_of_first_node(const Mesh& shape) {
  return {"UCX_a_00", std::make_shared<const std::vector<std::uint32_t>>(1, 0u), true, shape.positions,
          shape.triangles};
}

/// The points of each collider of a part.
std::vector<std::set<std::array<float, 3>>> colliders_of(const Glb& file, const json& part) {
  std::vector<json> nodes{part};
  for (const json& child : part.value("children", json::array()))
    nodes.push_back(file.document["nodes"].at(child.get<std::size_t>()));
  std::vector<std::set<std::array<float, 3>>> colliders;
  for (const json& node : nodes) {
    if (!node.contains("extensions")) continue;
    const json hull{{"mesh", node["extensions"][kRigidBodies]["collider"]["geometry"]["mesh"]}};
    auto& points = colliders.emplace_back();
    for (const Triangle& t : triangles_of(file, hull)) points.insert(t.begin(), t.end());
  }
  return colliders;
}

TEST(IntactScene, CollidersAreTheGivenOnesIfTheSourceHasAny) {
  Mesh mesh = box({0.25, 0, 0}, {1.25, 1, 1});
  const std::vector<Mesh> shapes{box({0.125, 0, 0}, {0.75, 1, 1}), box({0.75, 0, 0}, {1.5, 1, 1})};
  for (const Mesh& shape : shapes) mesh.given_hulls.push_back(hull_of_first_node(shape));
  const Fractured made = made_of(mesh, true);
  const Glb file = written(made);
  ASSERT_EQ(parts(file).size(), 1u);
  const auto colliders = colliders_of(file, parts(file)[0]);
  ASSERT_EQ(colliders.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    std::set<std::array<float, 3>> corners;
    for (const Vec3f& p : shapes[k].positions) corners.insert({p.x, p.y, p.z});
    EXPECT_EQ(colliders[k], corners);
  }
  EXPECT_FALSE(warns(made.report, "UCX_a_00"));
}

TEST(IntactScene, GivenCollidersStandForAllPartsOfTheirNode) {
  Mesh mesh = joined(
      {box({0.25, 0, 0}, {1.25, 1, 1}), box({3.25, 0, 0}, {4.25, 1, 1}), box({6.25, 0, 0}, {7.25, 1, 1})});
  mesh.node_names = {"two", "one"};
  mesh.node.assign(36, 0);
  for (std::size_t t = 24; t < 36; ++t) mesh.node[t] = 1;
  mesh.material.resize(36, kNoIndex);
  mesh.given_hulls = {hull_of_first_node(box({2.75, 0, 0}, {4.75, 1, 1}))};
  const Glb file = written(made_of(mesh, true));
  ASSERT_EQ(parts(file).size(), 3u);
  std::size_t of_two = 0;
  for (const json& part : parts(file)) {
    const auto colliders = colliders_of(file, part);
    if (part["name"].get<std::string>().starts_with("one")) {
      EXPECT_EQ(colliders.size(), 1u) << "made by the server";
      continue;
    }
    of_two += colliders.size();
    for (const auto& points : colliders)
      EXPECT_EQ(points.begin()->at(0), 2.75f) << "the collider is on the part that it covers";
  }
  EXPECT_EQ(of_two, 1u);
}

TEST(IntactScene, FlatCollidersAreReplacedWithAWarning) {
  Mesh mesh = box({0.25, 0, 0}, {1.25, 1, 1}), flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}};
  flat.triangles = {{0, 2, 1}};
  mesh.given_hulls = {hull_of_first_node(flat)};
  const Fractured made = made_of(mesh, true);
  const Glb file = written(made);
  EXPECT_EQ(colliders_of(file, parts(file).at(0)).size(), 1u);
  EXPECT_TRUE(warns(made.report, "UCX_a_00"));
}

/// With a cube that is not fractured, a node of this name.
Mesh with_whole_node(const char* name) {
  auto rest = std::make_shared<Mesh>(translated(cube(), {0, 5, 0}));
  rest->node.assign(rest->triangles.size(), 0);
  rest->material.assign(rest->triangles.size(), kNoIndex);
  rest->node_names = {name};
  rest->node_extras = {"\"wood\":true"};
  Mesh mesh = sphere_and_frame();
  mesh.passed_through = rest;
  return mesh;
}

TEST(IntactScene, ItsRootHasANameOfItsOwn) {
  const Glb file = written(made_of(with_whole_node("Intact"), true));
  EXPECT_EQ(file.document["scenes"][1]["name"], "Intact");
  EXPECT_EQ(intact_root(file)["name"], "Intact_2");
  std::set<std::string> names;
  for (const json& node : file.document["nodes"]) EXPECT_TRUE(names.insert(node["name"]).second) << node;
  EXPECT_TRUE(names.contains("Intact")) << "the source's node keeps its name";
}

TEST(IntactScene, WhatWasNotFracturedIsInBothScenes) {
  const Glb file = written(made_of(with_whole_node("shelf"), true));
  const std::vector<json> nodes = parts(file);
  ASSERT_EQ(nodes.size(), 3u);
  std::size_t drawn = 0;
  for (const json& node : file.document["nodes"])
    drawn += node.contains("mesh") && node["mesh"] == nodes[2]["mesh"];
  EXPECT_EQ(drawn, 2u);
  EXPECT_EQ(nodes[2]["name"], "shelf_intact");
  std::size_t carrying = 0;
  for (const json& node : file.document["nodes"])
    carrying += node.contains("extras") && node["extras"].contains("wood");
  EXPECT_EQ(carrying, 2u) << "the source's extras are in both scenes, too";
}

}  // namespace
}  // namespace fracture::test
