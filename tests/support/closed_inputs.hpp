// Parameters of tests that hold for every closed input: the generated shapes, and the closed files of the
// test meshes.
//
//   class SplitsShape : public OnClosedShape {};
//   TEST_P(SplitsShape, Keeps...) { ... shape().mesh ... }
//   INSTANTIATE_TEST_SUITE_P(Seed, SplitsShape, every_closed_shape(), name_of_shape);
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <string>
#include <vector>

#include "tests/support/full_tests.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {

inline const std::vector<NamedMesh>& all_closed_shapes() {
  static const std::vector<NamedMesh> all = closed_shapes();
  return all;
}

class OnClosedShape : public testing::TestWithParam<std::size_t> {
 protected:
  static const NamedMesh& shape() { return all_closed_shapes()[GetParam()]; }
};
inline auto every_closed_shape() { return testing::Range<std::size_t>(0, all_closed_shapes().size()); }
inline std::string name_of_shape(const testing::TestParamInfo<std::size_t>& info) {
  return all_closed_shapes()[info.param].name;
}

/// Loads the mesh before the test. If the file does not exist, the test is skipped.
class OnClosedMesh : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const auto file = find_test_mesh(GetParam());
    if (!file) GTEST_SKIP() << "no mesh " << GetParam();
    Expected<Mesh> loaded = load_mesh(*file);
    ASSERT_TRUE(loaded) << loaded.error().detail;
    mesh = std::move(*loaded);
  }
  /// Whether the mesh does not cross itself. If it does, its caps may cross too.
  static bool embedded() {
    return GetParam().find("brick") == std::string::npos &&
           GetParam().find("spot_quads") == std::string::npos;
  }
  /// The input's number for has_turn().
  static std::size_t number() {
    const std::vector<std::string>& all = closed_test_meshes();
    return static_cast<std::size_t>(std::find(all.begin(), all.end(), GetParam()) - all.begin());
  }
  Mesh mesh;
};
/// The same for long tests: three small meshes, or all of them with FRACTURE_TEST_FULL.
class OnClosedMeshAtLength : public OnClosedMesh {
 protected:
  void SetUp() override {
    const std::set<std::string> always{"cube.glb", "kk_bottle_A_brown.glb", "nested.glb"};
    if (!full_tests() && !always.contains(GetParam())) GTEST_SKIP() << "only with FRACTURE_TEST_FULL";
    OnClosedMesh::SetUp();
  }
};
inline auto every_closed_mesh() { return testing::ValuesIn(closed_test_meshes()); }
inline std::string name_of_mesh(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

}  // namespace fracture::test
