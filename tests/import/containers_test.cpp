// Formats inside XML, ZIP and compressed streams, and files in several parts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include "common/import/preflight.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

/// A tetrahedron of volume 1/6 in XGL. It has decimals because Assimp takes the comma in "0,0" for a decimal
/// point.
const std::string kXgl =
    "<WORLD><MESH ID=\"0\"><P ID=\"0\">0.0,0.0,0.0</P><P ID=\"1\">1.0,0.0,0.0</P><P "
    "ID=\"2\">0.0,1.0,0.0</P><P ID=\"3\">0.0,0.0,1.0</P>"
    "<N ID=\"0\">0.0,0.0,1.0</N><MAT ID=\"0\"><AMB>1.0,1.0,1.0</AMB><DIFF>1.0,1.0,1.0</DIFF></MAT>"
    "<F><MATREF>0</MATREF><FV1><PREF>0</PREF><NREF>0</NREF></FV1><FV2><PREF>2</PREF><NREF>0</NREF></FV2>"
    "<FV3><PREF>1</PREF><NREF>0</NREF></FV3></F>"
    "<F><MATREF>0</MATREF><FV1><PREF>0</PREF><NREF>0</NREF></FV1><FV2><PREF>1</PREF><NREF>0</NREF></FV2>"
    "<FV3><PREF>3</PREF><NREF>0</NREF></FV3></F>"
    "<F><MATREF>0</MATREF><FV1><PREF>0</PREF><NREF>0</NREF></FV1><FV2><PREF>3</PREF><NREF>0</NREF></FV2>"
    "<FV3><PREF>2</PREF><NREF>0</NREF></FV3></F>"
    "<F><MATREF>0</MATREF><FV1><PREF>1</PREF><NREF>0</NREF></FV1><FV2><PREF>2</PREF><NREF>0</NREF></FV2>"
    "<FV3><PREF>3</PREF><NREF>0</NREF></FV3></F></MESH>"
    "<OBJECT><TRANSFORM><FORWARD>0.0,0.0,1.0</FORWARD><UP>0.0,1.0,0.0</UP><POSITION>0.0,0.0,0.0</POSITION></"
    "TRANSFORM>"
    "<MESHREF>0</MESHREF></OBJECT></WORLD>";

std::string deflated(const std::string& text) {
  uLongf size = compressBound(text.size());
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(text.data()),
           text.size());
  out.resize(size);
  return out;
}

std::string zstandard(const std::string& text) {
  std::string out(ZSTD_compressBound(text.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3));
  return out;
}

TEST(Containers, XglIsReadPlainAsXmlAndCompressed) {
  for (const auto& [bytes, format] : {std::pair{kXgl, MeshFormat::kXgl}, std::pair{kXgl, MeshFormat::kXml},
                                      std::pair{deflated(kXgl), MeshFormat::kZgl}}) {
    const Expected<Mesh> mesh = import_text(bytes, format);
    ASSERT_TRUE(mesh) << extension_of(format) << mesh.error().detail;
    EXPECT_EQ(mesh->triangles.size(), 4u);
    EXPECT_NEAR(signed_volume(*mesh), 1.0 / 6, 1e-7);
  }
}

TEST(Containers, CompressedFilesAreOpenedUpToTheLimit) {
  ImportLimits limits;
  limits.max_decoded_bytes = 1u << 20;
  const std::string bomb(8u << 20, ' ');
  EXPECT_EQ(import_text(deflated(bomb), MeshFormat::kZgl, limits).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(import_text(zstandard(bomb), MeshFormat::kBlend, limits).error().code, ErrorCode::kTooLarge);
  const std::string whole = zstandard("BLENDER no more");
  EXPECT_EQ(import_text(whole.substr(0, whole.size() - 3), MeshFormat::kBlend).error().code,
            ErrorCode::kMalformedMesh);
  // Two frames, as Blender writes them. Both are opened, and the content is not a Blender file.
  const Expected<Mesh> other = import_text(zstandard("SOMETHING") + zstandard(" ELSE"), MeshFormat::kBlend);
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().detail, HasSubstr("SOMETHING ELSE"));
}

TEST(Containers, XmlIsToldApartByItsRootElement) {
  const auto kind = [](std::string_view text) { return preflight::kind_of_xml(bytes_of(text)); };
  EXPECT_EQ(*kind("<?xml version=\"1.0\"?><!-- <a> --><COLLADA x='>'><b/></COLLADA>"), MeshFormat::kDae);
  EXPECT_EQ(*kind("<irr_scene>"), MeshFormat::kIrr);
  EXPECT_EQ(*kind("<mesh xmlns=\"http://irrlicht\"><boundingBox/><buffer>"), MeshFormat::kIrrmesh);
  EXPECT_EQ(*kind("<mesh><sharedgeometry vertexcount=\"3\">"), MeshFormat::kXml);
  EXPECT_EQ(kind("<svg width=\"1\">").error().code, ErrorCode::kUnsupportedFeature);
  EXPECT_THAT(kind("<svg width=\"1\">").error().detail, HasSubstr("<svg>"));
  for (const char* none : {"", "no tag", "<!-- never ends", "<?xml "})
    EXPECT_EQ(kind(none).error().code, ErrorCode::kMalformedMesh) << none;
}

TEST(Containers, DeepXmlIsRefusedBeforeAnyReader) {
  std::string deep;
  for (int k = 0; k < 100'000; ++k) deep += "<a>";
  const Expected<Mesh> mesh = import_text("<X3D>" + deep, MeshFormat::kX3d);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kMalformedMesh);
  EXPECT_THAT(mesh.error().detail, HasSubstr("nested deeper than 1000 levels at byte 3002"));
  std::string wide;
  for (int k = 0; k < 5'000; ++k) wide += "<a x='/>'><b/></a><!-- <c> --><![CDATA[<d>]]>";
  EXPECT_TRUE(preflight::check_xml_depth(bytes_of(wide)));
}

/// A ZIP archive with one empty entry whose directory declares `size` bytes.
std::string zip_declaring(std::uint32_t size) {
  std::string zip = "PK\x01\x02";
  zip.append(20, '\0');
  put<std::uint32_t>(zip, {size});
  zip.append(18, '\0');
  const auto directory = static_cast<std::uint32_t>(zip.size());
  zip += "PK\x05\x06";
  put<std::uint16_t>(zip, {0, 0, 1, 1});
  put<std::uint32_t>(zip, {directory, 0});
  put<std::uint16_t>(zip, {0});
  return zip;
}

TEST(Containers, ZipArchivesMayNotDeclareMoreThanTheLimit) {
  const auto code = [](const std::string& file) {
    const auto checked = preflight::check_zip(bytes_of(file), {});
    return checked ? ErrorCode::kInternal : checked.error().code;
  };
  EXPECT_EQ(code(zip_declaring(1000)), ErrorCode::kInternal) << "no error";
  EXPECT_EQ(code(zip_declaring(0xfffffff0)), ErrorCode::kTooLarge);
  const std::string good = zip_declaring(1000);
  EXPECT_EQ(code(good.substr(0, good.size() - 1)), ErrorCode::kMalformedMesh) << "truncated";
  EXPECT_EQ(code("PK"), ErrorCode::kMalformedMesh);
  EXPECT_EQ(code(std::string(200, 'x')), ErrorCode::kMalformedMesh);
  std::string lying = good;
  lying[good.size() - 22 + 10] = 9;  // entries in the directory
  EXPECT_EQ(code(lying), ErrorCode::kMalformedMesh);
}

TEST(Containers, AnOgreMeshInXmlIsRead) {
  const std::string ogre =
      "<mesh><submeshes><submesh material=\"m\" usesharedvertices=\"false\" use32bitindexes=\"false\" "
      "operationtype=\"triangle_list\"><faces count=\"4\"><face v1=\"0\" v2=\"2\" v3=\"1\"/>"
      "<face v1=\"0\" v2=\"1\" v3=\"3\"/><face v1=\"0\" v2=\"3\" v3=\"2\"/><face v1=\"1\" v2=\"2\" "
      "v3=\"3\"/></faces>"
      "<geometry vertexcount=\"4\"><vertexbuffer positions=\"true\"><vertex><position x=\"0\" y=\"0\" "
      "z=\"0\"/></vertex>"
      "<vertex><position x=\"1\" y=\"0\" z=\"0\"/></vertex><vertex><position x=\"0\" y=\"1\" "
      "z=\"0\"/></vertex>"
      "<vertex><position x=\"0\" y=\"0\" "
      "z=\"1\"/></vertex></vertexbuffer></geometry></submesh></submeshes></mesh>";
  const Expected<Mesh> mesh = import_text(ogre, MeshFormat::kXml);
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_NEAR(signed_volume(*mesh), 1.0 / 6, 1e-7);
}

}  // namespace
}  // namespace fracture::test
