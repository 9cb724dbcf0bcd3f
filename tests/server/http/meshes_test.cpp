// Stored meshes over HTTP, and the requests of a collision.
#include <gtest/gtest.h>

#include "common/digest/digest.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

std::string id_of(const std::string& bytes) { return "sha256:" + sha256(bytes).hex(); }

TEST(Meshes, AMeshIsPutUnderItsDigestAndReported) {
  TestServer server;
  const Reply created = server.put("/meshes/" + id_of("mesh"), "mesh");
  ASSERT_EQ(created.status, 201) << created.body;
  EXPECT_EQ(created.header("location"), "/meshes/" + id_of("mesh"));
  EXPECT_EQ(created.json().at("id"), id_of("mesh"));
  EXPECT_EQ(created.json().at("bytes"), 4);
  EXPECT_EQ(created.json().at("report").at("verdict"), "closed");
  EXPECT_EQ(server.control->prepares, 1) << "it is prepared at once";
  EXPECT_EQ(server.put("/meshes/" + id_of("mesh"), "mesh").status, 200);
  EXPECT_EQ(server.control->prepares, 1);
  EXPECT_EQ(server.get("/meshes/" + id_of("mesh")).json().at("id"), id_of("mesh"));
  EXPECT_EQ(ask(server.port(), "HEAD", "/meshes/" + id_of("mesh")).status, 200);
  EXPECT_GT(server.api.meshes().figures().bytes, 4u) << "the report is kept, too";
  EXPECT_LT(server.api.meshes().figures().bytes, 20'000u);
}

/// If it is known already, its bytes are compared in a second step on the pool, which can be interrupted.
TEST(Meshes, ALargeMeshIsStoredAndReportedLikeASmallOne) {
  TestServer server;
  const std::string mesh(std::size_t{1} << 20, 'm');
  const Reply created = server.put("/meshes/" + id_of(mesh), mesh);
  ASSERT_EQ(created.status, 201) << created.body;
  EXPECT_EQ(created.header("location"), "/meshes/" + id_of(mesh));
  EXPECT_EQ(created.json().at("bytes"), mesh.size());
  EXPECT_EQ(created.json().at("report").at("verdict"), "closed");
  EXPECT_EQ(server.put("/meshes/" + id_of(mesh), mesh).status, 200);
  EXPECT_EQ(server.control->prepares, 1);
  EXPECT_EQ(server.get("/meshes/" + id_of(mesh)).body, created.body);
  EXPECT_TRUE(eventually(kPatience, "the bodies to be given back",
                         [&] { return server.api.bodies().whole().used() == 0; }));
}

TEST(Meshes, AStoredMeshIsEstimated) {
  TestServer server;
  ASSERT_EQ(server.put("/meshes/" + id_of("mesh"), "mesh").status, 201);
  const std::string path = "/meshes/" + id_of("mesh") + "/estimate";
  const Reply reply = server.post_json(path, R"({"sites": 50})");
  ASSERT_EQ(reply.status, 200) << reply.body;
  for (const char* name : {"sites", "fragments", "triangles", "bytes", "working_bytes"})
    EXPECT_TRUE(reply.json().at(name).is_number_unsigned()) << name;
  EXPECT_EQ(reply.json().at("limit_bytes"), server.dispatcher.most_bytes());
  EXPECT_EQ(reply.json().at("fits"), true);
  EXPECT_TRUE(reply.json().at("advice").is_null());
  EXPECT_EQ(server.control->prepares, 1) << "it is prepared";
  EXPECT_EQ(server.control->cuts, 0) << "nothing is fractured";
  EXPECT_EQ(server.post_json(path, R"({"sites": 50, "unit": "cm"})").status, 200);
  EXPECT_EQ(server.control->prepares, 2) << "another solid";
  EXPECT_EQ(server.post_json(path, R"({"sites": 0})").problem(), "bad-parameter");
  EXPECT_EQ(server.post_json("/meshes/" + id_of("other") + "/estimate", "{}").problem(), "not-found");
}

TEST(Meshes, PostNamesItItself) {
  TestServer server;
  const Reply created = server.post("/meshes", "mesh");
  EXPECT_EQ(created.status, 201);
  EXPECT_EQ(created.header("location"), "/meshes/" + id_of("mesh"));
}

/// Waiting requests keep their meshes. A client that stores, uses and deletes meshes in turn reaches its
/// share of the store, and there is still room for another client's mesh.
TEST(Meshes, DeletedMeshesOfQueuedRequestsCountAgainstTheStore) {
  Gate gate;
  TestServerOptions options;
  options.store.quota_bytes = 1 << 20;
  TestServer server(options);
  server.control->during_cut = gate.hook();
  const auto use = [&](int k, const std::string& from) {
    const std::string mesh = std::to_string(k) + std::string(100'000, 'm'), path = "/meshes/" + id_of(mesh);
    const Reply put = ask(server.port(), "PUT", path, "Content-Type: model/obj\r\n", mesh, from);
    if (put.status != 201) return put;
    Reply job = ask(server.port(), "POST", path + "/fracture", kRespondAsync, "", from);
    ask(server.port(), "DELETE", path, "", "", from);
    return job;
  };
  int taken = 0;
  Reply last;
  while (taken < 20 && (last = use(taken, "127.0.0.2")).status == 202) ++taken;
  EXPECT_EQ(taken, 5) << "half of the store, because no other client uses any";
  EXPECT_EQ(last.problem(), "over-share") << last.body;
  EXPECT_NE(last.header("retry-after"), "");
  EXPECT_LE(server.api.meshes().figures().bytes, options.store.quota_bytes);
  EXPECT_EQ(use(100, "127.0.0.3").status, 202) << "another client";
  gate.open = true;
  EXPECT_TRUE(eventually(kPatience, "nothing to be held any more",
                         [&] { return server.api.meshes().figures().bytes == 0; }));
}

TEST(Meshes, AWrongDigestIsRefusedAndNothingStored) {
  TestServer server;
  const Reply refused = server.put("/meshes/" + id_of("mesh"), "another mesh");
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.problem(), "digest-mismatch");
  EXPECT_NE(refused.body.find(id_of("another mesh")), std::string::npos) << "says what it is";
  EXPECT_EQ(server.get("/meshes/" + id_of("mesh")).status, 404);
  EXPECT_EQ(server.put("/meshes/nonsense", "mesh").status, 404);
  EXPECT_EQ(server.control->imports, 0);
}

TEST(Meshes, AMeshThatCannotBeUsedIsNotStored) {
  TestServer server;
  server.control->import = [](std::string_view) -> Expected<Mesh> {
    return fail(ErrorCode::kMalformedMesh, "broken");
  };
  EXPECT_EQ(server.put("/meshes/" + id_of("mesh"), "mesh").problem(), "malformed-mesh");
  EXPECT_EQ(server.get("/meshes/" + id_of("mesh")).problem(), "not-found");
}

TEST(Meshes, AnUploadPastItsDeadlineIsToldOfItsMeshAndNotOfSites) {
  Gate gate;
  TestServer server;
  server.control->during_import = gate.hook();
  const Reply reply = ask(server.port(), "PUT", "/meshes/" + id_of("mesh"),
                          "Content-Type: model/obj\r\nRequest-Timeout: 0.05\r\n", "mesh");
  EXPECT_EQ(reply.status, 504);
  const auto detail = reply.json().at("detail").get<std::string>();
  EXPECT_NE(detail.find("smaller mesh"), std::string::npos) << detail;
  EXPECT_NE(detail.find("Request-Timeout"), std::string::npos) << detail;
  EXPECT_EQ(detail.find("sites"), std::string::npos) << detail;
  EXPECT_EQ(server.get("/meshes/" + id_of("mesh")).status, 404);
}

TEST(Meshes, AStoredMeshIsFracturedWithoutSendingItAgain) {
  TestServer server;
  const std::string path = "/meshes/" + id_of("mesh");
  EXPECT_EQ(server.post_json(path + "/fracture", R"({"sites": 7})").problem(), "not-found");
  ASSERT_EQ(server.put(path, "mesh").status, 201);
  const Reply made = server.post_json(path + "/fracture", R"({"sites": 7, "seed": 3})");
  ASSERT_EQ(made.status, 200) << made.body;
  EXPECT_EQ(server.control->imports, 1);
  const Reply by_mesh = server.post("/fracture?sites=7&seed=3", "mesh");
  EXPECT_EQ(by_mesh.body, made.body) << "the same bytes, whichever way it is asked";
  EXPECT_EQ(by_mesh.header("cache-status"), "result; hit");
  EXPECT_EQ(server.post(path + "/fracture?sites=7&seed=3", "", "").header("etag"), made.header("etag"));
  const Reply named =
      server.post_json("/fracture", R"({"seed": 3, "mesh": ")" + id_of("mesh") + R"(", "sites": 7})");
  EXPECT_EQ(named.header("etag"), made.header("etag")) << named.body;
}

TEST(Meshes, AnEvictedPreparationIsMadeAgainFromTheStoredBytes) {
  TestServerOptions options;
  options.service.mesh_cache_bytes = 0;  // keeps nothing
  TestServer server(options);
  server.put("/meshes/" + id_of("mesh"), "mesh");
  EXPECT_EQ(server.control->imports, 1);
  EXPECT_EQ(server.post_json("/meshes/" + id_of("mesh") + "/fracture", "{}").status, 200);
  EXPECT_EQ(server.control->imports, 2);
}

TEST(Meshes, ADeletedMeshIsGone) {
  TestServer server;
  const std::string path = "/meshes/" + id_of("mesh");
  server.put(path, "mesh");
  EXPECT_EQ(ask(server.port(), "DELETE", path).status, 204);
  EXPECT_EQ(ask(server.port(), "DELETE", path).status, 404);
  EXPECT_EQ(server.post_json(path + "/fracture", "{}").status, 404);
}

TEST(Meshes, AnIdOfAnotherFormIsToldFromAMeshThatIsGone) {
  TestServer server;
  const Reply malformed = server.post_json("/meshes/foo/fracture", "{}"),
              gone = server.post_json("/meshes/" + id_of("mesh") + "/fracture", "{}");
  EXPECT_EQ(malformed.problem(), "not-found");
  EXPECT_NE(malformed.body.find("64 lower-case hex digits"), std::string::npos) << malformed.body;
  EXPECT_EQ(gone.problem(), "not-found");
  EXPECT_NE(gone.body.find("PUT it to /meshes/" + id_of("mesh")), std::string::npos) << gone.body;
}

TEST(Meshes, TheQuotaAndTheTimeToLiveHold) {
  TestServerOptions options;
  options.store = {.quota_bytes = 60'000, .ttl = std::chrono::milliseconds(200)};
  TestServer server(options);
  const std::string large(60'001, 'l'), first(40'000, 'f'), second(30'000, 's');
  const Reply over = server.put("/meshes/" + id_of(large), large);
  EXPECT_EQ(over.status, 413);
  EXPECT_EQ(over.problem(), "body-too-large");
  EXPECT_NE(over.body.find("60 kB (--mesh-store)"), std::string::npos) << over.body;
  EXPECT_EQ(server.put("/meshes/" + id_of(first), first).status, 201);
  EXPECT_EQ(server.put("/meshes/" + id_of(second), second).status, 201);
  EXPECT_EQ(server.get("/meshes/" + id_of(first)).status, 404);
  // Asking for a mesh restarts its time to live, so the test asks for another one.
  EXPECT_TRUE(eventually(kPatience, "the mesh to be forgotten", [&] {
    server.get("/meshes/" + id_of(first));
    return server.api.meshes().figures().expired == 1u;
  }));
  EXPECT_EQ(server.get("/meshes/" + id_of(second)).status, 404);
  EXPECT_EQ(server.api.meshes().figures().expired, 1u);
  EXPECT_EQ(server.api.meshes().figures().evicted, 1u);
}

TEST(Meshes, AMeshOfSeveralFilesHasTheDigestOfAll) {
  TestServer server;
  const std::string form =
      "--B\r\nContent-Disposition: form-data; name=mesh; filename=a.gltf\r\n\r\n{}\r\n"
      "--B\r\nContent-Disposition: form-data; name=file; filename=a.bin\r\n\r\nbytes\r\n--B--\r\n";
  // The digest as openapi.yaml describes it, written out.
  const std::string digest =
      "sha256:" +
      sha256("fracture files 2\n" +
             sha256("files\n" + sha256("{}").hex() + "\n5 a.bin " + sha256("bytes").hex() + "\n").hex())
          .hex();
  const Reply created =
      server.put("/meshes/" + digest, form, "Content-Type: multipart/form-data; boundary=B\r\n");
  ASSERT_EQ(created.status, 201) << created.body;
  EXPECT_EQ(created.json().at("files"), 1);
  std::size_t seen = 0;
  server.control->files = [&](std::span<const ImportFile> files) { seen = files.size(); };
  EXPECT_EQ(server.post_json("/meshes/" + digest + "/fracture?unit=cm", "").status, 200);
  EXPECT_EQ(seen, 1u) << "prepared anew, from all of its files";
}

TEST(Meshes, TheBodyOfACollisionIsSmallAndJson) {
  TestServer server;
  const std::string path = "/meshes/" + id_of("mesh");
  server.put(path, "mesh");
  EXPECT_EQ(server.post_json(path + "/fracture", "{\"sites\": 1" + std::string(70'000, ' ') + "}").status,
            413);
  EXPECT_EQ(server.post(path + "/fracture", "{}", "Content-Type: text/plain\r\n").problem(),
            "unsupported-media-type");
  EXPECT_EQ(server.post_json(path + "/fracture", "[]").problem(), "bad-json");
  EXPECT_EQ(server.post_json(path + "/fracture", R"({"sites": 0})").problem(), "bad-parameter");
  EXPECT_EQ(server.post_json(path + "/fracture", R"({"format": "obj"})").problem(), "bad-parameter");
  EXPECT_EQ(server.post_json("/fracture", R"({"sites": 5})").problem(), "bad-parameter");
  EXPECT_EQ(server.post_json("/fracture", R"({"mesh": "sha256:00"})").problem(), "not-found");
}

/// If no token is required, the client that stores most still makes room for others, and all clients see and
/// delete everything.
TEST(Meshes, WhoStoresMostMakesRoomForOthers) {
  TestServerOptions options;
  options.store.quota_bytes = 200'000;
  TestServer server(options);
  const auto put = [&](const std::string& mesh, const std::string& from) {
    return ask(server.port(), "PUT", "/meshes/" + id_of(mesh), "Content-Type: model/gltf-binary\r\n", mesh,
               from)
        .status;
  };
  const std::string mine(20'000, 'm');
  EXPECT_EQ(put(mine, "127.0.0.2"), 201);
  for (char letter = 'a'; letter < 'm'; ++letter)
    EXPECT_EQ(put(std::string(30'000, letter), "127.0.0.3"), 201);
  EXPECT_EQ(server.get("/meshes/" + id_of(mine)).status, 200);
  EXPECT_GT(server.api.meshes().figures().evicted, 5u);
  EXPECT_EQ(put(mine, "127.0.0.3"), 201) << "it has a place of its own there";
  EXPECT_EQ(put(mine, "127.0.0.3"), 200);
  EXPECT_EQ(ask(server.port(), "DELETE", "/meshes/" + id_of(mine), "", "", "127.0.0.4").status, 204);
  EXPECT_EQ(server.get("/meshes/" + id_of(mine)).status, 404);
}

}  // namespace
}  // namespace fracture::test
