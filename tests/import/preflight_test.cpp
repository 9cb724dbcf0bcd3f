// The statements of a file about itself are checked before a parser relies on them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/import/make_files.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

Error refused(std::string_view bytes, MeshFormat format, const ImportLimits& limits = {}) {
  const Expected<Mesh> mesh = import_text(bytes, format, limits);
  EXPECT_FALSE(mesh);
  return mesh ? Error{ErrorCode::kInternal, "imported", {}, {}} : mesh.error();
}

std::string binary_stl(std::uint32_t declared, std::size_t triangles) {
  std::string stl(80, ' ');
  put<std::uint32_t>(stl, {declared});
  for (std::size_t t = 0; t < triangles; ++t) {
    put<float>(stl, {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(t)});
    put<std::uint16_t>(stl, {0});
  }
  return stl;
}

TEST(Preflight, EmptyBodyIsNamedForEveryFormat) {
  for (const char* extension : {"glb", "gltf", "obj", "stl", "ply", "off", "blend", "fbx", "dae", "3ds"})
    EXPECT_EQ(refused("", *format_from_extension(extension)).code, ErrorCode::kEmptyBody) << extension;
}

TEST(Preflight, TextCalledGlbSaysWhatItIs) {
  Error error = refused("Dear Sir or Madam, this is a letter.", MeshFormat::kGlb);
  EXPECT_EQ(error.code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(error.detail, HasSubstr("Dear Sir"));
  error = refused("  {\"asset\": {\"version\": \"2.0\"}}", MeshFormat::kGlb);
  EXPECT_THAT(error.detail, HasSubstr("send it as format gltf"));
  error = refused(Tetrahedron().glb(), MeshFormat::kGltf);
  EXPECT_THAT(error.detail, HasSubstr("send it as format glb"));
}

TEST(Preflight, GlbTruncatedAtEveryLengthIsRefused) {
  const std::string glb = Tetrahedron().glb();
  for (std::size_t length = 1; length < glb.size(); ++length)
    EXPECT_EQ(refused(glb.substr(0, length), MeshFormat::kGlb).code, ErrorCode::kMalformedMesh) << length;
}

TEST(Preflight, GlbWithAnyByteChangedNeverCrashes) {
  const std::string glb = Tetrahedron().glb();
  for (std::size_t at = 0; at < glb.size(); ++at) {
    std::size_t turn = 0;
    for (const char c : {'\0', '\xff', '9', '['}) {
      if (!has_turn(at, turn++, 4)) continue;
      std::string changed = glb;
      changed[at] = c;
      const Expected<Mesh> mesh = import_text(changed, MeshFormat::kGlb);
      if (mesh)
        EXPECT_LE(mesh->triangles.size(), 4u);
      else
        EXPECT_FALSE(mesh.error().detail.empty());
    }
  }
}

TEST(Preflight, GlbChunkThatLiesAboutItsLengthIsRefusedWithTheByte) {
  std::string glb = Tetrahedron().glb();
  for (const char c : {'\x7f', '\xff'}) {
    glb[15] = c;
    EXPECT_THAT(refused(glb, MeshFormat::kGlb).detail, HasSubstr("byte 12"));
  }
}

TEST(Preflight, DeeplyNestedJsonIsRefusedWithoutRecursion) {
  const std::string deep(400'000, '[');
  Error error = refused(deep, MeshFormat::kGltf);
  EXPECT_EQ(error.code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(error.detail, HasSubstr("deeper than 64"));
  std::string glb;
  put<std::uint32_t>(glb, {0x46546c67u, 2u, 20u + 400'000u, 400'000u, 0x4e4f534au});
  EXPECT_THAT(refused(glb + deep, MeshFormat::kGlb).detail, HasSubstr("deeper than 64"));
}

TEST(Preflight, BracketsInStringsAreNotDepth) {
  Tetrahedron tet;
  tet.json["extras"] = std::string(1000, '[') + "\\\"";
  EXPECT_TRUE(import_text(tet.glb(), MeshFormat::kGlb));
}

TEST(Preflight, BinaryStlMustHaveExactlyWhatItDeclares) {
  EXPECT_TRUE(import_text(binary_stl(4, 4), MeshFormat::kStl));
  for (const std::uint32_t lie : {3u, 5u, 0x80000000u, 0xffffffffu}) {
    const Error error = refused(binary_stl(lie, 4), MeshFormat::kStl);
    EXPECT_EQ(error.code, ErrorCode::kMalformedMesh) << lie;
    EXPECT_THAT(error.detail, HasSubstr(std::to_string(lie)));
  }
  EXPECT_EQ(refused(binary_stl(0, 0), MeshFormat::kStl).code, ErrorCode::kEmptyMesh);
}

TEST(Preflight, BinaryStlWhoseHeaderSaysSolidIsStillBinary) {
  std::string stl = binary_stl(4, 4);
  stl.replace(0, 5, "solid");
  EXPECT_TRUE(import_text(stl, MeshFormat::kStl));
}

TEST(Preflight, PlyCountsHaveToFitInTheFile) {
  const auto ply = [](const std::string& vertices, const std::string& faces, const std::string& format) {
    return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  };
  EXPECT_TRUE(import_text(ply("3", "1", "ascii"), MeshFormat::kPly));
  for (const char* lie : {"10000000", "4294967295", "18446744073709551615"}) {
    EXPECT_EQ(refused(ply(lie, "1", "ascii"), MeshFormat::kPly).code, ErrorCode::kMalformedMesh) << lie;
    EXPECT_EQ(refused(ply("3", lie, "ascii"), MeshFormat::kPly).code, ErrorCode::kMalformedMesh) << lie;
    EXPECT_EQ(refused(ply(lie, "1", "binary_little_endian"), MeshFormat::kPly).code,
              ErrorCode::kMalformedMesh)
        << lie;
  }
  EXPECT_EQ(refused(ply("-3", "1", "ascii"), MeshFormat::kPly).code, ErrorCode::kMalformedMesh);
  EXPECT_EQ(refused(ply("3", "0", "ascii"), MeshFormat::kPly).code, ErrorCode::kEmptyMesh);
}

TEST(Preflight, OffCountsHaveToFitInTheFile) {
  EXPECT_TRUE(import_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", MeshFormat::kOff));
  for (const char* counts : {"1000000000 1 0", "3 1000000000 0", "18446744073709551615 1 0"})
    EXPECT_EQ(
        refused("OFF\n" + std::string(counts) + "\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", MeshFormat::kOff).code,
        ErrorCode::kMalformedMesh)
        << counts;
}

TEST(Preflight, FilesOfAnotherKindAreRefusedByWhatTheyBeginWith) {
  const std::string glb = Tetrahedron().glb();
  for (const char* extension : {"obj", "stl", "ply", "off", "blend", "fbx", "dae", "3ds"})
    EXPECT_EQ(refused(glb, *format_from_extension(extension)).code, ErrorCode::kMalformedMesh) << extension;
}

TEST(Preflight, FaceLimitIsCheckedBeforeParsing) {
  ImportLimits limits;
  limits.max_triangles = 3;
  EXPECT_EQ(refused(binary_stl(4, 4), MeshFormat::kStl, limits).code, ErrorCode::kTooLarge);
  std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int k = 0; k < 4; ++k) obj += "f 1 2 3\n";
  EXPECT_EQ(refused(obj, MeshFormat::kObj, limits).code, ErrorCode::kTooLarge);
}

TEST(Formats, NamesAreFoundWhateverTheirCase) {
  EXPECT_EQ(format_from_extension("GLB"), MeshFormat::kGlb);
  EXPECT_EQ(format_from_extension("Stl"), MeshFormat::kStl);
  EXPECT_EQ(format_from_extension("exe"), std::nullopt);
  EXPECT_EQ(format_from_media_type("model/gltf-binary"), MeshFormat::kGlb);
  EXPECT_EQ(format_from_media_type("Model/OBJ; charset=utf-8"), MeshFormat::kObj);
  EXPECT_EQ(format_from_media_type("text/html"), std::nullopt);
  EXPECT_TRUE(enabled_by_default(MeshFormat::kPly));
  EXPECT_FALSE(enabled_by_default(MeshFormat::kBlend));
}

}  // namespace
}  // namespace fracture::test
