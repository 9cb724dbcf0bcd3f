#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/solid/solid.hpp"
#include "tests/support/figures.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {
namespace {

/// Checks the source's outside: the solid has every source triangle that was kept, with its corners'
/// positions.
void expect_source_kept(const Solid& solid) {
  std::size_t from_source = 0;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    if (solid.wedges[t][0] == kNoIndex) continue;
    ++from_source;
    if (solid.report.welded_tolerant > 0) continue;
    for (int k = 0; k < 3; ++k)
      ASSERT_EQ(solid.positions[solid.triangles[t][k]], solid.source->positions[solid.wedges[t][k]]);
  }
  if (solid.report.shells_dropped == 0 && solid.report.sheets == 0) {
    EXPECT_EQ(from_source + solid.report.degenerate_dropped + solid.report.duplicates_dropped,
              solid.report.source_triangles);
  }
}

TEST(RealMeshes, EveryClosedFileIsASolidAsItStands) {
  std::size_t seen = 0;
  for (const std::string& name : closed_test_meshes()) {
    const auto file = find_test_mesh(name);
    if (!file) continue;
    const Expected<Mesh> mesh = load_mesh(*file);
    if (!mesh) continue;
    SCOPED_TRACE(name);
    ++seen;
    const Expected<Solid> solid = try_solid(*mesh, {.repair = Repair::kStrict});
    ASSERT_TRUE(solid) << solid.error().detail;
    ASSERT_NO_THROW(solid->validate());
    expect_source_kept(*solid);
    EXPECT_EQ(solid->triangles.size(), mesh->triangles.size());
    EXPECT_NEAR(solid->report.volume, volume_of(*mesh), 1e-11 * solid->report.volume);
    EXPECT_EQ(open_directed_edges(*mesh), 0u);
  }
  if (seen == 0) GTEST_SKIP() << "no test meshes";
}

TEST(RealMeshes, EveryFileThatLoadsBecomesAValidSolidExceptTheSoup) {
  std::size_t seen = 0;
  for (const MeshFile& file : test_meshes()) {
    const Expected<Mesh> mesh = load_mesh(file);
    if (!mesh) continue;  // multi-file assets: tests/import
    SCOPED_TRACE(file.name);
    ++seen;
    const Expected<Solid> solid = try_solid(*mesh);
    if (file.name == "soup.stl") {
      ASSERT_FALSE(solid);
      EXPECT_EQ(solid.error().code, ErrorCode::kMeshNotClosed);
      EXPECT_EQ(solid.error().extra->at("open_edges"), 300);
      continue;
    }
    ASSERT_TRUE(solid) << solid.error().detail;
    ASSERT_NO_THROW(solid->validate());
    expect_source_kept(*solid);
  }
  if (seen == 0) GTEST_SKIP() << "no test meshes";
}

TEST(RealMeshes, SuzanneAsObjHasFortyTwoOpenEdgesAndOneNonmanifoldEdge) {
  const auto file = find_test_mesh("suzanne.obj");
  if (!file) GTEST_SKIP() << "suzanne.obj is absent";
  const Expected<Solid> solid = try_solid(*load_mesh(*file));
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->report.open_edges, 42u);
  EXPECT_EQ(solid->report.nonmanifold_edges, 1u);
}

TEST(RealMeshes, SuzanneOfTheBlendFileHasThreePartsAndEightyFourOpenEdges) {
  const auto file = assimp_model("BLEND/Suzanne_248.blend");
  if (!file) GTEST_SKIP() << "assimp-testmodels is not installed";
  const Expected<Mesh> mesh = load_mesh(*file);
  if (!mesh) GTEST_SKIP() << mesh.error().detail;
  const Expected<Solid> solid = try_solid(*mesh);
  ASSERT_TRUE(solid) << solid.error().detail;
  EXPECT_NO_THROW(solid->validate());
  EXPECT_EQ(solid->report.open_edges, 84u);
  EXPECT_EQ(solid->parts.size(), 3u);
}

TEST(RealMeshes, FilesThatNeedTheTolerantWeldCloseWithoutFilling) {
  std::size_t seen = 0;
  for (const char* name : {"featuretype.STL", "variants/strips_412_prims.gltf"}) {
    const auto file = find_test_mesh(name);
    if (!file) continue;
    const Expected<Mesh> mesh = load_mesh(*file);
    if (!mesh) continue;
    ++seen;
    const Expected<Solid> solid = try_solid(*mesh);
    ASSERT_TRUE(solid) << name;
    EXPECT_EQ(solid->report.fill_triangles, 0u) << name;
  }
  if (seen == 0) GTEST_SKIP() << "no test meshes";
}

TEST(RealMeshes, TheTwinsOfTheBarrelAreTheSameSolid) {
  const auto reference_file = find_test_mesh("kk_barrel_large.glb");
  if (!reference_file) GTEST_SKIP() << "kk_barrel_large.glb is absent";
  const Expected<Mesh> reference_mesh = load_mesh(*reference_file);
  if (!reference_mesh) GTEST_SKIP() << reference_mesh.error().detail;
  const Solid reference = *try_solid(*reference_mesh);
  const std::pair<const char*, double> twins[] = {
      {"formats/barrel_large.obj", 1e-5},       {"formats/barrel_large.fbx", 1e-5},
      {"variants/barrel_transforms.glb", 1e-5}, {"variants/barrel_unindexed.glb", 1e-5},
      {"variants/barrel_quantized.glb", 1e-3},  {"variants/barrel_meshopt.glb", 1e-3},
      {"variants/barrel_draco.glb", 1e-3}};
  for (const auto& [name, tolerance] : twins) {
    const auto file = find_test_mesh(name);
    if (!file) continue;
    const Expected<Mesh> mesh = load_mesh(*file);
    if (!mesh) continue;
    const Expected<Solid> solid = try_solid(*mesh);
    ASSERT_TRUE(solid) << name;
    EXPECT_EQ(solid->report.shells, reference.report.shells) << name;
    EXPECT_NEAR(solid->report.volume, reference.report.volume, tolerance * reference.report.volume) << name;
  }
}

}  // namespace
}  // namespace fracture::test
