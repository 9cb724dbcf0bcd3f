// Names in the file: which characters they keep, how long they are, and that different names stay different.
#include "common/gltf/names.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/utf8.hpp"
#include "common/gltf/gltf_writer.hpp"
#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

const std::string kTable = "\xe6\xa1\x8c\xe5\xad\x90";  // 桌子: two characters of three bytes
const std::string kChair = "\xe6\xa4\x85\xe5\xad\x90";  // 椅子

TEST(Names, KeepEveryScript) {
  for (const std::string& name :
       {kTable, std::string("Tr\xc3\xa4ger-1"), std::string("\xf0\x9f\xaa\x91"), std::string("Wall_01")})
    EXPECT_EQ(kept_name(name), name);
}

TEST(Names, ReplaceWhatToolsRemoveAndWhatIsNotText) {
  EXPECT_EQ(kept_name("a/b.c:d[e]f"), "a_b_c_d_e_f");
  EXPECT_EQ(kept_name("a b\tc\nd\x7f"
                      "e\"f"),
            "a_b_c_d_e_f");
  EXPECT_EQ(kept_name("a\xc2\x85"
                      "b\xe3\x80\x80"
                      "c\xe2\x80\xae"
                      "d"),
            "a_b_c_d")
      << "next line, ideographic space, right-to-left override";
  EXPECT_EQ(kept_name("a\xff"
                      "b\xc0\xaf"
                      "c\xed\xa0\x80"),
            "a_b__c___")
      << "one for each byte that is not UTF-8";
  EXPECT_EQ(kept_name("\xe6\xa1"), "__") << "an incomplete character";
  EXPECT_EQ(kept_name(""), "mesh");
}

TEST(Names, EndWithAWholeCharacter) {
  std::string name = "ab";
  for (int k = 0; k < 30; ++k) name += "\xe6\xa1\x8c";
  EXPECT_EQ(kept_name(name), name.substr(0, 62)) << "a 21st character would end at byte 65";
  EXPECT_EQ(kept_name(name, 5), name.substr(0, 5));
  EXPECT_EQ(kept_name(name, 4), "ab");
}

TEST(Names, OfSourcesDifferIfTheSourcesDiffer) {
  const std::string room(20, 'x');
  const std::vector<std::string> sources{"a.b", "a:b", "a.b", "a_b_2", room + "1", room + "2", ""};
  const std::vector<std::string> names = names_of_sources(sources, 20, {});
  EXPECT_EQ(names, (std::vector<std::string>{"a_b", "a_b_2", "a_b", "a_b_2_2", room,
                                             std::string(18, 'x') + "_2", "mesh"}));
}

TEST(Names, OfSourcesAreNotThoseOfCollisionGeometry) {
  EXPECT_EQ(names_of_sources({"UCX_a", "UBX_a", "USP_a", "UCP_a", "_UCX_a", "UCXa"}, 63, {}),
            (std::vector<std::string>{"_UCX_a", "_UBX_a", "_USP_a", "_UCP_a", "_UCX_a_2", "UCXa"}));
}

TEST(Names, OfSourcesAreNotImportHintsOfGodot) {
  EXPECT_EQ(names_of_sources({"Crate-col", "Car_Wheel", "wheel", "Wall$ConvCol.001", "protocol",
                              "Crate-col_piece", "a-colour"},
                             63, {}),
            (std::vector<std::string>{"Crate-col_piece", "Car_Wheel_piece", "wheel", "Wall_ConvCol_001_piece",
                                      "protocol", "Crate-col_piece_2", "a-colour"}));
}

TEST(Names, OfFiftyThousandEqualNamesCostLittle) {
  std::vector<std::string> sources;
  for (int k = 0; k < 50'000; ++k) sources.push_back(std::string(70, 'y') + std::to_string(k));
  const std::vector<std::string> names = names_of_sources(sources, 40, {});
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), sources.size());
}

/// The names of all nodes and meshes in the file of two halves that come from these two nodes.
std::vector<std::string> names_in_file(const std::vector<std::string>& sources, UeCollision collision) {
  FracturedSolid made = two_halves_with_hulls();
  auto mesh = std::make_shared<Mesh>(*made.set.source);
  mesh->node_names = sources;
  made.set.source = mesh;
  made.set.fragments[0].node = 0;
  made.set.fragments[1].node = 1;
  GltfOptions options;
  options.ue_collision = collision;
  const json document = Glb(write_glb(made, options)).document;
  std::vector<std::string> names;
  for (const json& node : document["nodes"]) names.push_back(node["name"]);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  for (const json& node : document["meshes"]) names.push_back(node["name"]);
  for (const std::string& name : names) {
    EXPECT_LE(name.size(), kMaxName) << name;
    EXPECT_TRUE(is_utf8(name)) << name;
  }
  return names;
}

TEST(Names, OfFragmentsAndTheirHullsForUnrealKeepTheScript) {
  const std::vector<std::string> names = names_in_file({kTable, kChair}, UeCollision::kUcx);
  EXPECT_EQ(names[1], kTable + "_0");
  EXPECT_EQ(names[2], kChair + "_1");
  const std::set<std::string> all(names.begin(), names.end());
  EXPECT_TRUE(all.contains("UCX_" + kTable + "_0_00"));
  EXPECT_TRUE(all.contains("UCX_" + kChair + "_1_01"));
}

TEST(Names, ThatAreLongOrAlmostEqualStayDifferentInTheFile) {
  std::string longer;
  for (int k = 0; k < 40; ++k) longer += kTable;
  const std::vector<std::string> cut = names_in_file({longer + "a", longer + "b"}, UeCollision::kUcx);
  EXPECT_NE(cut[1].substr(0, cut[1].size() - 2), cut[2].substr(0, cut[2].size() - 2));
  const std::vector<std::string> alike = names_in_file({"a.b", "a:b"}, UeCollision::kNone);
  EXPECT_EQ(alike[1], "a_b_0");
  EXPECT_EQ(alike[2], "a_b_2_1");
}

}  // namespace
}  // namespace fracture::test
