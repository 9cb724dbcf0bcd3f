// Options that show how a bake works: the source paper's insertion, and the output of each stage.
#include <gmock/gmock.h>

#include <vector>

#include "tests/import/make_files.hpp"
#include "tests/server/support/bake_program.hpp"

namespace fracture::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST_F(BakeProgram, InsertsByFlipsToTheSameBytes) {
  for (const std::string command :
       {"cube.off --sites 1", "tub.off --sites 50", "in/box2.obj --sites 20 --lloyd 2",
        "in/gltf/box.gltf --sites 10 --max-volume 0.02", "cube.off --material wood --sites 30"}) {
    ASSERT_EQ(shell("$f bake " + command + " -o cavity.glb --insertion cavity"), 0) << err;
    EXPECT_THAT(out, Not(HasSubstr("flip"))) << command;
    ASSERT_EQ(shell("$f bake " + command + " -o flips.glb --insertion flips"), 0) << err;
    EXPECT_THAT(out, AllOf(HasSubstr("inserted by flips: "), HasSubstr(" flip23, "))) << command;
    EXPECT_TRUE(bytes("flips.glb") == bytes("cavity.glb")) << command;
  }
  ASSERT_EQ(shell("$f bake in -o many -q --insertion flips --sites 30 --allow-refused 1"), 0) << err;
  ASSERT_EQ(shell("$f bake in -o others -q --sites 30 --allow-refused 1"), 0) << err;
  EXPECT_TRUE(outputs(folder / "many") == outputs(folder / "others"));
  EXPECT_EQ(shell("$f bake cube.off -o x.glb --insertion walls"), 2);
  EXPECT_THAT(err, HasSubstr("--insertion"));
  EXPECT_EQ(shell("$f bake cube.off -o x.glb --insertion flips --server http://127.0.0.1:1"), 2);
  EXPECT_THAT(err, HasSubstr("on this machine"));
  EXPECT_FALSE(fs::exists(folder / "x.glb"));
}

TEST_F(BakeProgram, DumpsWhatEachStageMade) {
  ASSERT_EQ(shell("$f bake tub.off -o plain.glb --sites 20"), 0) << err;
  ASSERT_EQ(shell("$f bake tub.off -o x.glb --sites 20 --dump-stages a/stages"), 0) << err;
  EXPECT_TRUE(bytes("x.glb") == bytes("plain.glb"));
  const std::vector<std::string> names{"1-mesh.obj", "2-solid.obj", "3-sites.obj", "4-tetrahedra.obj",
                                       "5-fragments.obj"};
  std::vector<Mesh> meshes;
  for (const std::string& name : names) {
    Expected<Mesh> mesh = import_text(bytes("a/stages/" + name), MeshFormat::kObj);
    ASSERT_TRUE(mesh) << name << ": " << mesh.error().detail;
    meshes.push_back(std::move(*mesh));
  }
  EXPECT_EQ(files("a/stages"), names.size());
  EXPECT_EQ(meshes[0].triangles.size(), 10u) << "five sides";
  EXPECT_NEAR(signed_volume(meshes[1]), 1, 1e-6) << "the sixth is filled";
  EXPECT_EQ(meshes[2].triangles.size(), 20u * 8);
  const double tetrahedra = signed_volume(meshes[3]);
  EXPECT_GT(tetrahedra, 0);
  EXPECT_LT(tetrahedra, 1) << "the sites lie in the cube";
  EXPECT_NEAR(signed_volume(meshes[4]), 1, 1e-5) << "moved apart, and whole";

  // All stages except the fragments have the same position.
  Box solid, sites, fragments;
  for (const Vec3f& p : meshes[1].positions) solid.add(to_double(p));
  for (const Vec3f& p : meshes[2].positions) sites.add(to_double(p));
  for (const Vec3f& p : meshes[4].positions) fragments.add(to_double(p));
  for (int a = 0; a < 3; ++a) {
    EXPECT_GT(sites.min[a], solid.min[a] - 0.01);
    EXPECT_LT(sites.max[a], solid.max[a] + 0.01);
    EXPECT_GT(fragments.size()[a], 1.2 * solid.size()[a]);
  }
}

TEST_F(BakeProgram, StretchedSitesAreDumpedWhereTheSolidIs) {
  ASSERT_EQ(shell("$f bake cube.off -o x.glb --sites 30 --stretch 6 --dump-stages stages"), 0) << err;
  const Expected<Mesh> sites = import_text(bytes("stages/3-sites.obj"), MeshFormat::kObj),
                       cube = import_text(bytes("stages/2-solid.obj"), MeshFormat::kObj);
  ASSERT_TRUE(sites && cube);
  Box solid;
  for (const Vec3f& p : cube->positions) solid.add(to_double(p));
  for (const Vec3f& p : sites->positions)
    for (int a = 0; a < 3; ++a) {
      EXPECT_GT(to_double(p)[a], solid.min[a] - 0.02);
      EXPECT_LT(to_double(p)[a], solid.max[a] + 0.02);
    }
}

TEST_F(BakeProgram, ADumpWritesOverNothing) {
  ASSERT_EQ(shell("$f bake cube.off -o x.glb --dump-stages stages -q"), 0) << err;
  const auto before = outputs(folder / "stages");
  EXPECT_EQ(shell("$f bake tub.off -o y.glb --dump-stages stages"), 2);
  EXPECT_THAT(err, AllOf(HasSubstr("1-mesh.obj"), HasSubstr("--dump-stages")));
  EXPECT_FALSE(fs::exists(folder / "y.glb")) << "refused before anything is made";
  EXPECT_TRUE(outputs(folder / "stages") == before);

  fs::create_directory(folder / "other");
  fs::create_symlink("nowhere", folder / "other/5-fragments.obj");
  EXPECT_EQ(shell("$f bake cube.off -o y.glb --dump-stages other"), 2) << "nor through a link";
  EXPECT_FALSE(fs::exists(folder / "other/nowhere"));

  folder.write("file", "");
  EXPECT_EQ(shell("$f bake cube.off -o y.glb -q --dump-stages file/stages"), 1) << err;
  EXPECT_THAT(err, HasSubstr("cannot write file/stages/1-mesh.obj"));
  EXPECT_FALSE(fs::exists(folder / "y.glb")) << "nothing is made without its stages";

  ASSERT_EQ(shell("$f bake cube.off -o y.glb --report report -q"), 0) << err;
  ASSERT_EQ(shell("$f bake cube.off -o y.glb --report report --dump-stages again -q"), 0) << err;
  EXPECT_TRUE(outputs(folder / "again") == before) << "an output that is right is made again for its stages";
  EXPECT_EQ(shell("$f bake in -o many --dump-stages third"), 2);
  EXPECT_THAT(err, HasSubstr("one mesh"));
  EXPECT_FALSE(fs::exists(folder / "third"));
  EXPECT_FALSE(fs::exists(folder / "many"));
}

}  // namespace
}  // namespace fracture::test
