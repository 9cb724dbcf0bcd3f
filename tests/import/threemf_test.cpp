// 3MF packages: ZIP64, parts in several files, slicer projects, units, materials, and damage.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <string>
#include <utility>
#include <vector>

#include "common/import/zip_archive.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct PackedFile {
  std::string name, text;
};

enum class Zip { kPlain, kZip64, kDeflated };

std::string deflated_raw(const std::string& text) {
  z_stream stream{};
  deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, static_cast<uLong>(text.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// An archive by the letter of APPNOTE. With ZIP64, sizes, positions and counts are only in the 64-bit records.
std::string zip_of(const std::vector<PackedFile>& files, Zip kind = Zip::kPlain) {
  const bool is_64 = kind == Zip::kZip64;
  constexpr std::uint32_t kElsewhere = 0xffffffff;
  std::string zip, directory;
  for (const PackedFile& file : files) {
    const std::string packed = kind == Zip::kDeflated ? deflated_raw(file.text) : file.text;
    const std::uint16_t method = kind == Zip::kDeflated ? 8 : 0,
                        name = static_cast<std::uint16_t>(file.name.size());
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(file.text.data()), static_cast<uInt>(file.text.size())));
    const auto size = static_cast<std::uint32_t>(file.text.size()),
               packed_size = static_cast<std::uint32_t>(packed.size()),
               header = static_cast<std::uint32_t>(zip.size());
    std::string sizes_64;
    put<std::uint16_t>(sizes_64, {1, 16});
    put<std::uint64_t>(sizes_64, {size, packed_size});
    zip += "PK\x03\x04";
    put<std::uint16_t>(zip, {45, 0, method, 0, 0});
    put<std::uint32_t>(zip, {crc, is_64 ? kElsewhere : packed_size, is_64 ? kElsewhere : size});
    put<std::uint16_t>(zip, {name, static_cast<std::uint16_t>(is_64 ? sizes_64.size() : 0)});
    zip += file.name + (is_64 ? sizes_64 : "") + packed;
    std::string extra;
    if (is_64) {
      put<std::uint16_t>(extra, {0x7075, 1});  // another field comes first
      extra += 'x';
      put<std::uint16_t>(extra, {1, 24});
      put<std::uint64_t>(extra, {size, packed_size, header});
    }
    directory += "PK\x01\x02";
    put<std::uint16_t>(directory, {45, 45, 0, method, 0, 0});
    put<std::uint32_t>(directory, {crc, is_64 ? kElsewhere : packed_size, is_64 ? kElsewhere : size});
    put<std::uint16_t>(directory, {name, static_cast<std::uint16_t>(extra.size()), 0, 0, 0});
    put<std::uint32_t>(directory, {0, is_64 ? kElsewhere : header});
    directory += file.name + extra;
  }
  const auto at = static_cast<std::uint32_t>(zip.size()),
             length = static_cast<std::uint32_t>(directory.size());
  const auto count = static_cast<std::uint16_t>(files.size());
  zip += directory;
  if (is_64) {
    const std::uint64_t end = zip.size();
    zip += "PK\x06\x06";
    put<std::uint64_t>(zip, {44});
    put<std::uint16_t>(zip, {45, 45});
    put<std::uint32_t>(zip, {0, 0});
    put<std::uint64_t>(zip, {count, count, length, at});
    zip += "PK\x06\x07";
    put<std::uint32_t>(zip, {0});
    put<std::uint64_t>(zip, {end});
    put<std::uint32_t>(zip, {1});
  }
  const auto counted = static_cast<std::uint16_t>(is_64 ? 0xffff : count);
  zip += "PK\x05\x06";
  put<std::uint16_t>(zip, {0, 0, counted, counted});
  put<std::uint32_t>(zip, {is_64 ? kElsewhere : length, is_64 ? kElsewhere : at});
  put<std::uint16_t>(zip, {0});
  return zip;
}

/// A tetrahedron with edges of length 3 along the axes: volume 4.5.
const std::string kVertices =
    "<vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"3\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"+3.0\" z=\"0\"/>"
    "<vertex x=\"0\" y=\"0\" z=\"3e0\"/></vertices>";
const std::string kTriangles =
    "<triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/><triangle v1=\"0\" v2=\"3\" "
    "v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/></triangles>";
const std::string kMesh = "<mesh>" + kVertices + kTriangles + "</mesh>";
const std::string kObject = "<object id=\"1\" name=\"a &amp; b\" type=\"model\">" + kMesh + "</object>";

std::string model(const std::string& resources, const std::string& build,
                  const std::string& attributes = "") {
  return "<?xml version=\"1.0\"?><model " + attributes +
         " xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\"><resources>" +
         resources + "</resources><build>" + build + "</build></model>";
}
const std::string kModel = model(kObject, "<item objectid=\"1\"/>");
const std::string kRelationships =
    "<Relationships><Relationship Id=\"r0\" Type=\"http://schemas.openxmlformats.org/package/2006/relationships/metadata/"
    "thumbnail\" Target=\"/a.png\"/><Relationship Id=\"r1\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" Target=\"/3D/other.model\"/></Relationships>";

Expected<Mesh> import_package(const std::vector<PackedFile>& files, Zip kind = Zip::kPlain) {
  return import_text(zip_of(files, kind), MeshFormat::k3mf);
}
Expected<Mesh> import_model(const std::string& text) { return import_package({{"3D/3dmodel.model", text}}); }

TEST(ThreeMf, IsReadFromEachKindOfArchive) {
  for (const Zip kind : {Zip::kPlain, Zip::kZip64, Zip::kDeflated}) {
    const Expected<Mesh> mesh =
        import_package({{"[Content_Types].xml", "<Types/>"}, {"3D/3dmodel.model", kModel}}, kind);
    ASSERT_TRUE(mesh) << static_cast<int>(kind) << mesh.error().detail;
    EXPECT_NEAR(signed_volume(*mesh), 4.5, 1e-9);
    EXPECT_EQ(mesh->triangles.size(), 4u);
    EXPECT_THAT(mesh->node_names, ElementsAre("a & b"));
    EXPECT_EQ(mesh->frame.metres, 1e-3);
    EXPECT_TRUE(mesh->frame.metres_stated);
    EXPECT_TRUE(mesh->frame.z_up);
    EXPECT_TRUE(mesh->frame.up_stated);
  }
}

TEST(ThreeMf, StatesItsUnit) {
  const std::pair<const char*, double> units[] = {{"micron", 1e-6}, {"inch", 0.0254}, {"meter", 1}};
  for (const auto& [unit, metres] : units) {
    const auto mesh =
        import_model(model(kObject, "<item objectid=\"1\"/>", std::string("unit=\"") + unit + "\""));
    ASSERT_TRUE(mesh) << unit;
    EXPECT_EQ(mesh->frame.metres, metres) << unit;
  }
  const auto wrong = import_model(model(kObject, "<item objectid=\"1\"/>", "unit=\"cubit\""));
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().detail, HasSubstr("cubit"));
}

// Bambu Studio and OrcaSlicer keep each object in a separate file.
TEST(ThreeMf, ComponentsInOtherPartsAreFound) {
  const std::string root = model(
      "<object id=\"2\" name=\"pair\" type=\"model\"><components>"
      "<component p:path=\"/3D/Objects/object_1.model\" objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/>"
      "<component p:path=\"/3D/Objects/object_1.model\" objectid=\"1\" transform=\"-2 0 0 0 2 0 0 0 2 0 0 0\"/>"
      "</components></object>",
      "<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 0 0 5\"/>", "requiredextensions=\"p\"");
  const Expected<Mesh> mesh = import_package(
      {{"_rels/.rels", kRelationships}, {"3D/other.model", root}, {"3D/objects/Object_1.model", kModel}});
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_NEAR(signed_volume(*mesh), 4.5 + 8 * 4.5, 1e-6) << "the mirrored one still faces outwards";
  EXPECT_THAT(mesh->node_names, ElementsAre("a & b", "a & b"));
  ASSERT_EQ(mesh->groups.size(), 1u);
  EXPECT_EQ(mesh->groups[0].name, "pair");
  EXPECT_EQ(mesh->positions[0].x, 10);
  EXPECT_EQ(mesh->positions[0].z, 5);
  EXPECT_EQ(mesh->positions[5].x, -6) << "vertex 1 of the second one";
}

TEST(ThreeMf, VolumesThatASlicerDoesNotPrintAreLeftOut) {
  const std::string two = "<object id=\"1\"><mesh><vertices>" + kVertices.substr(10, kVertices.size() - 21) +
                          "<vertex x=\"9\" y=\"0\" z=\"0\"/></vertices><triangles>" +
                          kTriangles.substr(11, kTriangles.size() - 23) +
                          kTriangles.substr(11, kTriangles.size() - 23) + "</triangles></mesh></object>";
  const std::string config =
      "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"3\"><metadata type=\"volume\" key=\"volume_type\" "
      "value=\"ModelPart\"/></volume><volume firstid=\"4\" lastid=\"7\"><metadata type=\"volume\" key=\"volume_type\" "
      "value=\"ParameterModifier\"/></volume></object></config>";
  const auto mesh = import_package({{"3D/3dmodel.model", model(two, "<item objectid=\"1\"/>")},
                                    {"Metadata/Slic3r_PE_model.config", config}});
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->triangles.size(), 4u);
  ASSERT_EQ(mesh->remarks.notes.size(), 1u);
  EXPECT_THAT(mesh->remarks.notes[0], HasSubstr("1 object or volume was left out"));

  const std::string parts = model(kObject + "<object id=\"3\" type=\"model\">" + kMesh +
                                      "</object><object id=\"4\" type=\"support\">" + kMesh + "</object>",
                                  "<item objectid=\"1\"/><item objectid=\"3\"/><item objectid=\"4\"/>");
  const auto bambu =
      import_package({{"3D/3dmodel.model", parts},
                      {"Metadata/model_settings.config",
                       "<config><object id=\"9\"><part id=\"1\" subtype=\"normal_part\"/><part id=\"3\" "
                       "subtype=\"negative_part\"/></object></config>"}});
  ASSERT_TRUE(bambu) << bambu.error().detail;
  EXPECT_EQ(bambu->triangles.size(), 4u);
  EXPECT_THAT(bambu->remarks.notes, ElementsAre(HasSubstr("2 objects or volumes were left out")));
}

TEST(ThreeMf, MaterialsAndColoursBecomeMaterials) {
  const std::string resources =
      "<basematerials id=\"5\"><base name=\"Red\" displaycolor=\"#FF0000\"/><base name=\"Glass\" "
      "displaycolor=\"#FFFFFF80\"/></basematerials><m:colorgroup id=\"6\"><m:color color=\"#0000FFFF\"/></m:colorgroup>"
      "<object id=\"1\" pid=\"5\" pindex=\"1\"><mesh>" +
      kVertices +
      "<triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\" p1=\"0\"/>"
      "<triangle v1=\"0\" v2=\"3\" v3=\"2\" pid=\"6\" p1=\"0\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\" pid=\"5\" "
      "p1=\"0\"/></triangles></mesh></object>";
  const auto mesh = import_model(model(resources, "<item objectid=\"1\"/>"));
  ASSERT_TRUE(mesh) << mesh.error().detail;
  const auto& materials = mesh->library->materials;
  ASSERT_EQ(materials.size(), 3u);
  EXPECT_THAT(mesh->material, ElementsAre(0u, 1u, 2u, 1u));
  EXPECT_EQ(materials[0].at("name"), "Glass");
  EXPECT_EQ(materials[0].at("alphaMode"), "BLEND");
  EXPECT_EQ(materials[1].at("name"), "Red");
  EXPECT_EQ(materials[1].at("pbrMetallicRoughness").at("baseColorFactor"), nlohmann::json({1, 0, 0, 1}));
  EXPECT_EQ(materials[2].at("pbrMetallicRoughness").at("baseColorFactor"), nlohmann::json({0, 0, 1, 1}));
}

TEST(ThreeMf, TexturesGiveUvs) {
  const std::string resources =
      "<m:texture2d id=\"7\" path=\"/3D/a.png\" contenttype=\"image/png\"/><m:texture2dgroup id=\"8\" texid=\"7\">"
      "<m:tex2coord u=\"0\" v=\"0\"/><m:tex2coord u=\"1\" v=\"0\"/><m:tex2coord u=\"0\" v=\"0.75\"/></m:texture2dgroup>"
      "<object id=\"1\"><mesh>" +
      kVertices +
      "<triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\" pid=\"8\" p1=\"0\" p2=\"2\" p3=\"1\"/><triangle v1=\"0\" v2=\"1\" "
      "v3=\"3\"/><triangle v1=\"0\" v2=\"3\" v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/></triangles></mesh></object>";
  const std::string png = "\x89PNG\r\n\x1a\n";
  const auto mesh =
      import_package({{"3D/3dmodel.model", model(resources, "<item objectid=\"1\"/>")}, {"3D/a.png", png}});
  ASSERT_TRUE(mesh) << mesh.error().detail;
  ASSERT_EQ(mesh->attributes.uvs.size(), 1u);
  const auto& uvs = mesh->attributes.uvs[0];
  const auto [a, b, c] = mesh->triangles[0];
  EXPECT_EQ(uvs[a].y, 1);
  EXPECT_EQ(uvs[b].y, 0.25f);
  EXPECT_EQ(uvs[c].x, 1);
  EXPECT_EQ(mesh->library->images.size(), 1u);
  EXPECT_NEAR(signed_volume(*mesh), 4.5, 1e-9);
}

TEST(ThreeMf, WhatIsWrongIsNamed) {
  const struct {
    std::string model;
    ErrorCode code;
    const char* detail;
  } cases[] = {
      {"<nothing/>", ErrorCode::kMalformedMesh, "no <model> element"},
      {model(kObject, ""), ErrorCode::kEmptyMesh, "no build items"},
      {model(kObject, "<item objectid=\"7\"/>"), ErrorCode::kMalformedMesh, "object 7"},
      {model("<object id=\"1\"><components><component objectid=\"1\"/></components></object>",
             "<item objectid=\"1\"/>"),
       ErrorCode::kMalformedMesh, "contains itself"},
      {model(
           "<object id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"zero\" z=\"0\"/></vertices></mesh></object>",
           ""),
       ErrorCode::kMalformedMesh, "'y' must be a number; it is 'zero'"},
      {model("<object id=\"1\"><mesh>" + kVertices +
                 "<triangles><triangle v1=\"0\" v2=\"9\" v3=\"1\"/></triangles></mesh></object>",
             ""),
       ErrorCode::kMalformedMesh, "refers to vertex 9; the object has 4 vertices"},
      {model(
           kObject, "<item objectid=\"1\"/>",
           "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" requiredextensions=\"p b\""),
       ErrorCode::kUnsupportedFeature, "beamlattice/2017/02"},
      {model(
           "<object id=\"1\"><components><component p:path=\"/3D/absent.model\" objectid=\"1\"/></components></object>",
           "<item objectid=\"1\"/>"),
       ErrorCode::kMalformedMesh, "does not contain the file \"3D/absent.model\""},
  };
  for (const auto& c : cases) {
    const auto mesh = import_model(c.model);
    ASSERT_FALSE(mesh) << c.detail;
    EXPECT_EQ(mesh.error().code, c.code) << mesh.error().detail;
    EXPECT_THAT(mesh.error().detail, HasSubstr(c.detail));
  }
}

// Each object has ten of the next one, and the last one is empty.
TEST(ThreeMf, InstancesOfEmptyObjectsAreLimited) {
  std::string resources = "<object id=\"1\"/>";
  for (int k = 2; k < 12; ++k) {
    resources += "<object id=\"" + std::to_string(k) + "\"><components>";
    for (int i = 0; i < 10; ++i) resources += "<component objectid=\"" + std::to_string(k - 1) + "\"/>";
    resources += "</components></object>";
  }
  const auto mesh = import_model(model(resources, "<item objectid=\"11\"/>"));
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kTooLarge) << mesh.error().detail;
}

TEST(ThreeMf, VolumesThatAreLeftOutCountEachTime) {
  std::string resources = "<object id=\"1\"><mesh>" + kVertices.substr(0, kVertices.size() - 11);
  for (int k = 0; k < 3000; ++k) resources += "<vertex x=\"0\" y=\"0\" z=\"0\"/>";
  resources += "</vertices>" + kTriangles + "</mesh></object>";
  for (int k = 2; k < 8; ++k) {
    resources += "<object id=\"" + std::to_string(k) + "\"><components>";
    for (int i = 0; i < 10; ++i) resources += "<component objectid=\"" + std::to_string(k - 1) + "\"/>";
    resources += "</components></object>";
  }
  const std::string config =
      "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"3\"><metadata type=\"volume\" key=\"modifier\" "
      "value=\"1\"/></volume></object></config>";
  const auto mesh = import_package({{"3D/3dmodel.model", model(resources, "<item objectid=\"7\"/>")},
                                    {"Metadata/Slic3r_PE_model.config", config}});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(mesh.error().detail, HasSubstr("200,000,000 vertices and triangles"));
}

TEST(ThreeMf, FarItemsAreReadRelativeToAnOffset) {
  // The box's centre (500001.5, 4649777.5, 31.5), rounded to multiples of 4, the power of two above the longest side of 3.
  const auto mesh = import_model(
      model(kObject, "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 500000 4649776 30\"/>"));
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->frame.offset, (Vec3d{500000, 4649776, 32}));
  Box box;
  for (const Vec3f& p : mesh->positions) box.add(to_double(p));
  EXPECT_EQ(box.min, (Vec3d{0, 0, -2}));
  EXPECT_EQ(box.max, (Vec3d{3, 3, 1}));
  EXPECT_DOUBLE_EQ(signed_volume(*mesh), 4.5);
  EXPECT_EQ(import_model(kModel)->frame.offset, Vec3d{});
}

TEST(ThreeMf, LongNamesAreCutAtACharacter) {
  const std::string name(999, 'a');
  const auto mesh =
      import_model(model("<object id=\"1\" name=\"" + name + "\xc3\xa4 and more\">" + kMesh + "</object>",
                         "<item objectid=\"1\"/>"));
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_THAT(mesh->node_names, ElementsAre(name));
}

TEST(ThreeMf, ATextureUnderTwoSpellingsIsReadOnce) {
  const std::string resources =
      "<m:texture2d id=\"7\" path=\"/3D/a.png\"/><m:texture2d id=\"9\" path=\"/3D/A.PNG\"/>"
      "<m:texture2dgroup id=\"8\" texid=\"7\"><m:tex2coord u=\"0\" v=\"0\"/></m:texture2dgroup>"
      "<m:texture2dgroup id=\"10\" texid=\"9\"><m:tex2coord u=\"0\" v=\"0\"/></m:texture2dgroup>"
      "<object id=\"1\"><mesh>" +
      kVertices +
      "<triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\" pid=\"8\" p1=\"0\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\" "
      "pid=\"10\" p1=\"0\"/></triangles></mesh></object>";
  const auto mesh = import_package(
      {{"3D/3dmodel.model", model(resources, "<item objectid=\"1\"/>")}, {"3D/a.png", "\x89PNG\r\n\x1a\n"}});
  ASSERT_TRUE(mesh) << mesh.error().detail;
  EXPECT_EQ(mesh->library->materials.size(), 2u);
  EXPECT_EQ(mesh->library->images.size(), 1u);
}

TEST(ZipArchive, DamageIsNoticed) {
  const std::string good = zip_of({{"a", "some text"}}, Zip::kZip64);
  const auto entries = read_zip_directory(bytes_of(good), 1000);
  ASSERT_TRUE(entries) << entries.error().detail;
  ASSERT_EQ(entries->size(), 1u);
  EXPECT_EQ((*entries)[0].name, "a");
  EXPECT_EQ((*entries)[0].size, 9u);
  EXPECT_TRUE(unzip(bytes_of(good), (*entries)[0], 1000));
  EXPECT_EQ(unzip(bytes_of(good), (*entries)[0], 8).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(read_zip_directory(bytes_of(good), 8).error().code, ErrorCode::kTooLarge);
  for (std::size_t size = 0; size < good.size(); ++size) {
    const std::string cut = good.substr(0, size);
    EXPECT_FALSE(read_zip_directory(bytes_of(cut), 1000)) << size;
  }
  std::string changed = good;
  changed[changed.find("some text")] = 'S';
  const auto directory = read_zip_directory(bytes_of(changed), 1000);
  ASSERT_TRUE(directory);
  const auto text = unzip(bytes_of(changed), (*directory)[0], 1000);
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().detail, HasSubstr("checksum"));
  // No change of a byte leads beyond the archive (checked by the sanitizers).
  for (std::size_t k = 0; k < good.size(); ++k)
    for (const char value : {'\0', '\x7f', '\xff'}) {
      std::string other = good;
      other[k] = value;
      if (const auto found = read_zip_directory(bytes_of(other), 1000))
        for (const ZipEntry& entry : *found) (void)unzip(bytes_of(other), entry, 1000);
    }
}

}  // namespace
}  // namespace fracture::test
