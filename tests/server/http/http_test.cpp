// The HTTP adapter with a well-behaved client: requests and their answers.
#include <gtest/gtest.h>

#include <latch>
#include <thread>

#include "common/pipeline/algorithm_version.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

std::string form(const std::string& parts) { return parts + "--B--\r\n"; }
std::string part_of_form(const std::string& disposition, const std::string& body) {
  return "--B\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + body + "\r\n";
}
const std::string kFormType = "Content-Type: multipart/form-data; boundary=B\r\n";

TEST(Http, FractureAnswersWithAGlbAndSaysHowItWasMade) {
  TestServer server;
  const Reply reply = server.post("/fracture?sites=7&seed=3");
  ASSERT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(reply.header("content-type"), "model/gltf-binary");
  EXPECT_EQ(reply.body.substr(0, 4), "glTF");
  EXPECT_EQ(reply.header("etag").front(), '"');
  EXPECT_EQ(reply.header("content-location"), "/fractures/sha256:" + reply.header("etag").substr(1, 64));
  EXPECT_EQ(reply.header("cache-status"),
            "mesh; fwd=miss; stored, diagram; fwd=miss; stored, result; fwd=miss; stored");
  for (const char* stage :
       {"queue;dur=", "import;dur=", "prepare;dur=", "tetrahedralize;dur=", "clip;dur=", "encode;dur="})
    EXPECT_NE(reply.header("server-timing").find(stage), std::string::npos) << stage;
  EXPECT_EQ(reply.header("fracture-algorithm"), std::to_string(kAlgorithmVersion));
  EXPECT_EQ(reply.header("x-request-id").size(), 16u);

  const Reply again = server.post("/fracture?seed=3&sites=7");
  EXPECT_EQ(again.body, reply.body);
  EXPECT_EQ(again.header("etag"), reply.header("etag"));
  EXPECT_EQ(again.header("cache-status"), "result; hit");
}

TEST(Http, AResultIsAResourceWithAnETagUntilItLeavesTheCache) {
  TestServer server;
  const Reply made = server.post("/fracture");
  const std::string location = made.header("content-location"), etag = made.header("etag");
  const Reply got = server.get(location);
  EXPECT_EQ(got.status, 200);
  EXPECT_EQ(got.body, made.body);
  EXPECT_EQ(got.header("etag"), etag);
  EXPECT_EQ(server.get(location, "If-None-Match: \"x\", " + etag + "\r\n").status, 304);
  EXPECT_EQ(server.get(location, "If-None-Match: \"x\"\r\n").status, 200);
  EXPECT_EQ(server.get("/fractures/sha256:" + std::string(64, '0')).problem(), "not-found");
  EXPECT_EQ(server.get("/fractures/nonsense").status, 404);
  const Reply head = ask(server.port(), "HEAD", location);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("content-length"), std::to_string(made.body.size()));
}

TEST(Http, TheFiguresAloneComeAsJson) {
  TestServer server;
  const Reply reply =
      server.post("/fracture?sites=9", "mesh", "Content-Type: model/obj\r\nAccept: application/json\r\n");
  ASSERT_EQ(reply.status, 200);
  EXPECT_EQ(reply.header("content-type"), "application/json");
  EXPECT_EQ(reply.json().at("fragments"), 9);
  EXPECT_EQ(server.post("/fracture", "mesh", "Content-Type: model/obj\r\nAccept: image/png\r\n").problem(),
            "not-acceptable");
}

TEST(Http, AFormCarriesTheMeshAndItsParameters) {
  TestServer server;
  const std::string mesh = part_of_form("name=\"mesh\"; filename=\"a.obj\"", "v 0 0 0");
  const Reply by_json = server.post(
      "/fracture", form(mesh + part_of_form("name=params", R"({"sites": 11, "seed": 4})")), kFormType);
  ASSERT_EQ(by_json.status, 200) << by_json.body;
  const Reply by_fields =
      server.post("/fracture?seed=4", form(part_of_form("name=sites", "11") + mesh), kFormType);
  EXPECT_EQ(by_fields.header("etag"), by_json.header("etag"));
  const Reply by_query = server.post("/fracture?sites=11&seed=4&format=obj", "v 0 0 0", "");
  EXPECT_EQ(by_query.header("etag"), by_json.header("etag"));
}

TEST(Http, FurtherFilePartsAreTheFilesThatTheMeshMayName) {
  TestServer server;
  std::vector<std::pair<std::string, std::size_t>> seen;
  server.control->files = [&](std::span<const ImportFile> files) {
    for (const ImportFile& file : files) seen.emplace_back(file.name, file.bytes.size());
  };
  const std::string mesh = part_of_form("name=mesh; filename=a.gltf", "{}"),
                    one = part_of_form("name=file; filename=\"tex/a.png\"", "12345"),
                    two = part_of_form("name=file; filename=\".\\\\a.bin\"", "123");
  const Reply reply = server.post("/fracture", form(one + mesh + two), kFormType);
  ASSERT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(seen, (std::vector<std::pair<std::string, std::size_t>>{{"tex/a.png", 5}, {"a.bin", 3}}));
  EXPECT_EQ(server.post("/fracture", form(two + mesh + one), kFormType).header("etag"), reply.header("etag"));
  EXPECT_NE(server.post("/fracture", form(mesh + one), kFormType).header("etag"), reply.header("etag"));
  EXPECT_EQ(server.post("/fracture", form(mesh + one + one), kFormType).problem(), "malformed-multipart");
  EXPECT_EQ(
      server.post("/fracture", form(mesh + part_of_form("name=x; filename=\"\"", "")), kFormType).problem(),
      "malformed-multipart");
}

TEST(Http, DamagedFormsSayWhatIsWrong) {
  TestServer server;
  const std::string mesh = part_of_form("name=mesh; filename=a.obj", "v");
  EXPECT_EQ(server.post("/fracture", form(part_of_form("name=params", "{}")), kFormType).problem(),
            "empty-body");
  EXPECT_EQ(server.post("/fracture", form(mesh + mesh), kFormType).problem(), "malformed-multipart");
  EXPECT_EQ(server.post("/fracture", mesh, kFormType).problem(), "malformed-multipart");
  EXPECT_EQ(server.post("/fracture", form(mesh + part_of_form("name=params", "{")), kFormType).problem(),
            "bad-json");
  EXPECT_EQ(server.post("/fracture", form(mesh + part_of_form("name=params", "[]")), kFormType).problem(),
            "bad-json");
  EXPECT_EQ(
      server.post("/fracture", form(mesh + part_of_form("name=params", std::string(60'000, '['))), kFormType)
          .problem(),
      "bad-json");
  EXPECT_EQ(
      server
          .post("/fracture", form(mesh + part_of_form("name=params", R"({"sites":1,"sites":2})")), kFormType)
          .problem(),
      "bad-parameter");
  EXPECT_EQ(
      server.post("/fracture?sites=1", form(mesh + part_of_form("name=params", R"({"sites":2})")), kFormType)
          .problem(),
      "bad-parameter");
  EXPECT_EQ(server.post("/fracture", form(mesh + part_of_form("name=colour", "red")), kFormType).problem(),
            "unknown-parameter");
  EXPECT_EQ(
      server.post("/fracture", form(part_of_form("name=mesh; filename=a.exe", "v")), kFormType).problem(),
      "unknown-format");
  EXPECT_EQ(server.post("/fracture", "x", "Content-Type: multipart/form-data\r\n").problem(),
            "malformed-multipart");
}

TEST(Http, EveryErrorIsAProblemThatNamesItsParameterAndCarriesTheRequestId) {
  TestServer server;
  const Reply reply =
      server.post("/fracture?sites=-5", "mesh", "Content-Type: model/obj\r\nX-Request-Id: my-id.1\r\n");
  EXPECT_EQ(reply.status, 400);
  EXPECT_EQ(reply.header("content-type"), "application/problem+json");
  EXPECT_EQ(reply.header("x-request-id"), "my-id.1");
  const auto problem = reply.json();
  EXPECT_EQ(problem.at("type"), "/problems/bad-parameter");
  EXPECT_EQ(problem.at("status"), 400);
  EXPECT_EQ(problem.at("parameter"), "sites");
  EXPECT_EQ(problem.at("request_id"), "my-id.1");
  EXPECT_NE(problem.at("detail").get<std::string>().find("1 to 100,000"), std::string::npos);
}

TEST(Http, RefusalsFromTheHeaderAlone) {
  TestServer server;
  EXPECT_EQ(server.post("/fracture", "").problem(), "empty-body");
  EXPECT_EQ(server.post("/fracture?sites=0").problem(), "bad-parameter");
  EXPECT_EQ(server.post("/fracture?sites=1e12").problem(), "bad-parameter");
  EXPECT_EQ(server.post("/fracture?site=5").problem(), "unknown-parameter");
  EXPECT_EQ(server.post("/fracture?sites=%").problem(), "malformed-request");
  const Reply format = server.post("/fracture?format=exe");
  EXPECT_EQ(format.status, 415);
  EXPECT_NE(format.header("accept-post").find("model/gltf-binary"), std::string::npos);
  EXPECT_EQ(server.post("/fracture", "x", "Content-Type: text/html\r\n").problem(), "unknown-format");
  EXPECT_EQ(server.post("/fracture", "x", "").problem(), "unknown-format");
  EXPECT_EQ(server.post("/fracture", "x", "Content-Type: model/obj\r\nContent-Encoding: br\r\n").problem(),
            "unsupported-coding");
  EXPECT_EQ(server.get("/nothing").problem(), "not-found");
  EXPECT_EQ(server.get("/version?x=1").problem(), "unknown-parameter");
  const Reply method = server.get("/fracture");
  EXPECT_EQ(method.status, 405);
  EXPECT_EQ(method.header("allow"), "POST");
  EXPECT_EQ(ask(server.port(), "BREW", "/").status, 501);
  EXPECT_EQ(server.get("/livez").status, 404) << "the probes live on the admin listener only";
  EXPECT_EQ(server.control->imports, 0);
}

TEST(Http, ErrorsOfTheEngineKeepTheirFigures) {
  TestServer server;
  server.control->import = [](std::string_view) -> Expected<Mesh> {
    return fail(ErrorCode::kMeshNotClosed, "4 edges are open.", "mesh", {{"open_edges", 4}});
  };
  const Reply reply = server.post("/fracture");
  EXPECT_EQ(reply.status, 422);
  EXPECT_EQ(reply.problem(), "mesh-not-closed");
  EXPECT_EQ(reply.json().at("open_edges"), 4);
}

TEST(Http, ABrokenInvariantIsA500WithoutItsTextAndTheProcessGoesOn) {
  TestServer server;
  server.control->during_cut = [](const Execution&) { throw InternalError("secret 12"); };
  const Reply reply = server.post("/fracture");
  EXPECT_EQ(reply.status, 500);
  EXPECT_EQ(reply.problem(), "internal");
  EXPECT_EQ(reply.body.find("secret"), std::string::npos);
  server.control->during_cut = [](const Execution&) { throw std::bad_alloc(); };
  EXPECT_EQ(server.post("/fracture?seed=2").status, 503);
  server.control->during_cut = nullptr;
  EXPECT_EQ(server.post("/fracture").status, 200);
}

TEST(Http, ManyRequestsShareAConnectionAlsoWhenTheyArriveTogether) {
  TestServer server;
  RawClient client(server.port());
  const std::string one =
      "POST /fracture?sites=3 HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: "
      "4\r\n\r\nmesh";
  const std::string chunked =
      "POST /fracture?sites=3 HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nTransfer-Encoding: "
      "chunked\r\n\r\n"
      "2;x=y\r\nme\r\n2\r\nsh\r\n0\r\nTrailer: t\r\n\r\n";
  client.send(one + chunked + "GET /version HTTP/1.1\r\nHost: a\r\n\r\n" + one);
  const auto first = client.receive(), second = client.receive(), third = client.receive(),
             fourth = client.receive();
  ASSERT_TRUE(first && second && third && fourth);
  EXPECT_EQ(first->status, 200);
  EXPECT_EQ(second->header("etag"), first->header("etag")) << "chunks are joined";
  EXPECT_EQ(third->json().at("name"), "fracture-server");
  EXPECT_EQ(fourth->header("etag"), first->header("etag"));
}

TEST(Http, DiscoveryDescribesThisServer) {
  TestServerOptions options;
  options.limits.max_body = 12345;
  TestServer server(options);
  EXPECT_EQ(server.get("/").status, 200);
  EXPECT_EQ(server.get("/version").json().at("algorithm"), kAlgorithmVersion);
  EXPECT_EQ(server.get("/limits").json().at("max_body_bytes"), 12345);
  EXPECT_EQ(server.get("/limits").json().at("parameters").at(0).at("name"), "material");
  EXPECT_EQ(server.get("/limits").json().at("parameter_groups").at(0).at("title"), "The mesh");
  EXPECT_EQ(server.get("/openapi.json").json().at("openapi"), "3.1.0");
  EXPECT_EQ(server.get("/version", "Accept: text/html\r\n").status, 406);
  const Reply text = server.get("/llms.txt");
  EXPECT_EQ(text.header("content-type"), "text/plain; charset=utf-8");
  for (const char* said : {"Content-Type: model/gltf-binary", "`POST /meshes/{id}/fracture`",
                           "`rough_amplitude`", "/problems/mesh-not-closed"})
    EXPECT_NE(text.body.find(said), std::string::npos) << said;
  EXPECT_EQ(text.body.find("]("), std::string::npos) << "nothing leads out of it";
  const nlohmann::json patterns = server.get("/patterns").json();
  EXPECT_EQ(patterns.at("patterns").at(0).at("name"), "uniform");
  EXPECT_EQ(patterns.at("materials").at(0).at("parameters").at("pattern"), "radial");
}

TEST(Http, TheAdminListenerAnswersWhileEveryWorkerIsBusyAndTheQueueIsFull) {
  TestServerOptions options;
  options.threads = 1;
  options.max_queue = 0;
  TestServer server(options);
  std::latch release(1);
  server.control->during_cut = [&](const Execution&) { release.wait(); };
  std::thread busy([&] { EXPECT_EQ(server.post("/fracture").status, 200); });
  require_eventually(kPatience, "a cut to begin", [&] { return server.control->cuts > 0; });

  EXPECT_EQ(ask(server.server.admin_port(), "GET", "/livez").status, 200);
  EXPECT_EQ(ask(server.server.admin_port(), "GET", "/readyz").status, 200);
  EXPECT_EQ(ask(server.server.admin_port(), "POST", "/fracture").status, 404);
  const Reply refused = server.post("/fracture?seed=2");
  EXPECT_EQ(refused.problem(), "overloaded");
  EXPECT_EQ(refused.status, 503);
  EXPECT_GE(std::atoi(refused.header("retry-after").c_str()), 1);
  release.count_down();
  busy.join();
}

TEST(Http, APathOfTheAdminPortIsNamedAsSuch) {
  TestServer server;
  const Reply reply = server.get("/livez");
  EXPECT_EQ(reply.problem(), "not-found");
  EXPECT_NE(reply.body.find("Use the admin port (--admin-port)"), std::string::npos) << reply.body;
  EXPECT_NE(server.get("/nothing").body.find("GET /openapi.json"), std::string::npos);
}

TEST(Http, TheDeadlineEndsTheWork) {
  TestServerOptions options;
  options.limits.deadline = std::chrono::milliseconds(50);
  TestServer server(options);
  server.control->during_cut = [](const Execution& execution) {
    require_eventually(kPatience, "the cancellation", [&] {
      execution.poll();
      return false;
    });
  };
  const Reply reply = server.post("/fracture");
  EXPECT_EQ(reply.status, 504);
  EXPECT_EQ(reply.problem(), "deadline-exceeded");
  EXPECT_NE(reply.json().at("detail").get<std::string>().find("after 0.05 s (--deadline)"), std::string::npos)
      << reply.body;
}

}  // namespace
}  // namespace fracture::test
