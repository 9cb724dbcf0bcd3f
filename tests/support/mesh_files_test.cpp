// FRACTURE_TEST_MESHES may name several folders.
#include "tests/support/mesh_files.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

struct TestMeshFolders : testing::Test {
  void SetUp() override {
    const char* set = std::getenv("FRACTURE_TEST_MESHES");
    if (set) before = set;
    std::string name = (fs::temp_directory_path() / "mesh-folders-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root = name;
    for (const char* file : {"a/one.obj", "a/below/two.stl", "a/notes.txt", "b/one.obj", "b/three.GLB"}) {
      fs::create_directories((root / file).parent_path());
      std::ofstream(root / file) << file;
    }
  }
  void TearDown() override {
    if (before)
      ::setenv("FRACTURE_TEST_MESHES", before->c_str(), 1);
    else
      ::unsetenv("FRACTURE_TEST_MESHES");
    fs::remove_all(root);
  }
  std::optional<std::string> before;
  fs::path root;
};

TEST_F(TestMeshFolders, AreSearchedInTheirOrderAndListedByName) {
  const std::string folders =
      (root / "a").string() + ":" + (root / "absent").string() + "::" + (root / "b").string();
  ::setenv("FRACTURE_TEST_MESHES", folders.c_str(), 1);
  std::vector<std::string> names;
  for (const MeshFile& file : test_meshes()) names.push_back(file.name);
  EXPECT_EQ(names, (std::vector<std::string>{"below/two.stl", "one.obj", "three.GLB"}));
  ASSERT_TRUE(find_test_mesh("one.obj"));
  EXPECT_EQ(find_test_mesh("one.obj")->path, (root / "a" / "one.obj").string()) << "the first folder has it";
  ASSERT_TRUE(find_test_mesh("three.GLB"));
  EXPECT_EQ(find_test_mesh("three.GLB")->path, (root / "b" / "three.GLB").string());
  EXPECT_FALSE(find_test_mesh("two.stl"));
}

TEST_F(TestMeshFolders, ThatAreAbsentHaveNone) {
  ::setenv("FRACTURE_TEST_MESHES", (root / "absent").c_str(), 1);
  EXPECT_TRUE(test_meshes().empty());
  EXPECT_FALSE(find_test_mesh("one.obj"));
}

}  // namespace
}  // namespace fracture::test
