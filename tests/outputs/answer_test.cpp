// The data read of an answer, the refusals of data that are not an answer, and sinks that stop accepting.
#include <gmock/gmock.h>

#include "tests/gltf/glb_file.hpp"
#include "tests/gltf/two_halves.hpp"
#include "tests/outputs/read_back.hpp"

namespace fracture::outputs::test {
namespace {

using fracture::test::Glb;
using fracture::test::two_halves;
using nlohmann::json;

std::string packed_text(const Glb& glb, const std::function<void(json&)>& change) {
  json document = glb.document;
  change(document);
  return document.dump();
}

/// A GLB with another document.
std::vector<std::uint8_t> packed(const Glb& glb, std::string text) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::uint8_t> bytes;
  const auto u32 = [&](std::size_t value) {
    for (const int shift : {0, 8, 16, 24}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
  };
  u32(0x46546c67), u32(2), u32(28 + text.size() + glb.binary.size());
  u32(text.size()), u32(0x4e4f534a);
  bytes.insert(bytes.end(), text.begin(), text.end());
  u32(glb.binary.size()), u32(0x004e4942);
  bytes.insert(bytes.end(), glb.binary.begin(), glb.binary.end());
  return bytes;
}

std::vector<std::uint8_t> packed(const Glb& glb, const std::function<void(json&)>& change) {
  return packed(glb, packed_text(glb, change));
}

std::string refusal(const std::vector<std::uint8_t>& bytes) {
  const Expected<Answer> answer = read_answer(bytes);
  if (answer) return "it was read";
  EXPECT_EQ(answer.error().code, ErrorCode::kInternal);
  return answer.error().detail;
}

TEST(Answer, IsWhatTheWriterWrote) {
  const std::vector<std::uint8_t> glb = write_glb(two_halves(), with(&GltfOptions::algorithm, 14));
  const KeptAnswer answer = read(glb);
  EXPECT_EQ(answer.generator, "fracture, algorithm 14");
  ASSERT_EQ(answer.objects.size(), 2u);
  EXPECT_EQ(answer.objects[0].id, 9007199254740991u);
  EXPECT_EQ(answer.objects[1].id, 7u);
  EXPECT_EQ(answer.objects[1].place, (Vec3f{1.5f, 0.5f, 0.5f}));
  EXPECT_EQ(answer.vertices(), 48u);
  EXPECT_EQ(answer.triangles(), 24u);
  EXPECT_EQ(packed(Glb(glb), [](json&) {}).size() % 4, 0u);
  EXPECT_EQ(obj_of(read(packed(Glb(glb), [](json&) {}))), obj_of(answer)) << "in any order of members";
}

TEST(Answer, APartThatWasNotFracturedIsAnObjectWithoutAFragment) {
  FracturedSolid halves = two_halves();
  auto mesh = std::make_shared<Mesh>(*halves.set.source);
  mesh->passed_through = std::make_shared<Mesh>(fracture::test::cube());
  halves.set.source = mesh;
  const KeptAnswer answer = read(write_glb(halves, {}));
  ASSERT_EQ(answer.objects.size(), 3u);
  EXPECT_FALSE(answer.objects[2].id);
  const ObjFile obj(obj_of(answer));
  ASSERT_EQ(obj.objects.size(), 3u);
  EXPECT_EQ(open_edges(obj.objects[2].v), 0u) << "vertices at one position are one";
  const auto fragments = PlyFile(ply_of(answer)).fragments();
  EXPECT_EQ(fragments.at(-1).size(), 12u);
  EXPECT_EQ(fragments.size(), 3u);
}

TEST(Answer, TheSameBytesEveryTime) {
  const std::vector<std::uint8_t> first = write_glb(broken_ball(), {}), second = write_glb(broken_ball(), {});
  EXPECT_EQ(obj_of(read(first)), obj_of(read(second)));
  EXPECT_EQ(ply_of(read(first)), ply_of(read(second)));
  EXPECT_EQ(stl_of(read(first)), stl_of(read(second)));
}

TEST(Answer, ATextThatIsNestedTwoHundredThousandDeepIsRefused) {
  const Glb glb(write_glb(two_halves(), {}));
  std::string deep;
  for (int k = 0; k < 200'000; ++k) deep += "[";
  deep += std::string(200'000, ']');
  const std::string text = packed_text(glb, [](json& document) {
    document["materials"] = {{{"extras", "DEEP"}}};
  });
  std::string forged = text;
  forged.replace(forged.find("\"DEEP\""), 6, deep);
  EXPECT_NE(refusal(packed(glb, forged)).find("nested too deeply"), std::string::npos);
  EXPECT_EQ(refusal(packed(glb, text)).find("nested too deeply"), std::string::npos);
}

TEST(Answer, EveryTruncationIsRefused) {
  const std::vector<std::uint8_t> glb = write_glb(two_halves(), {});
  for (std::size_t size = 0; size < glb.size(); size += size < 100 ? 1 : 97) {
    std::vector<std::uint8_t> cut(glb.begin(), glb.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(refusal(cut), "it was read") << size;
    if (size < 12) continue;
    for (std::size_t k = 0; k < 4; ++k)
      cut[8 + k] = static_cast<std::uint8_t>(size >> (8 * k));  // the header states the length
    EXPECT_NE(refusal(cut), "it was read") << size;
  }
}

TEST(Answer, WhatContradictsItselfIsRefusedAndSaysWhy) {
  const Glb glb(write_glb(two_halves(), {}));
  const std::vector<std::pair<std::string, std::function<void(json&)>>> cases{
      {"not made by fracture", [](json& d) { d["asset"]["generator"] = "Blender"; }},
      {"not made by fracture", [](json& d) { d["asset"]["generator"] = "fracture, algorithm 1\nmtllib y"; }},
      {"generator", [](json& d) { d["asset"].erase("generator"); }},
      {"no scenes[0]", [](json& d) { d.erase("scenes"); }},
      {"no nodes[99]", [](json& d) { d["nodes"][0]["children"][0] = 99; }},
      {"not a tree", [](json& d) { d["nodes"][0]["children"][0] = 0; }},
      {"not a tree", [](json& d) { d["nodes"][0]["children"][1] = 1; }},
      {"turned or scaled",
       [](json& d) {
         d["nodes"][0]["rotation"] = {0, 0, 0, 1};
       }},
      {"scaled uniformly",
       [](json& d) {
         d["nodes"][1]["scale"] = {1, 2, 1};
       }},
      {"no meshes[7000]", [](json& d) { d["nodes"][1]["mesh"] = 7000; }},
      {"'mesh'", [](json& d) { d["nodes"][1]["mesh"] = -1; }},
      {"material 50", [](json& d) { d["meshes"][0]["primitives"][0]["material"] = 50; }},
      {"'POSITION'", [](json& d) { d["meshes"][0]["primitives"][0]["attributes"].erase("POSITION"); }},
      {"do not share vertices",
       [](json& d) {
         d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
             d["meshes"][1]["primitives"][0]["attributes"]["POSITION"];
       }},
      {"beyond its buffer", [](json& d) { d["accessors"][0]["count"] = 1 << 30; }},
      {"beyond its buffer", [](json& d) { d["bufferViews"][0]["byteOffset"] = 4294967295u; }},
      {"2^32", [](json& d) { d["bufferViews"][0]["byteOffset"] = 1e18; }},
      {"2^32", [](json& d) { d["accessors"][0]["byteOffset"] = 18446744073709551615u; }},
      {"not a VEC3", [](json& d) { d["accessors"][0]["type"] = "VEC2"; }},
      {"a different length",
       [](json& d) {
         d["accessors"][d["meshes"][0]["primitives"][0]["attributes"]["NORMAL"].get<std::size_t>()]["count"] =
             3;
       }},
      {"refers to a vertex that does not exist",  // positions of only one vertex
       [](json& d) {
         for (auto& [name, accessor] : d["meshes"][0]["primitives"][0]["attributes"].items())
           d["accessors"][accessor.get<std::size_t>()]["count"] = 1;
       }},
      {"does not consist of triangles",
       [](json& d) {
         d["accessors"][d["meshes"][0]["primitives"][0]["indices"].get<std::size_t>()]["count"] = 4;
       }},
      {"EXT_mesh_manifold",
       [](json& d) {
         json& merges = d["meshes"][0]["extensions"]["EXT_mesh_manifold"];
         d["accessors"][merges["mergeValues"].get<std::size_t>()]["count"] = 1;
       }},
      {"an image",
       [](json& d) {
         d["bufferViews"][d["images"][0]["bufferView"].get<std::size_t>()]["byteLength"] = 1 << 30;
       }},
      {"image 9", [](json& d) { d["textures"][0]["source"] = 9; }},
      {"no textures[9]", [](json& d) { d["materials"][0]["normalTexture"]["index"] = 9; }},
      {"type",
       [](json& d) {
         d["materials"] = 5;
         d["materials"] = json::array({5, "x"});
         d["materials"][0] = json{{"name", 5}};
       }},
  };
  for (const auto& [why, change] : cases) EXPECT_THAT(refusal(packed(glb, change)), testing::HasSubstr(why));
}

TEST(Sinks, AreNotAskedAgainWhenTheyWantNoMore) {
  const std::vector<std::uint8_t> glb = write_glb(broken_ball(), {});
  const KeptAnswer answer = read(glb);
  for (int format = 0; format < 4; ++format) {
    int asked = 0;
    const Sink full = [&](std::string_view) {
      ++asked;
      return false;
    };
    const bool good = format == 0   ? write_obj(answer, "x.mtl", VertexColors::kKeep, full)
                      : format == 1 ? write_mtl(answer, {}, full)
                      : format == 2 ? write_ply(answer, VertexColors::kKeep, full)
                                    : write_stl(answer, full);
    EXPECT_FALSE(good) << format;
    EXPECT_EQ(asked, 1) << format;
  }
}

TEST(ToSrgb, IsTheCurveOfTheStandard) {
  EXPECT_EQ(to_srgb(0), 0);
  EXPECT_EQ(to_srgb(-1), 0);
  EXPECT_NEAR(to_srgb(1), 1, 1e-15);
  EXPECT_NEAR(to_srgb(7), 1, 1e-15);
  EXPECT_NEAR(to_srgb(0.001), 0.01292, 1e-12) << "straight near black";
  EXPECT_NEAR(to_srgb(0.214041), 0.5, 1e-6);
}

TEST(Answer, GroupsDoNotChangeTheOrderOfObjects) {
  FracturedSolid made = two_halves();
  auto source = std::make_shared<Mesh>(*made.set.source);
  source->node_names = {"roof", "wall"};
  made.set.source = source;
  made.set.fragments[0].node = 1;  // so the group of the second fragment comes first
  const std::vector<std::uint8_t> flat = write_glb(made, {});
  source->node = {0, 1};
  const std::vector<std::uint8_t> grouped = write_glb(made, {});
  EXPECT_EQ(Glb(grouped).document["nodes"].size(), Glb(flat).document["nodes"].size() + 2);
  const KeptAnswer a = read(grouped), b = read(flat);
  ASSERT_EQ(a.objects.size(), 2u);
  EXPECT_EQ(a.objects[0].name, "wall_0");
  EXPECT_EQ(obj_of(a), obj_of(b));
  EXPECT_EQ(stl_of(a), stl_of(b));
}

// Floats at the offset are too coarse, so positions stay below the root.
TEST(Answer, TheOffsetOfTheRootIsStatedAndNotAdded) {
  FracturedSolid far = two_halves();
  auto source = std::make_shared<Mesh>(*far.set.source);
  source->frame.offset = {500000, 30, 4649776};
  far.set.source = source;
  const std::vector<std::uint8_t> glb = write_glb(far, {});
  EXPECT_EQ(Glb(glb).document["nodes"][0]["translation"], json({500000.0, 30.0, 4649776.0}));
  const KeptAnswer answer = read(glb), near = read(write_glb(two_halves(), {}));
  EXPECT_EQ(answer.offset, (Vec3d{500000, 30, 4649776}));
  EXPECT_EQ(near.offset, Vec3d{});
  EXPECT_EQ(answer.objects[1].place, (Vec3f{1.5f, 0.5f, 0.5f}));

  const std::string line = "# offset (500000, 30, 4649776)\n";
  std::string obj = obj_of(answer);
  ASSERT_NE(obj.find(line), std::string::npos);
  EXPECT_EQ(obj.erase(obj.find(line), line.size()), obj_of(near));
  EXPECT_NE(ply_of(answer).find("\ncomment offset (500000, 30, 4649776)\n"), std::string::npos);
  EXPECT_NE(stl_of(answer).substr(0, 80).find("; offset (500000, 30, 4649776)"), std::string::npos);
  EXPECT_EQ(stl_of(answer).substr(80), stl_of(near).substr(80));
}

TEST(Answer, HasTheSheetsThatFragmentsCarryAsObjects) {
  const fracture::test::Fractured made = [] {
    fracture::FractureParameters p;
    p.pattern = fracture::PointsPattern{{{-0.25, 0, 0}, {0.25, 0, 0}}};
    p.hulls = fracture::Hulls::kConvex;
    const Mesh mesh =
        fracture::test::joined({fracture::test::cube(),
                                fracture::test::translated(fracture::test::open_quad(), {-0.5, -0.5, 0.75})});
    return fracture::test::fracture_mesh(mesh, p);
  }();
  for (const UeCollision ue : {UeCollision::kNone, UeCollision::kUcx}) {
    const std::vector<std::uint8_t> glb = write_glb(made, with(&GltfOptions::ue_collision, ue));
    const KeptAnswer answer = read(glb);
    ASSERT_EQ(answer.objects.size(), 4u) << "two fragments, each followed by its sheet; no hulls";
    for (const std::size_t k : {0u, 2u}) {
      EXPECT_TRUE(answer.objects[k].id);
      EXPECT_FALSE(answer.objects[k + 1].id);
      EXPECT_FALSE(answer.objects[k].carried);
      EXPECT_TRUE(answer.objects[k + 1].carried);
      EXPECT_EQ(answer.objects[k + 1].name, answer.objects[k].name + "_sheet");
      EXPECT_EQ(answer.objects[k + 1].place, answer.objects[k].place) << "it is in the fragment's frame";
      for (std::size_t v = 0; v < answer.objects[k + 1].positions.size(); ++v) {
        EXPECT_EQ(answer.objects[k + 1].position(v).z, 0.75f);
      }
    }
  }
}

}  // namespace
}  // namespace fracture::outputs::test
