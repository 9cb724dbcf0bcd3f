// Compares the table of formats with the linked Assimp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <assimp/BaseImporter.h>

#include <assimp/Importer.hpp>
#include <set>

#include "tests/import/make_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

TEST(Formats, EveryExtensionThatAssimpReadsIsARow) {
  Assimp::Importer importer;
  for (std::size_t k = 0; k < importer.GetImporterCount(); ++k) {
    std::set<std::string> extensions;
    importer.GetImporter(k)->GetExtensionList(extensions);
    for (const std::string& extension : extensions) {
      const std::string last = extension.substr(extension.rfind('.') + 1);  // Ogre: mesh.xml
      EXPECT_TRUE(format_from_extension(last)) << extension;
    }
  }
}

TEST(Formats, RowsAreTheEnumInOrderWithNamesAndMediaTypesOfTheirOwn) {
  std::set<std::string> names, types;
  std::size_t row = 0;
  for (const FormatInfo& f : all_formats()) {
    EXPECT_EQ(static_cast<std::size_t>(f.format), row++) << f.name;
    EXPECT_TRUE(names.insert(f.name).second) << f.name;
    EXPECT_EQ(format_from_extension(f.name), f.format);
    for (std::string_view list : {f.extensions, f.media_types})
      while (!list.empty()) {
        const std::string word(list.substr(0, list.find(' ')));
        list.remove_prefix(std::min(list.size(), word.size() + 1));
        EXPECT_TRUE(types.insert(word).second) << word << " stands twice";
        EXPECT_EQ(word.find('/') == std::string::npos ? format_from_extension(word)
                                                      : format_from_media_type(word + "; charset=utf-8"),
                  f.format)
            << word;
      }
  }
  EXPECT_EQ(format_from_extension("PRJ"), MeshFormat::k3ds);
  for (const char* none : {"", " ", "exe", "acc ac3d", "obj "})
    EXPECT_FALSE(format_from_extension(none)) << none;
  EXPECT_FALSE(format_from_media_type(""));
}

TEST(Formats, OnlyTheSixAreOnByDefault) {
  std::set<std::string> on;
  for (const FormatInfo& f : all_formats())
    if (f.enabled_by_default) on.insert(f.name);
  EXPECT_EQ(on, (std::set<std::string>{"glb", "gltf", "obj", "off", "ply", "stl"}));
}

TEST(Formats, AreToldFromWhatTheFileBeginsWith) {
  const auto found = [](std::string_view bytes) { return format_from_content(bytes_of(bytes)); };
  EXPECT_EQ(found("glTF...."), MeshFormat::kGlb);
  EXPECT_EQ(found("ply\r\nformat"), MeshFormat::kPly);
  EXPECT_EQ(found("\n  solid a\n"), MeshFormat::kStl);
  EXPECT_EQ(found("SOLID A\r\n"), MeshFormat::kStl);
  for (const char* off : {"OFF\n", "OFF4 4 6", "STCNOFF", "4OFF BINARY\n"})
    EXPECT_EQ(found(off), MeshFormat::kOff) << off;
  EXPECT_EQ(found("xof 0303txt 0032"), MeshFormat::kX);
  EXPECT_EQ(found({"FORM\0\0\0\20LWO2TAGS", 16}), MeshFormat::kLwo);
  EXPECT_EQ(found({"FORM\0\0\0\20LXOB", 12}), MeshFormat::kLxo);
  EXPECT_EQ(found({"MM\7\0\0\0x", 7}), MeshFormat::k3ds);
  EXPECT_FALSE(found({"MM\xff\0\0\0x", 7})) << "a main chunk longer than the file";
  for (const char* none : {"", "M", "MM", "FORM", "FORM0000AIFF", "\x89PNG\r\n", "hello", "pl"})
    EXPECT_FALSE(found(none)) << none;
}

TEST(Formats, MotionWithoutASurfaceIsSaidToBeThat) {
  for (const char* extension : {"bvh", "csm", "md5anim", "md5camera", "mot", "vta"}) {
    const Expected<Mesh> mesh = import_text("HIERARCHY\n", *format_from_extension(extension));
    ASSERT_FALSE(mesh) << extension;
    EXPECT_EQ(mesh.error().code, ErrorCode::kEmptyMesh);
    EXPECT_THAT(mesh.error().detail, HasSubstr(extension + std::string(" file contains the motion of ")));
  }
}

}  // namespace
}  // namespace fracture::test
