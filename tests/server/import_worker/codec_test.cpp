// Messages between the server and an import worker, as values: every Mesh comes back bit for bit, and no
// bytes that a worker could send break an invariant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/base/random.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/source_tree.hpp"
#include "server/import_worker/mesh_codec.hpp"
#include "server/import_worker/protocol.hpp"
#include "tests/import/make_files.hpp"
#include "tests/support/mesh_files.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

/// Two triangles with everything that a Mesh can have.
Mesh full_mesh() {
  Mesh mesh;
  mesh.frame = {0.0254, true, true, true, {500000, 30, 4649776.25}};
  mesh.positions = {{0, 0, 0}, {1, 0, -0.0f}, {0, 1, 0}, {0, 0, 1e-30f}};
  mesh.attributes.normals.assign(4, {0, 0, 1});
  mesh.attributes.tangents.assign(4, {1, 0, 0, -1});
  mesh.attributes.uvs = {std::vector<Vec2f>(4, {0.25f, 0.75f}), std::vector<Vec2f>(4, {1, 2})};
  mesh.attributes.colors = {std::vector<Vec4f>(4, {0.1f, 0.2f, 0.3f, 1})};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}};
  mesh.material = {0, kNoIndex};
  mesh.node = {0, 1};
  mesh.node_names = {"left", "r\xc3\xa9"};
  mesh.node_extras = {"\"hp\":120", ""};
  mesh.empty_nodes = {{"socket", {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 2, 3}, "\"a\":1"}};
  mesh.groups = {{"house", kNoIndex}, {"wall", 0}};
  mesh.group_of_node = {1, kNoIndex};
  mesh.source_tree = std::make_shared<const SourceTree>(
      SourceTree{{{"house", kNoIndex, "\"floor\":1"}, {"left", 0}, {"r\xc3\xa9", kNoIndex}}, {1, 2}});
  mesh.instances = {{3, {0, 2, 0}, {-2, 0, 0}, {0, 0, 2}, {1, -0.5, 1e300}}, {}};
  mesh.triangle_color = {{{1, 2, 65535}, 1}, {}};
  MaterialLibrary library;
  library.materials =
      nlohmann::json::array({{{"name", "wood"},
                              {"pbrMetallicRoughness", {{"metallicFactor", 0.1}, {"roughnessFactor", 1}}},
                              {"extras", {{"x", -0.0}, {"big", 18446744073709551615ull}}}}});
  library.textures = nlohmann::json::array({{{"source", 0}, {"sampler", 0}}});
  library.samplers = nlohmann::json::array({nlohmann::json::object()});
  library.images = {{"wood.png", "image/png", {0x89, 'P', 'N', 'G', 0, 255}}};
  library.variants = nlohmann::json::array({{{"name", "winter"}}});
  const nlohmann::json mapping = {{"material", 0}, {"variants", nlohmann::json::array({0})}};
  library.variant_mappings = nlohmann::json::array({{{"mappings", nlohmann::json::array({mapping})}}});
  library.extensions_used = {"KHR_texture_transform"};
  library.extensions_required = {"KHR_texture_transform"};
  mesh.library = std::make_shared<const MaterialLibrary>(std::move(library));
  mesh.copyright = "me";
  mesh.remarks = {{"an image was left out"}, {"skins were baked"}};
  mesh.dropped = {{"light", "L\xc3\xa9", "fragments have no lights"}, {"camera", "", "none"}};
  return mesh;
}

Mesh decoded(const std::vector<std::byte>& bytes) {
  Expected<Mesh> mesh = decode_reply(bytes, {});
  if (!mesh) throw std::runtime_error(mesh.error().detail);
  return std::move(*mesh);
}

/// Decodes the encoded mesh. Returns the decoder's objection.
std::string objection_to(const Mesh& mesh, const ImportLimits& limits = {}) {
  try {
    (void)decode_reply(encode_reply(mesh), limits);
    return "";
  } catch (const BadReply& bad) {
    return bad.what();
  }
}

TEST(MeshCodec, AMeshComesBackBitForBit) {
  const Mesh mesh = full_mesh();
  const std::vector<std::byte> bytes = encode_reply(mesh);
  const Mesh back = decoded(bytes);
  EXPECT_EQ(encode_reply(back), bytes);
  EXPECT_EQ(back.frame.metres, 0.0254);
  EXPECT_TRUE(back.frame.z_up && back.frame.up_stated && back.frame.metres_stated);
  EXPECT_EQ(back.frame.offset, (Vec3d{500000, 30, 4649776.25}));
  EXPECT_TRUE(std::signbit(back.positions[1].z));
  EXPECT_EQ(back.positions[3].z, 1e-30f);
  EXPECT_EQ(back.attributes.tangents[2].w, -1);
  EXPECT_EQ(back.attributes.uvs.size(), 2u);
  EXPECT_EQ(back.triangles[1], (std::array<std::uint32_t, 3>{0, 3, 1}));
  EXPECT_EQ(back.material, (std::vector<std::uint32_t>{0, kNoIndex}));
  EXPECT_EQ(back.node_names, mesh.node_names);
  EXPECT_EQ(back.node_extras, mesh.node_extras);
  EXPECT_EQ(back.empty_nodes, mesh.empty_nodes);
  EXPECT_EQ(back.groups, mesh.groups);
  EXPECT_EQ(back.group_of_node, mesh.group_of_node);
  ASSERT_TRUE(back.source_tree);
  EXPECT_EQ(*back.source_tree, *mesh.source_tree);
  EXPECT_EQ(back.instances, mesh.instances);
  EXPECT_EQ(back.triangle_color, mesh.triangle_color);
  EXPECT_EQ(back.library->materials.dump(), mesh.library->materials.dump());
  EXPECT_EQ(back.library->variants, mesh.library->variants);
  EXPECT_EQ(back.library->variant_mappings, mesh.library->variant_mappings);
  EXPECT_EQ(back.library->images[0].bytes, mesh.library->images[0].bytes);
  EXPECT_EQ(back.library->extensions_required, mesh.library->extensions_required);
  EXPECT_EQ(back.copyright, "me");
  EXPECT_EQ(back.remarks, mesh.remarks);
  EXPECT_EQ(back.dropped, mesh.dropped);
}

TEST(MeshCodec, AnErrorComesBackWithItsFiguresButNotWithEveryCode) {
  const Expected<Mesh> failed =
      fail(ErrorCode::kNotFinite, "Vertex 7 \xff is not finite.", "/meshes/0", {{"vertex", 7}});
  const Expected<Mesh> back = decode_reply(encode_reply(failed), {});
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().code, ErrorCode::kNotFinite);
  EXPECT_EQ(back.error().detail, "Vertex 7 \xc3\xbf is not finite.");
  EXPECT_EQ(back.error().pointer, "/meshes/0");
  EXPECT_EQ(*back.error().extra, (nlohmann::json{{"vertex", 7}}));
  for (const ErrorCode code : {ErrorCode::kInternal, ErrorCode::kCancelled, static_cast<ErrorCode>(-1)})
    EXPECT_THROW((void)decode_reply(encode_reply(fail(code, "no")), {}), BadReply);
  EXPECT_THROW((void)decode_reply(encode_reply(fail(ErrorCode::kTooLarge, "")), {}), BadReply);
}

TEST(MeshCodec, EveryBrokenPromiseIsFound) {
  const auto broken = [](auto&& change) {
    Mesh mesh = full_mesh();
    change(mesh);
    return objection_to(mesh);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(broken([](Mesh&) {}), "");
  EXPECT_THAT(broken([](Mesh& m) { m.triangles[1][2] = 4; }), HasSubstr("names no vertex"));
  EXPECT_THAT(broken([](Mesh& m) {
                auto library = std::make_shared<MaterialLibrary>(*m.library);
                library->variants.clear();  // a mapping names the first one
                m.library = std::move(library);
              }),
              HasSubstr("variants"));
  EXPECT_THAT(broken([](Mesh& m) {
                auto library = std::make_shared<MaterialLibrary>(*m.library);
                library->variant_mappings[0]["mappings"][0]["name"] = std::string(4096, 'a');
                m.library = std::move(library);
              }),
              HasSubstr("variants"));
  EXPECT_THAT(broken([](Mesh& m) { m.node[0] = 2; }), HasSubstr("names no node"));
  EXPECT_THAT(broken([](Mesh& m) { m.material[0] = 1; }), HasSubstr("names no material"));
  EXPECT_THAT(broken([](Mesh& m) { m.material.pop_back(); }), HasSubstr("has no material"));
  EXPECT_THAT(broken([](Mesh& m) { m.triangle_color.pop_back(); }), HasSubstr("colour"));
  EXPECT_EQ(broken([](Mesh& m) { m.triangle_color.clear(); }), "");
  EXPECT_THAT(broken([](Mesh& m) { m.triangles.clear(); }), HasSubstr("number of triangles"));
  EXPECT_THAT(broken([](Mesh& m) { m.positions[2].y = INFINITY; }), HasSubstr("not finite"));
  EXPECT_THAT(broken([&](Mesh& m) { m.attributes.normals[3].x = kNan; }), HasSubstr("not finite"));
  EXPECT_THAT(broken([&](Mesh& m) { m.attributes.colors[0][3].w = kNan; }), HasSubstr("not finite"));
  EXPECT_THAT(broken([](Mesh& m) { m.attributes.uvs[1].pop_back(); }), HasSubstr("every vertex"));
  EXPECT_THAT(broken([](Mesh& m) { m.attributes.uvs.resize(65); }), HasSubstr("too many attribute sets"));
  EXPECT_THAT(broken([](Mesh& m) { m.frame.metres = 0; }), HasSubstr("unit"));
  EXPECT_THAT(broken([](Mesh& m) { m.frame.offset.y = INFINITY; }), HasSubstr("offset"));
  EXPECT_THAT(broken([](Mesh& m) { m.node_names[0] = "\xff"; }), HasSubstr("UTF-8"));
  EXPECT_THAT(broken([](Mesh& m) { m.dropped[0].reason = "\xff"; }), HasSubstr("UTF-8"));
  EXPECT_THAT(broken([](Mesh& m) { m.node_extras.pop_back(); }), HasSubstr("every node"));
  for (const char* extras : {"\"hp\":", "5", "\"a\":1},{\"b\":2", "\"a\":1,\"a\":2"})
    EXPECT_THAT(broken([&](Mesh& m) { m.node_extras[1] = extras; }), HasSubstr("not JSON")) << extras;
  EXPECT_THAT(broken([](Mesh& m) { m.node_extras[1] = "\"fracture\":{}"; }), HasSubstr("an answer"));
  EXPECT_THAT(broken([&](Mesh& m) { m.empty_nodes[0].t.y = kNan; }), HasSubstr("not finite"));
  EXPECT_THAT(broken([](Mesh& m) { m.empty_nodes[0].extras = "}"; }), HasSubstr("not JSON"));
  EXPECT_THAT(broken([](Mesh& m) { m.empty_nodes[0].name = "\xff"; }), HasSubstr("UTF-8"));
  EXPECT_THAT(broken([](Mesh& m) { m.groups[0].parent = 1; }), HasSubstr("tree"));
  EXPECT_THAT(broken([](Mesh& m) { m.group_of_node[0] = 2; }), HasSubstr("names no group"));
  EXPECT_THAT(broken([](Mesh& m) { m.group_of_node.pop_back(); }), HasSubstr("group"));
  EXPECT_THAT(broken([](Mesh& m) { m.instances.pop_back(); }), HasSubstr("instance"));
  const auto broken_tree = [&](auto&& change) {
    return broken([&](Mesh& m) {
      auto tree = std::make_shared<SourceTree>(*m.source_tree);
      change(*tree);
      m.source_tree = std::move(tree);
    });
  };
  EXPECT_EQ(broken([](Mesh& m) { m.source_tree = nullptr; }), "");
  EXPECT_THAT(broken_tree([](SourceTree& t) { t.nodes[0].parent = 0; }), HasSubstr("not part of a tree"));
  EXPECT_THAT(broken_tree([](SourceTree& t) { t.nodes[0].name = "\xff"; }), HasSubstr("UTF-8"));
  EXPECT_THAT(broken_tree([](SourceTree& t) { t.nodes[0].extras = "}"; }), HasSubstr("not JSON"));
  EXPECT_THAT(broken_tree([](SourceTree& t) { t.of_instance[0] = 3; }), HasSubstr("not a source node"));
  EXPECT_THAT(broken_tree([](SourceTree& t) { t.of_instance.pop_back(); }), HasSubstr("every instance"));
  EXPECT_THAT(broken_tree([](SourceTree& t) { t.of_instance = {2, 1}; }), HasSubstr("order"));
  EXPECT_EQ(broken_tree([](SourceTree& t) { t.nodes[0].name.assign(256, 'a'); }), "");
  EXPECT_THAT(broken_tree([](SourceTree& t) { t.nodes[0].name.assign(257, 'a'); }), HasSubstr("too long"));
  EXPECT_THAT(broken_tree([](SourceTree& t) {
                for (std::uint32_t k = 2; k < 70; ++k) t.nodes.push_back({"deep", k});
              }),
              HasSubstr("nested too deeply"));
  EXPECT_THAT(broken([](Mesh& m) {
                MaterialLibrary library;
                library.materials = {5};
                m.library = std::make_shared<const MaterialLibrary>(library);
              }),
              HasSubstr("not an object"));
  EXPECT_THAT(broken([](Mesh& m) {
                MaterialLibrary library = *m.library;
                nlohmann::json deep = 1;
                for (int k = 0; k < 200; ++k) deep = {{"a", deep}};
                library.materials[0]["extras"] = deep;
                m.library = std::make_shared<const MaterialLibrary>(library);
              }),
              HasSubstr("too deep"));
  ImportLimits one;
  one.max_triangles = 1;
  EXPECT_THAT(objection_to(full_mesh(), one), HasSubstr("number of triangles"));
}

TEST(MeshCodec, TruncatedAndMutatedBytesAreRefusedOrKeepThePromises) {
  const std::vector<std::byte> whole = encode_reply(full_mesh());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW((void)decode_reply(std::span(whole).first(size), {}), BadReply) << size;
  std::vector<std::byte> longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_THROW((void)decode_reply(longer, {}), BadReply);

  Random random(20260101);
  std::size_t accepted = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::vector<std::byte> mutant = whole;
    for (std::uint64_t k = 0, n = 1 + random.below(4); k < n; ++k) {
      std::byte& byte = mutant[random.below(mutant.size())];
      byte = random.below(2) == 0 ? static_cast<std::byte>(random.below(256)) : byte ^ std::byte{0x80};
    }
    try {
      const Expected<Mesh> mesh = decode_reply(mutant, {});
      ++accepted;
      if (mesh) {
        EXPECT_EQ(objection_to(*mesh), "");
      }
    } catch (const BadReply&) {
    }
  }
  EXPECT_GT(accepted, 0u) << "a change of a colour is no broken promise";
}

TEST(MeshCodec, LengthsThatCannotBeAreRefusedBeforeAnythingIsAllocated) {
  std::vector<std::byte> bytes = encode_reply(full_mesh());
  // Magic number, kind, unit, three flags and the offset; then the number of positions.
  const std::size_t at = 4 + 4 + 8 + 3 + 3 * 8;
  for (const std::uint64_t count : {std::uint64_t{1} << 40, ~std::uint64_t{0}, ~std::uint64_t{0} / 12 + 1}) {
    std::memcpy(&bytes[at], &count, sizeof count);
    EXPECT_THROW((void)decode_reply(bytes, {}), BadReply);
  }
}

TEST(ImportProtocol, RequestsAreParsedBackAndRefusedWhereTheyDoNotFit) {
  const std::string mesh = "v 0 0 0\n", texture = "PNG";
  const std::vector<ImportFile> files{{"a.mtl", bytes_of("newmtl a")}, {"b.png", bytes_of(texture)}};
  std::vector<std::byte> input = input_head(bytes_of(mesh), files);
  for (const auto& part : {bytes_of(mesh), files[0].bytes, files[1].bytes}) {
    EXPECT_EQ(input.size() % kInputAlignment, 0u);
    input.insert(input.end(), part.begin(), part.end());
    input.resize(aligned(input.size()));
  }
  ImportRequest request;
  request.format = static_cast<std::uint32_t>(MeshFormat::kObj);
  request.max_triangles = 5;
  request.max_json_depth = 9;
  const std::optional<ImportJob> job = parse_request(request, input);
  ASSERT_TRUE(job);
  EXPECT_EQ(job->format, MeshFormat::kObj);
  EXPECT_EQ(job->limits.max_triangles, 5u);
  EXPECT_EQ(job->limits.max_json_depth, 9u);
  EXPECT_TRUE(std::ranges::equal(job->mesh, bytes_of(mesh)));
  ASSERT_EQ(job->files.size(), 2u);
  EXPECT_EQ(job->files[1].name, "b.png");
  EXPECT_TRUE(std::ranges::equal(job->files[1].bytes, bytes_of(texture)));

  for (std::size_t size = 0; size < input.size(); ++size)
    EXPECT_FALSE(parse_request(request, std::span(input).first(size))) << size;
  request.format = static_cast<std::uint32_t>(all_formats().size());
  EXPECT_FALSE(parse_request(request, input)) << "no such format";
  request.format = 0;
  request.version = kProtocolVersion + 1;
  EXPECT_FALSE(parse_request(request, input)) << "another version";
}

TEST(MeshCodec, RealMeshesComeBackBitForBit) {
  std::size_t compared = 0;
  for (const MeshFile& file : test_meshes()) {
    const Expected<Mesh> mesh = load_mesh(file);
    const std::vector<std::byte> bytes = encode_reply(mesh);
    EXPECT_EQ(encode_reply(decode_reply(bytes, {})), bytes) << file.name;
    ++compared;
  }
  if (compared == 0) GTEST_SKIP() << "FRACTURE_TEST_MESHES is absent";
}

}  // namespace
}  // namespace fracture::test
