// Client data is charged for the memory that it takes, or refused: bodies that expand, repeated parameters,
// and forms with much data around the mesh.
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "common/digest/digest.hpp"
#include "common/mesh/material_library.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/peak_memory.hpp"

namespace fracture::test {
namespace {

const std::string kForm = "Content-Type: multipart/form-data; boundary=B\r\n";

std::string part(const std::string& disposition, const std::string& body) {
  return "--B\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + body + "\r\n";
}

std::string form_of(const std::string& params) {
  return part("name=mesh; filename=a.glb", "mesh") + part("name=params", params) + "--B--\r\n";
}

std::string many(const std::string& item, std::size_t bytes) {
  std::string text;
  while (text.size() < bytes) text += item;
  return text;
}

// -- parameters

TEST(ChargedMemory, ParametersThatRepeatThemselvesAreRefusedByNameAndCostNoMemory) {
  TestServer server;
  const std::string list = "[0" + many(",0", 500'000) + "]";
  const std::string params = std::string("{") + many("\"a\":0,", 400'000) + "\"a\":" + list + "}";
  const PeakMemory peak;
  const Reply reply = server.post("/fracture", gzip(form_of(params)), kForm + "Content-Encoding: gzip\r\n");
  EXPECT_EQ(reply.status, 400);
  EXPECT_EQ(reply.problem(), "bad-parameter") << reply.body.substr(0, 500);
  EXPECT_EQ(reply.json().value("parameter", ""), "a");
  EXPECT_LT(reply.body.size(), 2'000u);
  EXPECT_TRUE(peak.grew_by_less_than(48 << 20));
}

TEST(ChargedMemory, ARepeatedParameterOfACollisionIsRefused) {
  TestServer server;
  const std::string path = "/meshes/sha256:" + sha256("mesh").hex();
  ASSERT_EQ(server.put(path, "mesh").status, 201);
  const Reply reply = server.post_json(path + "/fracture", R"({"seed": 1, "sites": 5, "seed": 2})");
  EXPECT_EQ(reply.status, 400);
  EXPECT_EQ(reply.json().value("parameter", ""), "seed") << reply.body;
  EXPECT_EQ(server.control->cuts, 0);
}

TEST(ChargedMemory, ParametersThatHoldTooMuchAreRefused) {
  TestServer server;
  const PeakMemory peak;
  const Reply reply =
      server.post("/fracture", gzip(form_of("{\"points\": [{}" + many(",{}", 1'000'000) + "]}")),
                  kForm + "Content-Encoding: gzip\r\n");
  EXPECT_EQ(reply.problem(), "bad-json") << reply.body.substr(0, 500);
  EXPECT_TRUE(peak.grew_by_less_than(48 << 20));
}

// -- stored data

TEST(ChargedMemory, AFormHasLittleAroundItsParts) {
  TestServer server;
  const std::string form = form_of("{}");
  for (const std::size_t bytes : {4'000u, 100'000u}) {
    const int expected = bytes < 4'096 ? 200 : 400;
    const std::string around(bytes, 'x');
    const Reply before = server.post("/fracture", around + "\r\n" + form, kForm),
                behind = server.post("/fracture", form + around, kForm);
    EXPECT_EQ(before.status, expected) << before.body;
    EXPECT_EQ(behind.status, expected) << behind.body;
    if (expected == 400) {
      EXPECT_EQ(before.problem(), "malformed-multipart");
      EXPECT_EQ(behind.problem(), "malformed-multipart");
    }
  }
}

TEST(ChargedMemory, AStoredMeshKeepsNothingOfItsFormButMeshAndFiles) {
  TestServer server;
  std::string form;
  for (int k = 0; k < 200; ++k)  // headers, which the store does not need
    form += "--B\r\nContent-Disposition: form-data; name=file; filename=f" + std::to_string(k) + "; x=\"" +
            std::string(3'900, 'x') + "\"\r\n\r\n\r\n";
  form += part("name=mesh; filename=a.glb", "mesh") + "--B--\r\n";
  const Reply stored = server.post("/meshes", form, kForm);
  ASSERT_EQ(stored.status, 201) << stored.body;
  const std::string id = stored.json().value("id", "").substr(7);
  const auto mesh = const_cast<MeshStore&>(server.api.meshes()).find(id, "", MeshStore::Whose::kAnybodys);
  ASSERT_TRUE(mesh);
  EXPECT_LT(mesh->capacity, 100u) << "of the form of " << form.size() << " bytes";
  EXPECT_LT(server.api.meshes().figures().bytes, 50'000u);
  EXPECT_GT(server.api.meshes().figures().bytes, 200 * sizeof(ImportFile)) << "the list of files counts";
  EXPECT_TRUE(
      eventually(kPatience, "the form to go", [&] { return server.api.bodies().whole().used() == 0; }));
}

TEST(ChargedMemory, AStoredMeshIsChargedWithItsReport) {
  TestServer server;
  server.control->import = [](std::string_view) -> Expected<Mesh> {
    Mesh mesh;
    for (int k = 0; k < 1'000; ++k) mesh.node_names.push_back(std::string(1'000, 'n'));
    return mesh;
  };
  ASSERT_EQ(server.post("/meshes", "mesh").status, 201);
  EXPECT_GT(server.api.meshes().figures().bytes, 1'000'000u);
}

TEST(ChargedMemory, ExtrasOfMaterialsCountInTheCacheAtWhatTheyHold) {
  PreparedMesh mesh;
  auto library = std::make_shared<MaterialLibrary>();
  nlohmann::json extras = nlohmann::json::array();
  for (int k = 0; k < 100'000; ++k) extras.push_back(nlohmann::json::array());
  library->materials.push_back({{"name", "a"}, {"extras", extras}});
  auto source = std::make_shared<Mesh>();
  source->library = library;
  source->copyright.assign(1'000'000, 'c');
  source->remarks.warnings.assign(1'000, std::string(1'000, 'w'));
  mesh.solid.source = source;
  EXPECT_GE(memory_size(mesh),
            100'000 * (sizeof(nlohmann::json) + sizeof(nlohmann::json::array_t)) + 2'000'000);
}

TEST(ChargedMemory, ContactsOfPartsCountInTheCache) {
  PreparedMesh mesh;
  auto library = std::make_shared<MaterialLibrary>();
  auto source = std::make_shared<Mesh>();
  source->library = library;
  mesh.solid.source = source;
  const std::size_t before = memory_size(mesh);
  auto contacts = std::make_shared<ContactGraph>();
  contacts->contacts.resize(1'000);
  contacts->pieces.resize(1'000);
  mesh.solid.contacts = contacts;
  EXPECT_GE(memory_size(mesh), before + 1'000 * (sizeof(Contact) + sizeof(ContactPiece)));
}

// -- bodies that expand

struct OneThread : testing::Test {
  TestServerOptions options;
  std::unique_ptr<TestServer> server;
  Gate gate;
  std::vector<std::thread> clients;
  std::atomic<int> cuts{0};
  std::function<void()> during_second_cut;

  void start() {
    options.threads = 1;
    options.limits.realtime_deadline = kPatience;
    server = std::make_unique<TestServer>(options);
    ASSERT_EQ(server->put(path, "mesh").status, 201);
    ASSERT_TRUE(eventually(kPatience, "an idle thread", [&] { return server->pool.running() == 0; }));
    server->control->during_cut = [this](const Execution&) {
      const int cut = ++cuts;
      if (cut == 1) gate.pass_without_polls();
      if (cut == 2 && during_second_cut) during_second_cut();
    };
    in_background([this] { return server->post_json(path + "/fracture", R"({"seed": 1})"); });
    gate.wait_for(1);
  }
  template <class Ask>
  void in_background(Ask ask) {
    clients.emplace_back([ask] { EXPECT_EQ(ask().status, 200); });
  }
  void TearDown() override {
    gate.open = true;
    for (std::thread& client : clients) client.join();
  }
  const std::string path = "/meshes/sha256:" + sha256("mesh").hex();
  const std::string gzipped = "Content-Type: model/obj\r\nContent-Encoding: gzip\r\n";
};

TEST_F(OneThread, ABatchBodyIsDecodedAfterRealtimeWork) {
  start();
  const std::string body = gzip(std::string(2u << 20, 'x'));
  std::uint64_t held = 0;
  during_second_cut = [&] { held = server->api.bodies().whole().used(); };
  in_background([&] { return server->post("/fracture", body, gzipped); });
  ASSERT_TRUE(eventually(kPatience, "the body in the queue", [&] { return server->pool.queued() == 1; }));
  in_background([&] { return server->post_json(path + "/fracture", R"({"seed": 2})"); });
  ASSERT_TRUE(
      eventually(kPatience, "the collision in the queue", [&] { return server->pool.queued() == 2; }));
  gate.open = true;
  ASSERT_TRUE(eventually(kPatience, "both", [&] { return cuts == 3; }));
  EXPECT_LT(held, 1u << 20) << "the collision, which came later, went first";
}

TEST_F(OneThread, ABodyThatCannotBeDecodedInTimeIsRefusedAtOnce) {
  options.limits.max_body = 64u << 20;
  start();
  in_background([&] { return server->post("/fracture?sites=1000", "mesh"); });
  ASSERT_TRUE(eventually(kPatience, "work in the queue", [&] { return server->pool.queued() == 1; }));
  const Reply reply =
      server->post("/fracture", gzip(std::string(60u << 20, '\0')), gzipped + "Request-Timeout: 0.01\r\n");
  EXPECT_EQ(reply.status, 503) << reply.body;
  EXPECT_NE(reply.header("retry-after"), "");
  EXPECT_EQ(server->dispatcher.figures().refused, 1u);
}

TEST_F(OneThread, NoMoreBodiesWaitToBeDecodedThanMayWait) {
  options.max_queue = 0;
  start();
  EXPECT_EQ(server->post("/fracture", gzip("mesh"), gzipped).status, 503);
}

TEST(ChargedMemory, ABodyThatUnfoldsToMoreThanItSaysIsAdmittedForMore) {
  TestServer server;
  const std::string mesh(4u << 20, 'x');
  const Reply plain = server.post("/fracture", mesh, "Content-Type: model/obj\r\n");
  const Reply lying = server.post("/fracture", gzip(mesh) + gzip(""),
                                  "Content-Type: model/obj\r\nContent-Encoding: gzip\r\n");
  EXPECT_EQ(lying.status, 200) << lying.body;
  EXPECT_EQ(lying.header("etag"), plain.header("etag"));
}

// -- cache tiers

struct ChargedTiers : testing::Test {
  TemporaryFolder folder;
  TestServerOptions options;
  Reply made;
  void SetUp() override {
    options.service.tiers.folder = folder.path + "/cache";
    TestServer server(options);
    server.control->glb_padding = 1u << 20;
    made = server.post("/fracture?sites=5");
    server.service.tiers().flush();
  }
};

TEST_F(ChargedTiers, AnEntryIsReadOnlyWhereThereIsRoom) {
  options.dispatcher.max_working_bytes = 1u << 20;  // for entry and result; each takes more
  TestServer server(options);
  const Reply none = server.get(made.header("content-location"));
  EXPECT_EQ(none.status, 503) << none.body;
  EXPECT_EQ(none.problem(), "overloaded");
  EXPECT_EQ(server.post("/fracture?sites=5").status, 200) << "computed within what it was admitted for";
  EXPECT_EQ(server.control->cuts, 1);
  EXPECT_EQ(server.dispatcher.figures().working_bytes, 0u);
}

TEST_F(ChargedTiers, AFileThatBecameFourTebibytesLongIsDamageAndNothingMore) {
  for (const bool before_the_start : {true, false}) {
    const auto files = entries_in(folder.path + "/cache");
    ASSERT_EQ(files.size(), 1u);
    const auto grow = [&] { std::filesystem::resize_file(files[0], std::uintmax_t{4} << 40); };
    if (before_the_start) grow();
    TestServer server(options);
    server.control->glb_padding = 1u << 20;
    if (!before_the_start) grow();
    EXPECT_EQ(server.get(made.header("content-location")).status, 404);
    EXPECT_EQ(server.post("/fracture?sites=5").body, made.body);
    EXPECT_EQ(server.control->cuts, 1);
    const auto disk = server.service.figures().tiers.disk;
    EXPECT_EQ(disk->quarantined, 1u);
    EXPECT_EQ(disk->failures, 0u);
    server.service.tiers().flush();
    EXPECT_LT(server.service.figures().tiers.disk->bytes, 2u << 20);
  }
}

}  // namespace
}  // namespace fracture::test
