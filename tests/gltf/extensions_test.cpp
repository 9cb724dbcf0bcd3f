// Compares the extensions, and the second container, with their specifications and with known figures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <string>

#include "common/gltf/gltf_writer.hpp"
#include "common/mesh/material_library.hpp"
#include "common/solid/solid.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::Not;

constexpr const char* kKhrName = "KHR_physics_rigid_bodies";

Glb written(GltfOptions options = {}) { return Glb(write_glb(two_halves_with_hulls(), options)); }

GltfOptions with(Physics physics) {
  GltfOptions options;
  options.physics = physics;
  return options;
}

std::size_t count_drawn(const json& document, const json& mesh) {
  std::size_t drawn = 0;
  for (const json& node : document["nodes"]) drawn += node.contains("mesh") && node["mesh"] == mesh;
  return drawn;
}

/// Expects the points and triangles of the hull in the hull mesh.
void expect_hull_mesh(const Glb& glb, const json& mesh, const CollisionHull& hull) {
  const json& primitives = glb.document["meshes"].at(mesh.get<std::size_t>())["primitives"];
  ASSERT_EQ(primitives.size(), 1u);
  EXPECT_FALSE(primitives[0].contains("material"));
  EXPECT_EQ(glb.read<Vec3f>(primitives[0]["attributes"]["POSITION"]), hull.points);
  std::vector<std::uint16_t> corners;
  for (const auto& t : hull.triangles)
    for (const std::uint32_t k : t) corners.push_back(static_cast<std::uint16_t>(k));
  EXPECT_EQ(glb.read<std::uint16_t>(primitives[0]["indices"]), corners);
}

TEST(KhrPhysics, MotionOfACubeHasAllFourMembersAtTheDensity) {
  GltfOptions options;
  options.density = 300;
  FracturedSolid made = two_halves_with_hulls();
  made.set.fragments[0].mass.center_of_mass = {0.625, 0.5, 0.25};  // the pivot stays at the half's middle
  const json motion = Glb(write_glb(made, options)).document["nodes"][1]["extensions"][kKhrName]["motion"];
  EXPECT_EQ(motion["mass"], 300);
  EXPECT_EQ(motion["centerOfMass"], json({0.125, 0.0, -0.25}));
  for (const json& moment : motion["inertiaDiagonal"]) EXPECT_DOUBLE_EQ(moment.get<double>(), 50);  // m a²/6
  EXPECT_EQ(motion["inertiaOrientation"], json({0, 0, 0, 1}));
}

TEST(KhrPhysics, ABodyWithoutVolumeHasOneMassThatIsMoreThanNothing) {
  FracturedSolid made = two_halves_with_hulls();
  made.set.fragments[0].mass.volume = -1e-20;
  const json node = Glb(write_glb(made, {})).document["nodes"][1];
  const json& motion = node["extensions"][kKhrName]["motion"];
  EXPECT_GT(motion["mass"].get<double>(), 0);
  EXPECT_EQ(node["extras"]["fracture"]["mass"], motion["mass"]);
  EXPECT_GT(node["extras"]["fracture"]["volume"].get<double>(), 0);
}

TEST(KhrPhysics, InertiaIsTurnedIntoItsPrincipalAxes) {
  FracturedSolid made = two_halves_with_hulls();
  // Moments 3, 4 and 5 about axes turned by 45 degrees around z.
  made.set.fragments[0].mass.inertia = {3.5, 3.5, 5, -0.5, 0, 0};
  const json motion = Glb(write_glb(made, {})).document["nodes"][1]["extensions"][kKhrName]["motion"];
  const auto moments = motion["inertiaDiagonal"].get<std::vector<double>>();
  const auto q = motion["inertiaOrientation"].get<std::vector<double>>();
  EXPECT_THAT(moments, ::testing::UnorderedElementsAre(::testing::DoubleNear(3000, 1e-9),
                                                       ::testing::DoubleNear(4000, 1e-9),
                                                       ::testing::DoubleNear(5000, 1e-9)));
  EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-12);
  // The image of the x axis is the axis of the first moment: (1, ±1, 0)/√2.
  const double x = 1 - 2 * (q[1] * q[1] + q[2] * q[2]), y = 2 * (q[0] * q[1] + q[2] * q[3]);
  EXPECT_NEAR(std::abs(x), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(x * y, moments[0] < 3500 ? 0.5 : -0.5, 1e-12);
}

TEST(KhrPhysics, OneHullIsTheColliderOfTheNodeByAMeshThatNoNodeDraws) {
  const Glb glb = written();
  const json& collider = glb.document["nodes"][1]["extensions"][kKhrName]["collider"];
  EXPECT_EQ(collider["geometry"]["convexHull"], true);
  EXPECT_FALSE(collider["geometry"].contains("node"));
  EXPECT_EQ(collider["physicsMaterial"], 0);
  EXPECT_FALSE(collider.contains("collisionFilter"));
  EXPECT_EQ(count_drawn(glb.document, collider["geometry"]["mesh"]), 0u);
  expect_hull_mesh(glb, collider["geometry"]["mesh"], two_halves_with_hulls().hulls.of(0)[0]);
}

TEST(KhrPhysics, SeveralHullsAreACompoundOfChildrenAtTheIdentity) {
  const Glb glb = written();
  const json& nodes = glb.document["nodes"];
  EXPECT_FALSE(nodes[2]["extensions"][kKhrName].contains("collider"));
  EXPECT_TRUE(nodes[2]["extensions"][kKhrName].contains("motion"));
  ASSERT_EQ(nodes[2]["children"], json({3, 4}));
  for (std::size_t k = 0; k < 2; ++k) {
    const json& child = nodes[3 + k];
    for (const char* key : {"translation", "rotation", "scale", "matrix", "extras", "mesh"})
      EXPECT_FALSE(child.contains(key)) << key;
    EXPECT_FALSE(child["extensions"][kKhrName].contains("motion"));
    const json& geometry = child["extensions"][kKhrName]["collider"]["geometry"];
    EXPECT_EQ(geometry["convexHull"], true);
    expect_hull_mesh(glb, geometry["mesh"], two_halves_with_hulls().hulls.of(1)[k]);
  }
}

TEST(KhrPhysics, TheMaterialStandsInTheDocumentAndNothingIsRequired) {
  GltfOptions options;
  options.friction = 0.75;
  options.restitution = 0.25;
  const json document = written(options).document;
  EXPECT_EQ(document["extensions"][kKhrName]["physicsMaterials"],
            json::array({{{"staticFriction", 0.75}, {"dynamicFriction", 0.75}, {"restitution", 0.25}}}));
  EXPECT_THAT(document["extensionsUsed"], Contains(kKhrName));
  EXPECT_FALSE(document.contains("extensionsRequired"));
}

TEST(KhrPhysics, FragmentsWithoutHullsAreBodiesWithoutColliders) {
  const json document = Glb(write_glb(two_halves(), {})).document;
  EXPECT_EQ(document["meshes"].size(), 2u);
  EXPECT_EQ(document["nodes"].size(), 3u);
  for (const std::size_t node : {1u, 2u}) {
    EXPECT_TRUE(document["nodes"][node]["extensions"][kKhrName].contains("motion"));
    EXPECT_FALSE(document["nodes"][node]["extensions"][kKhrName].contains("collider"));
  }
  EXPECT_TRUE(document["extensions"][kKhrName].contains("physicsMaterials"));
}

TEST(KhrPhysics, FragmentsThatOverlapHaveFiltersAndTheirPairsAreNamed) {
  FracturedSolid made = two_halves_with_hulls();
  made.set.fragments[0].id = 11;
  made.set.fragments[1].id = 12;
  made.rest = Rest{.figures = {.pairs = 1, .filtered = 1, .systems = 2, .tolerance = 0.25},
                   .filters = {2, {{1, {}}, {0, {1}}}, {0, 1}, {}},
                   .filtered = {{11, 12}}};
  const json document = Glb(write_glb(made, {})).document;
  EXPECT_EQ(document["extensions"][kKhrName]["collisionFilters"], json::parse(R"([{"collisionSystems": ["1"]},
                            {"collisionSystems": ["0"], "notCollideWithSystems": ["1"]}])"));
  EXPECT_EQ(document["nodes"][1]["extensions"][kKhrName]["collider"]["collisionFilter"], 0);
  for (const std::size_t node : {3u, 4u})
    EXPECT_EQ(document["nodes"][node]["extensions"][kKhrName]["collider"]["collisionFilter"], 1);
  const json& figures = document["nodes"][0]["extras"]["fracture"];
  EXPECT_EQ(figures["filtered"], json::parse(R"({"a": [11], "b": [12]})"));
  EXPECT_EQ(
      figures["certificate"]["rest"],
      json::parse(R"({"pairs": 1, "trimmed": 0, "filtered": 1, "left": 0, "deepest": 0, "tolerance": 0.25,
                            "least_share": 1, "systems": 2})"));
}

TEST(KhrPhysics, WithoutOverlapsThereAreNoFiltersAndWithoutHullsNoRest) {
  const json document = Glb(write_glb(two_halves_with_hulls(), {})).document;
  EXPECT_FALSE(document["extensions"][kKhrName].contains("collisionFilters"));
  const json& figures = document["nodes"][0]["extras"]["fracture"];
  EXPECT_TRUE(figures["certificate"]["rest"].is_null());
  EXPECT_FALSE(figures.contains("filtered"));
}

TEST(OmiPhysics, ConvexShapesByMeshAndMotionWithoutInertia) {
  const Glb glb = written(with(Physics::kOmi));
  const json& document = glb.document;
  const json& shapes = document["extensions"]["OMI_physics_shape"]["shapes"];
  ASSERT_EQ(shapes.size(), 3u);
  const auto shape_of = [&](const json& node) {
    const json& shape =
        shapes.at(node["extensions"]["OMI_physics_body"]["collider"]["shape"].get<std::size_t>());
    EXPECT_EQ(shape["type"], "convex");
    return shape["convex"]["mesh"];
  };
  const FracturedSolid made = two_halves_with_hulls();
  expect_hull_mesh(glb, shape_of(document["nodes"][1]), made.hulls.of(0)[0]);
  expect_hull_mesh(glb, shape_of(document["nodes"][3]), made.hulls.of(1)[0]);
  expect_hull_mesh(glb, shape_of(document["nodes"][4]), made.hulls.of(1)[1]);
  const json& motion = document["nodes"][2]["extensions"]["OMI_physics_body"]["motion"];
  EXPECT_EQ(motion, json({{"type", "dynamic"}, {"mass", 1000}, {"centerOfMass", {0, 0, 0}}}));
  EXPECT_THAT(document["extensionsUsed"], Contains("OMI_physics_body"));
  EXPECT_THAT(document["extensionsUsed"], Contains("OMI_physics_shape"));
  EXPECT_THAT(document["extensionsUsed"], Not(Contains(kKhrName)));
}

TEST(NoPhysics, LeavesNoTraceInTheFile) {
  const json document = written(with(Physics::kNone)).document;
  EXPECT_FALSE(document.contains("extensions"));
  EXPECT_EQ(document["meshes"].size(), 2u);
  EXPECT_EQ(document["nodes"].size(), 3u);
  for (const json& node : document["nodes"]) EXPECT_FALSE(node.contains("extensions"));
  EXPECT_EQ(document["extensionsUsed"], json::array({"EXT_mesh_manifold"}));
}

TEST(UeCollision, DrawsEachHullUnderTheFragmentsNameAndNothingTakesItForAFragment) {
  GltfOptions options = with(Physics::kNone);
  options.ue_collision = UeCollision::kUcx;
  const Glb glb = written(options);
  const json& nodes = glb.document["nodes"];
  ASSERT_EQ(nodes.size(), 6u);
  EXPECT_EQ(nodes[1]["children"], json::array({3}));
  EXPECT_EQ(nodes[2]["children"], json({4, 5}));
  EXPECT_EQ(nodes[3]["name"], "UCX_" + nodes[1]["name"].get<std::string>() + "_00");
  EXPECT_EQ(nodes[5]["name"], "UCX_" + nodes[2]["name"].get<std::string>() + "_01");
  for (const std::size_t k : {3u, 4u, 5u}) {
    EXPECT_FALSE(nodes[k].contains("extras"));
    EXPECT_FALSE(nodes[k].contains("translation"));
    EXPECT_EQ(glb.document["meshes"][nodes[k]["mesh"].get<std::size_t>()]["name"], nodes[k]["name"]);
  }
  expect_hull_mesh(glb, nodes[5]["mesh"], two_halves_with_hulls().hulls.of(1)[1]);
}

TEST(UeCollision, NamesStayUniqueAndShortWhateverTheSourceIsCalled) {
  GltfOptions options;
  options.ue_collision = UeCollision::kUcx;
  for (const std::string& name : {std::string(200, 'x'), std::string("UCX_box_0_00"), std::string()}) {
    FracturedSolid made = two_halves_with_hulls();
    auto mesh = std::make_shared<Mesh>(*made.set.source);
    mesh->node_names = {name};
    made.set.source = mesh;
    std::set<std::string> names;
    const json document = Glb(write_glb(made, options)).document;
    for (const json& node : document["nodes"]) {
      names.insert(node["name"].get<std::string>());
      EXPECT_LE(node["name"].get<std::string>().size(), 63u);
    }
    EXPECT_EQ(names.size(), document["nodes"].size());
    for (const std::size_t fragment : {1u, 2u})
      EXPECT_NE(document["nodes"][fragment]["name"].get<std::string>().substr(0, 4), "UCX_");
  }
}

TEST(MeshManifold, CoversAllPrimitivesWithSeamsMerged) {
  const FracturedSolid made = two_halves();
  const Glb glb = written();
  for (std::size_t k = 0; k < made.set.fragments.size(); ++k) {
    const Fragment& f = made.set.fragments[k];
    const json& mesh = glb.document["meshes"][k];
    const json& extension = mesh["extensions"]["EXT_mesh_manifold"];
    EXPECT_EQ(extension["manifoldPrimitive"]["attributes"],
              json({{"POSITION", mesh["primitives"][0]["attributes"]["POSITION"]}}));
    const json& indices = extension["manifoldPrimitive"]["indices"];
    auto merged = glb.read<std::uint16_t>(indices);  // of the base view: all primitives one after another
    EXPECT_THAT(merged, ::testing::ElementsAreArray(f.indices));
    const auto corners = glb.read<std::uint16_t>(extension["mergeIndices"]);
    const auto vertices = glb.read<std::uint16_t>(extension["mergeValues"]);
    ASSERT_EQ(corners.size(), vertices.size());
    EXPECT_TRUE(std::is_sorted(corners.begin(), corners.end()));
    for (std::size_t m = 0; m < corners.size(); ++m) merged.at(corners[m]) = vertices[m];
    // A cube has 12 triangles over 8 vertices. Each edge occurs once in each direction.
    std::set<std::pair<std::uint16_t, std::uint16_t>> edges;
    for (std::size_t t = 0; t < merged.size(); t += 3)
      for (std::size_t e = 0; e < 3; ++e)
        EXPECT_TRUE(edges.emplace(merged[t + e], merged[t + (e + 1) % 3]).second);
    EXPECT_EQ(edges.size(), 36u);
    for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a}));
    EXPECT_EQ((std::set<std::uint16_t>(merged.begin(), merged.end()).size()), 8u);
    // The sparse accessor states the same as the merges.
    const json& sparse = glb.document["accessors"][indices.get<std::size_t>()]["sparse"];
    const json& from = glb.document["accessors"][extension["mergeIndices"].get<std::size_t>()];
    const json& to = glb.document["accessors"][extension["mergeValues"].get<std::size_t>()];
    EXPECT_EQ(sparse["count"], corners.size());
    EXPECT_EQ(sparse["indices"]["bufferView"], from["bufferView"]);
    EXPECT_EQ(sparse["indices"]["byteOffset"], from.value("byteOffset", 0));
    EXPECT_EQ(sparse["values"]["bufferView"], to["bufferView"]);
    EXPECT_EQ(sparse["values"]["byteOffset"], to.value("byteOffset", 0));
  }
}

TEST(MeshManifold, IsLeftOutWhereItIsNotWantedOrNothingIsKnown) {
  GltfOptions options;
  options.mesh_manifold = false;
  EXPECT_FALSE(written(options).document["meshes"][0].contains("extensions"));
  EXPECT_THAT(written(options).document["extensionsUsed"], Not(Contains("EXT_mesh_manifold")));
  FracturedSolid made = two_halves();
  for (Fragment& f : made.set.fragments) f.topology.clear();
  EXPECT_FALSE(Glb(write_glb(made, {})).document["meshes"][0].contains("extensions"));
}

TEST(MeshManifold, WithoutSeamsNothingIsMerged) {
  FracturedSolid made = two_halves();
  Fragment& f = made.set.fragments[0];  // a tetrahedron
  f.attributes = {};
  f.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  f.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  f.primitives = {{kNoIndex, 0, 12}};
  f.topology = {0, 1, 2, 3};
  const json document = Glb(write_glb(made, {})).document;
  const json& extension = document["meshes"][0]["extensions"]["EXT_mesh_manifold"];
  EXPECT_FALSE(extension.contains("mergeIndices"));
  EXPECT_FALSE(
      document["accessors"][extension["manifoldPrimitive"]["indices"].get<std::size_t>()].contains("sparse"));
}

/// Decodes RFC 4648 base64 by its definition, digit by digit.
std::vector<std::uint8_t> from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  unsigned bits = 0, have = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    if ((have += 6) >= 8) bytes.push_back(static_cast<std::uint8_t>(bits >> (have -= 8)));
  }
  EXPECT_EQ(text.size() % 4, 0u);
  return bytes;
}

TEST(GltfJson, SaysTheSameAsTheGlbWithTheBufferInADataUri) {
  const FracturedSolid made = two_halves_with_hulls();
  const Glb glb(write_glb(made, {}));
  const std::vector<std::uint8_t> text = write_gltf(made, {});
  json document = json::parse(text.begin(), text.end());
  const std::string uri = document["buffers"][0]["uri"];
  const std::string head = "data:application/octet-stream;base64,";
  ASSERT_EQ(uri.substr(0, head.size()), head);
  EXPECT_EQ(from_base64(uri.substr(head.size())), glb.binary);
  document["buffers"][0].erase("uri");
  EXPECT_EQ(document, glb.document);
}

TEST(GltfJson, PadsWhatIsNotAMultipleOfThreeBytes) {
  for (const std::size_t size : {1u, 2u, 3u, 4u, 5u, 6u}) {
    FracturedSolid made;
    auto library = std::make_shared<MaterialLibrary>();
    library->images.push_back({"", "image/jpeg", std::vector<std::uint8_t>(4 * size, 0xfb)});
    auto mesh = std::make_shared<Mesh>();
    mesh->library = library;
    made.set.source = mesh;
    const std::vector<std::uint8_t> text = write_gltf(made, {});
    const std::string uri = json::parse(text.begin(), text.end())["buffers"][0]["uri"];
    EXPECT_EQ(from_base64(uri.substr(uri.find(',') + 1)), library->images[0].bytes);
  }
}

TEST(CollisionHull, ThatContradictsItselfIsABugNotAFile) {
  FracturedSolid made = two_halves_with_hulls();
  made.hulls.of_fragment[0].hulls[0].triangles[3][1] = 8;
  EXPECT_THROW(write_glb(made, {}), InternalError);
  made.hulls.of_fragment[0].hulls[0] = {};
  EXPECT_THROW(write_glb(made, {}), InternalError);
}

}  // namespace
}  // namespace fracture::test
