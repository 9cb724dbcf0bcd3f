// Materials that are far larger than a game could use. Their extras are dropped first. If that is not enough,
// they are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/json_reader.hpp"
#include "common/base/words.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

/// Imports a GLB with this text as its material. Building it as a JSON value here would take as much memory
/// as the importer needs.
Expected<Mesh> import_with_material(const std::string& material) {
  Tetrahedron tet;
  tet.json["materials"] = {"MATERIAL"};
  tet.json["meshes"][0]["primitives"][0]["material"] = 0;
  std::string text = tet.json.dump();
  text.replace(text.find("\"MATERIAL\""), 10, material);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string glb = "glTF";
  put<std::uint32_t>(glb, {2, static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + tet.binary.size()),
                           static_cast<std::uint32_t>(text.size()), 0x4e4f534a});
  glb += text;
  put<std::uint32_t>(glb, {static_cast<std::uint32_t>(tet.binary.size()), 0x004e4942});
  glb += tet.binary;
  return import_text(glb, MeshFormat::kGlb);
}

std::string list_of(const std::string& item, std::size_t count) {
  std::string text = "[" + item;
  for (std::size_t k = 1; k < count; ++k) text += "," + item;
  return text + "]";
}

std::size_t held_by(const Mesh& mesh) {
  return json_bytes(mesh.library->materials) + json_bytes(mesh.library->textures) +
         json_bytes(mesh.library->samplers);
}

TEST(MaterialLimits, ExtrasOfAUsualSizeAreKept) {
  const auto mesh =
      import_with_material(R"({"name": "m", "extras": {"list": )" + list_of("0.5", 10'000) + "}}");
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->library->materials[0]["extras"]["list"].size(), 10'000u);
}

TEST(MaterialLimits, ExtrasOfFourMillionElementsAreDroppedWithAWarning) {
  const auto mesh =
      import_with_material(R"({"name": "m", "extras": )" + list_of("0", sized(2'200'000u, 4'000'000u)) + "}");
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->library->materials[0]["name"], "m");
  EXPECT_FALSE(mesh->library->materials[0].contains("extras"));
  EXPECT_THAT(mesh->remarks.warnings, Contains(AllOf(HasSubstr("extras"), HasSubstr("32 MiB"))));
  EXPECT_LT(held_by(*mesh), 10'000u);
}

TEST(MaterialLimits, MaterialsThatHoldTooMuchElsewhereAreRefused) {
  const auto mesh = import_with_material(R"({"name": "m", "extensions": {"KHR_materials_x": {"a": )" +
                                         list_of("{}", sized(600'000u, 1'000'000u)) + "}}}");
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(mesh.error().detail, HasSubstr(data_size(kMaxLibraryBytes)));
}

}  // namespace
}  // namespace fracture::test
