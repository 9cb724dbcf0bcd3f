// OBJ and MTL: the geometry and looks of an answer, read back by the tests' own reader.
#include <gmock/gmock.h>

#include "common/mesh/material_library.hpp"
#include "tests/gltf/two_halves.hpp"
#include "tests/outputs/read_back.hpp"

namespace fracture::outputs::test {
namespace {

using fracture::test::two_halves;
using fracture::test::two_halves_with_hulls;
using testing::ElementsAre;
using testing::HasSubstr;

std::string mtl_of(const Answer& answer, const std::vector<std::string>& textures) {
  std::string text;
  EXPECT_TRUE(write_mtl(answer, textures, into(text)));
  return text;
}

TEST(Obj, HasAnObjectForEachFragmentWhereItWasCutAndNoHulls) {
  const std::vector<std::uint8_t> glb =
      write_glb(two_halves_with_hulls(), with(&GltfOptions::ue_collision, UeCollision::kUcx));
  const ObjFile obj(obj_of(read(glb)));
  ASSERT_EQ(obj.objects.size(), 2u);
  EXPECT_EQ(obj.library, "x.mtl");
  EXPECT_EQ(obj.positions.size(), 16u) << "the corners of two cubes, each once";
  for (std::size_t k = 0; k < 2; ++k) {
    const ObjObject& half = obj.objects[k];
    EXPECT_EQ(half.name, "Kiste_\xc3\xa4__1__" + std::to_string(k)) << "as its node in the GLB";
    EXPECT_EQ(half.triangles.size(), 12u);
    EXPECT_EQ(open_edges(half.triangles), 0u);
    EXPECT_EQ(open_edges(half.v), 0u) << "by the numbers of its vertices, too";
    EXPECT_EQ(volume_of(half.triangles), 1);
    for (const Triangle& t : half.triangles)
      for (const Point& p : t) {
        EXPECT_GE(p[0], static_cast<float>(k));
        EXPECT_LE(p[0], static_cast<float>(k + 1));
      }
  }
}

TEST(Obj, NodesOfTheSourceWithoutAMeshAreNoObjects) {
  FracturedSolid made = two_halves();
  const std::string before = obj_of(read(write_glb(made, {})));
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->empty_nodes = {{.name = "socket", .x = {0, 0, -2}, .z = {2, 0, 0}}};
  made.set.source = mesh;
  EXPECT_EQ(obj_of(read(write_glb(made, {}))), before) << "although the node is turned";
}

TEST(Obj, FacesHaveTheirMaterialsNormalsAndTheUvsThatTheMaterialIsPaintedBy) {
  const ObjFile obj(obj_of(read(write_glb(two_halves(), {}))));
  std::map<std::string, int> faces;
  for (const ObjObject& half : obj.objects)
    for (std::size_t t = 0; t < half.triangles.size(); ++t) {
      ++faces[half.materials[t]];
      const auto at = [&](int k) {
        const Point& p = half.triangles[t][static_cast<std::size_t>(k)];
        return Vec3d{p[0], p[1], p[2]};
      };
      const Vec3d out = cross(at(1) - at(0), at(2) - at(0));  // of length 1: twice half of a unit square
      for (const Point& n : half.normals[t]) EXPECT_EQ((Vec3d{n[0], n[1], n[2]}), out);
      for (const auto& [u, v] : half.uvs[t]) {
        // The first set is in [0, 1]. The second set, which shows the texture of wood, is in [-1/2, 1/2]. In
        // an OBJ, v points up.
        const bool wood = half.materials[t] == "wood";
        EXPECT_EQ(std::abs(u - (wood ? 0 : 0.5f)), 0.5f);
        EXPECT_EQ(std::abs(v - (wood ? 1 : 0.5f)), 0.5f);
      }
    }
  EXPECT_EQ(faces, (std::map<std::string, int>{{"wood", 8}, {"paint", 12}, {"Interior", 4}}));
}

TEST(Obj, ColorsAreThoseOfScreensOrStayAsTheyCame) {
  const KeptAnswer answer = read(write_glb(two_halves(), {}));
  // IEC 61966-2-1: 1.055 c^(1/2.4) - 0.055, computed by hand for 1/2 and 1/4.
  const ObjFile shown(obj_of(answer)), kept(obj_of(answer, VertexColors::kKeep));
  ASSERT_EQ(shown.colors.size(), 16u);
  ASSERT_EQ(kept.colors.size(), 16u);
  for (const Point& c : shown.colors) {
    EXPECT_EQ(c[0], 1);
    EXPECT_NEAR(c[1], 0.73536, 6e-5);
    EXPECT_NEAR(c[2], 0.53710, 6e-5);
  }
  for (const Point& c : kept.colors) EXPECT_EQ(c, (Point{1, 0.5f, 0.25f}));
}

TEST(Obj, WhereTwoColorsMeetThereAreTwoVerticesAtOnePosition) {
  FracturedSolid halves = two_halves();
  for (std::size_t v = 0; v < 4; ++v)
    halves.set.fragments[0].attributes.colors[0][v] = {0, 0, 0, 1};  // one face
  const ObjFile obj(obj_of(read(write_glb(halves, {}))));
  EXPECT_EQ(obj.positions.size(), 20u);
  EXPECT_EQ(open_edges(obj.objects[0].triangles), 0u) << "the positions are the same";
}

TEST(Obj, WithoutAManifoldVerticesAtOnePositionAreOne) {
  const ObjFile obj(obj_of(read(write_glb(two_halves(), with(&GltfOptions::mesh_manifold, false)))));
  EXPECT_EQ(obj.positions.size(), 16u);
  for (const ObjObject& half : obj.objects) EXPECT_EQ(open_edges(half.v), 0u);
}

TEST(Obj, FragmentsOfARealBreakAreClosedAndWhatTheyShareHasTheSameBits) {
  const FracturedSolid& ball = broken_ball();
  const std::vector<std::uint8_t> glb = write_glb(ball, {});
  const ObjFile obj(obj_of(read(glb)));
  ASSERT_EQ(obj.objects.size(), ball.set.fragments.size());
  ASSERT_GT(obj.objects.size(), 10u);
  std::set<std::string> names;
  std::multiset<Triangle> cuts;
  double sum = 0;
  for (std::size_t k = 0; k < obj.objects.size(); ++k) {
    const ObjObject& object = obj.objects[k];
    names.insert(object.name);
    EXPECT_EQ(open_edges(object.v), 0u) << object.name;
    EXPECT_EQ(open_edges(object.triangles), 0u) << object.name;
    sum += volume_of(object.triangles);
    for (std::size_t t = 0; t < object.triangles.size(); ++t) {
      if (object.materials[t] != "Interior") continue;
      Triangle turned = object.triangles[t];
      std::sort(turned.begin(), turned.end());
      cuts.insert(turned);
    }
  }
  EXPECT_EQ(names.size(), obj.objects.size());
  const double volume = ball.set.certificate.volume_out;
  EXPECT_NEAR(sum, volume, 1e-9 * 100 * 100 * 100) << "sums of floats that are 100 m from the origin";
  ASSERT_FALSE(cuts.empty());
  for (const Triangle& t : cuts) EXPECT_EQ(cuts.count(t), 2u) << "a cut has two sides";
}

TEST(Mtl, SaysWhatTheMaterialsLookLike) {
  FracturedSolid halves = two_halves();
  auto library = std::make_shared<MaterialLibrary>(*halves.set.source->library);
  library->materials[0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 0}};
  library->materials[1] = {
      {"name", "paint"},
      {"alphaMode", "BLEND"},
      {"emissiveFactor", {0.5, 0, 0}},
      {"pbrMetallicRoughness",
       {{"baseColorFactor", {0.2, 0.4, 0.6, 0.25}},
        {"baseColorTexture",
         {{"index", 0},
          {"extensions", {{"KHR_texture_transform", {{"scale", {2, 4}}, {"offset", {0.5, 0.25}}}}}}}},
        {"metallicFactor", 0},
        {"roughnessFactor", 0.5}}}};
  auto mesh = std::make_shared<Mesh>(*halves.set.source);
  mesh->library = library;
  halves.set.source = mesh;
  const KeptAnswer answer = read(write_glb(halves, {}));
  EXPECT_THAT(images_of_mtl(answer), ElementsAre(0u));
  ASSERT_EQ(answer.images.size(), 1u);
  EXPECT_EQ(answer.images[0].ending, ".png");
  EXPECT_THAT(mtl_of(answer, {"my texture.png"}),
              HasSubstr("newmtl paint\nKd 0.2 0.4 0.6\nd 0.25\n"
                        "Ns 30\n"  // 2 / 0.5^4 - 2
                        "Pr 0.5\nPm 0\nKe 0.5 0 0\nillum 2\n"
                        // 1 - (0.25 + 4 (1 - v)) = 4 v - 3.25
                        "map_Kd -s 2 4 1 -o 0.5 -3.25 0 my texture.png\n"));
  EXPECT_THAT(mtl_of(answer, {"t.png"}),
              HasSubstr("newmtl wood\nKd 1 1 1\nd 1\nillum 2\nmap_Kd t.png\nnorm t.png\n"))
      << "how rough it is says a texture, which is left out";
}

TEST(Mtl, EveryMaterialThatAnObjUsesIsThere) {
  FracturedSolid halves = two_halves();
  halves.set.fragments[0].primitives[1].material = kNoIndex;  // the importer's mark for no material
  auto library = std::make_shared<MaterialLibrary>(*halves.set.source->library);
  library->materials[0]["name"] = "none\nd 0";  // two lines; the second is an attacker's
  library->materials[1]["name"] = "none";
  auto mesh = std::make_shared<Mesh>(*halves.set.source);
  mesh->library = library;
  halves.set.source = mesh;
  const KeptAnswer answer = read(write_glb(halves, {}));
  const std::string mtl = mtl_of(answer, {"t.png"});
  std::multiset<std::string> made;
  std::istringstream lines(mtl);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("newmtl ")) made.insert(line.substr(7));
  EXPECT_EQ(made, (std::multiset<std::string>{"none_d_0", "none_2", "none", "Interior"}));
  std::set<std::string> used;
  for (const ObjObject& half : ObjFile(obj_of(answer)).objects)
    used.insert(half.materials.begin(), half.materials.end());
  EXPECT_EQ(used, (std::set<std::string>{"none_d_0", "none_2", "none", "Interior"}));
}

}  // namespace
}  // namespace fracture::outputs::test
