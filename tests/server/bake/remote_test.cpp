// A bake through a server: the whole HTTP layer with a fake engine, behind a relay that can misbehave.
#include "server/bake/remote_baker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <stop_token>
#include <thread>

#include "server/bake/failure.hpp"
#include "server/bake/form.hpp"
#include "server/http/multipart.hpp"
#include "tests/server/bake/remote_bakers.hpp"
#include "tests/server/support/bake_farm.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;
using test::FakeReply;
using test::FakeRequest;
using testing::HasSubstr;

std::unique_ptr<Baker> baker_for(const Farm& farm, const Patience& patience = short_pauses()) {
  auto baker = baker_at(farm.relay.port(), patience);
  if (!baker) throw std::runtime_error(to_line(baker.error()));
  return std::move(*baker);
}

struct Asked {
  std::string mesh = "a mesh";
  json parameters = json::object();
  MeshFormat format = MeshFormat::kObj;
  std::vector<std::pair<std::string, std::string>> files{};
  OutputFormat output = OutputFormat::kGlb;
};

/// The request borrows its bytes from `asked`.
FractureRequest request_of(Baker& baker, const Asked& asked) {
  std::vector<RawParameter> given;
  for (const auto& [name, value] : asked.parameters.items()) given.push_back({name, value, false});
  const Expected<RequestParameters> parameters = baker.parse(given);
  if (!parameters) throw std::runtime_error(parameters.error().detail);
  FractureRequest request{std::as_bytes(std::span(asked.mesh)), asked.format, *parameters};
  for (const auto& [name, bytes] : asked.files)
    request.files.push_back({name, std::as_bytes(std::span(bytes))});
  request.output = asked.output;
  return request;
}

Expected<Baked> bake(Baker& baker, const Asked& asked, const std::stop_token& stop = {}) {
  return baker.bake(request_of(baker, asked), {}, stop);
}

/// The answer to the same request without a server.
std::vector<std::uint8_t> local_file(Baker& baker, const Asked& asked) {
  FractureService service({}, std::make_unique<test::FakeEngine>(std::make_shared<test::FakeControl>()));
  return service.fracture(request_of(baker, asked), {})->result->file;
}

void expect_local_file(Baker& baker, const Asked& asked) {
  const auto baked = bake(baker, asked);
  ASSERT_TRUE(baked) << to_line(baked.error());
  EXPECT_EQ(*baked->file, local_file(baker, asked));
  EXPECT_EQ(baked->digest.hex(), sha256(std::as_bytes(std::span(*baked->file))).hex());
  EXPECT_EQ(baked->summary.certificate.fragments, request_of(baker, asked).parameters.fracture.sites);
}

Error failure(Baker& baker, const Asked& asked) {
  auto baked = bake(baker, asked);
  if (baked) throw std::runtime_error("it was baked");
  return std::move(baked.error());
}

// -- a server that works

TEST(RemoteBaker, GivesTheBytesOfALocalBakeAndSendsEachMeshOnce) {
  Farm farm;
  const auto baker = baker_for(farm);
  {
    std::vector<std::jthread> threads;
    for (int k = 1; k <= 6; ++k)
      threads.emplace_back([&, k] {
        expect_local_file(*baker, {.parameters = {{"seed", k}, {"material", "wood"}}});
      });
  }
  expect_local_file(*baker, {.mesh = "another", .parameters = {{"sites", 7}}, .format = MeshFormat::kStl});
  EXPECT_EQ(farm.count("PUT "), 2);
  EXPECT_EQ(farm.count("PUT /meshes/sha256:" + sha256("a mesh").hex() + " "), 1);
  EXPECT_EQ(farm.server.control->cuts, 7);
}

TEST(RemoteBaker, EveryPathThatConcernsAMeshBeginsWithItsDigest) {
  Farm farm;
  expect_local_file(*baker_for(farm), {});
  const std::string digest = sha256("a mesh").hex(), sixteen = digest.substr(0, 16);
  for (const FakeRequest& request : farm.relay.requests()) {
    if (request.target == "/version" || request.target == "/limits") continue;
    EXPECT_TRUE(request.target.starts_with("/meshes/sha256:" + digest) ||
                request.target.starts_with("/jobs/" + sixteen) ||
                request.target.starts_with("/fractures/sha256:" + sixteen))
        << request.target;
  }
}

TEST(RemoteBaker, SendsFurtherFilesWithTheMesh) {
  Farm farm;
  std::map<std::string, std::string> seen;
  farm.server.control->files = [&](std::span<const ImportFile> files) {
    for (const ImportFile& file : files)
      seen[file.name] = {reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size()};
  };
  const Asked asked{.mesh = "{}",
                    .format = MeshFormat::kGltf,
                    .files = {{"scene.bin", std::string("\r\n--fracture-bake\r\n\0x", 20)},
                              {"textures/\"oak\" \xc3\xa4.png", "pixels"}}};
  expect_local_file(*baker_for(farm), asked);
  EXPECT_EQ(seen, (std::map<std::string, std::string>(asked.files.begin(), asked.files.end())));
}

TEST(RemoteBaker, AsksForGltfWhereThatIsWanted) {
  Farm farm;
  expect_local_file(*baker_for(farm), {.output = OutputFormat::kGltf});
  for (const FakeRequest& request : farm.relay.requests())
    if (request.target.find("/fracture") != std::string::npos) {
      EXPECT_THAT(request.head, HasSubstr("Accept: model/gltf+json\r\n")) << request.target;
    }
}

TEST(RemoteBaker, ParametersTooLongForThePathOfAMeshGoWithIt) {
  Farm farm;
  json points = json::array();
  for (int k = 0; k < 5000; ++k) points.push_back({k * 0.001, 0.5, -k * 0.002});
  expect_local_file(*baker_for(farm), {.parameters = {{"pattern", "points"}, {"points", points}}});
  EXPECT_EQ(farm.count("POST /fracture "), 1);
  EXPECT_EQ(farm.count("PUT "), 0);
}

TEST(RemoteBaker, AMeshThatIsStoredInAnotherFormatIsSentAlong) {
  Farm farm;
  const std::string path = "/meshes/sha256:" + sha256("a mesh").hex();
  ASSERT_EQ(
      farm.server.put(path + "?format=stl", "a mesh", "Content-Type: application/octet-stream\r\n").status,
      201);
  expect_local_file(*baker_for(farm), {});
  EXPECT_EQ(farm.count("POST /fracture "), 1);
}

// -- a server that fails

TEST(RemoteBaker, WaitsUntilABusyOrAbsentServerAnswers) {
  Farm farm;
  std::map<std::string, int> asked;
  farm.rude = [&](const FakeRequest& request) -> std::optional<FakeReply> {
    const std::string what = request.method + " " + request.target.substr(0, 7);
    switch (asked[what]++) {
      case 0:
        return problem(503, "overloaded", "Retry-After: 0\r\n");
      case 1:
        return FakeReply{"", true};  // closed
      case 2:
        return FakeReply::answer(502, "<html>Bad gateway</html>");
      case 3:
        return problem(429, "too-many-connections", "Retry-After: 0\r\n");
      case 4:
        return FakeReply{"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nhalf", true};
      case 5:
        return FakeReply::answer(504, "");
      default:
        return std::nullopt;
    }
  };
  expect_local_file(*baker_for(farm), {});
  for (const char* what : {"GET /versio", "POST /meshes", "PUT /meshes", "GET /jobs/0", "GET /fractu"})
    EXPECT_TRUE(asked.contains(what) || std::string(what) == "GET /jobs/0") << what;
  EXPECT_EQ(farm.server.control->cuts, 1) << "asked often, computed once";
}

TEST(RemoteBaker, BeginsAgainWhereTheServerHasForgotten) {
  Farm farm;
  std::map<std::string, int> lost;
  farm.rude = [&](const FakeRequest& request) -> std::optional<FakeReply> {
    if (request.target.ends_with("/events") && lost["job"]++ < 2) return problem(404, "not-found");
    if (request.target.starts_with("/fractures/")) {
      const int n = lost["result"]++;
      if (n == 0) return problem(404, "not-found");
      if (n == 1) {  // damaged in transit
        FakeReply reply = test::pass_on(request, farm.server.port());
        reply.bytes.back() = static_cast<char>(reply.bytes.back() ^ 1);
        return reply;
      }
    }
    if (request.target.ends_with("/fracture") && lost["mesh"]++ == 2) {
      const std::string mesh = request.target.substr(0, request.target.rfind('/'));
      EXPECT_EQ(test::ask(farm.server.port(), "DELETE", mesh).status, 204);
    }
    return std::nullopt;
  };
  // The job must be seen unfinished, so that the client asks for its events.
  farm.server.control->during_cut = [&](const Execution& execution) {
    test::require_eventually(test::kPatience, "somebody to ask for the job", [&] {
      execution.poll();
      return farm.count("GET /jobs/") > 0;
    });
  };
  expect_local_file(*baker_for(farm), {});
  EXPECT_GE(lost["result"], 3);
  EXPECT_EQ(farm.count("PUT "), 2);
}

TEST(RemoteBaker, WhatIsForgottenAgainAndAgainFailsAlone) {
  Farm farm;
  const Asked lost{.mesh = "lost"}, good{.mesh = "good"};
  const auto baker = baker_for(farm);
  const std::string sixteen = sha256(lost.mesh).hex().substr(0, 16);
  farm.rude = [&](const FakeRequest& request) -> std::optional<FakeReply> {
    if (request.target.starts_with("/fractures/sha256:" + sixteen)) return problem(404, "not-found");
    return std::nullopt;
  };
  const Error failed = failure(*baker, lost);
  EXPECT_EQ(outcome_of(failed.code), Outcome::kFailed);
  EXPECT_THAT(to_line(failed), HasSubstr("The server no longer has the result"));
  EXPECT_EQ(farm.count("GET /fractures/"), 29) << "once the mesh was missing";
  expect_local_file(*baker, good);
}

TEST(RemoteBaker, RefusalsAreInTheWordsOfALocalBake) {
  test::TestServerOptions options;
  options.service.max_sites = 60;
  Farm farm(options);
  farm.server.control->import = [](std::string_view bytes) -> Expected<Mesh> {
    if (bytes == "poison") return fail(ErrorCode::kMalformedMesh, "It is cut off.");
    return Mesh{};
  };
  const auto baker = baker_for(farm);
  const Error mesh = failure(*baker, {.mesh = "poison"});
  EXPECT_EQ(outcome_of(mesh.code), Outcome::kRefused);
  EXPECT_EQ(to_problem(mesh), to_problem(Error{ErrorCode::kMalformedMesh, "It is cut off."}));
  const Error sites = failure(*baker, {.parameters = {{"sites", 61}}});
  EXPECT_EQ(outcome_of(sites.code), Outcome::kRefused);
  EXPECT_EQ(sites.code, ErrorCode::kBadParameter);
  EXPECT_EQ(sites.pointer, "sites");
  EXPECT_THAT(to_line(failure(*baker, {.format = MeshFormat::kFbx})), HasSubstr("--enable-format fbx"));
  const auto of = baker->parse({{"of", "/fractures/sha256:" + std::string(64, 'a'), false}});
  ASSERT_FALSE(of);
  EXPECT_EQ(of.error().code, ErrorCode::kNoSuchAnswer);
  expect_local_file(*baker, {});
}

TEST(RemoteBaker, ADeadlineIsWorthThreeTriesAndABugOne) {
  Farm farm;
  int tries = 0;
  farm.rude = [&](const FakeRequest& request) -> std::optional<FakeReply> {
    if (!request.target.ends_with("/fracture")) return std::nullopt;
    const bool late = ++tries <= 3;
    return FakeReply::answer(202,
                             json{{"id", "0123456789abcdef-0123456789abcdef"},
                                  {"state", "failed"},
                                  {"error",
                                   {{"type", late ? "/problems/deadline-exceeded" : "/problems/internal"},
                                    {"status", late ? 504 : 500},
                                    {"detail", "So it is."}}}}
                                 .dump());
  };
  const auto baker = baker_for(farm);
  EXPECT_EQ(failure(*baker, {}).code, ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(tries, 3);
  const Error bug = failure(*baker, {});
  EXPECT_EQ(outcome_of(bug.code), Outcome::kFailed);
  EXPECT_EQ(to_line(bug), "internal: So it is.");
  EXPECT_EQ(tries, 4);
}

TEST(RemoteBaker, GivesUpWithThePatienceAndThenForAll) {
  Farm farm;
  std::atomic<bool> busy = false;
  farm.rude = [&](const FakeRequest&) -> std::optional<FakeReply> {
    if (!busy) return std::nullopt;
    return problem(503, "overloaded", "Retry-After: 3600\r\n");
  };
  Patience patience = short_pauses();
  patience.total = std::chrono::milliseconds(20);
  const auto baker = baker_for(farm, patience);
  busy = true;
  const Error first = failure(*baker, {});
  EXPECT_EQ(outcome_of(first.code), Outcome::kUnavailable);
  EXPECT_THAT(to_line(first), HasSubstr("is busy (503): Because."));
  EXPECT_THAT(to_line(first), HasSubstr("--patience"));
  busy = false;
  const std::size_t before = farm.relay.requests().size();
  EXPECT_EQ(to_line(failure(*baker, {})), to_line(first));
  EXPECT_EQ(farm.relay.requests().size(), before) << "nobody asks any more";
}

TEST(RemoteBaker, AStopEndsTheWaitingAndTheJob) {
  Farm farm;
  std::stop_source stop;
  farm.server.control->during_cut = [&](const Execution& execution) {
    test::require_eventually(test::kPatience, "somebody to ask for the job",
                             [&] { return farm.count("GET /jobs/") > 0; });
    stop.request_stop();
    test::require_eventually(test::kPatience, "the cancellation", [&] {
      execution.poll();
      return false;
    });
  };
  const auto baker = baker_for(farm);
  const auto baked = bake(*baker, {}, stop.get_token());
  ASSERT_FALSE(baked);
  EXPECT_EQ(outcome_of(baked.error().code), Outcome::kCancelled);
  test::require_eventually(test::kPatience, "the work to be cancelled",
                           [&] { return farm.server.control->cancelled > 0; });
}

TEST(RemoteBaker, SaysThatItWaitsAndThatItWentOn) {
  Farm farm;
  const auto baker = baker_for(farm);
  std::vector<std::string> said;
  baker->on_notice([&](const std::string& line) { said.push_back(line); });
  int closed = 0;
  farm.rude = [&](const FakeRequest&) -> std::optional<FakeReply> {
    if (closed++ < 4) return FakeReply{"", true};
    return std::nullopt;
  };
  expect_local_file(*baker, {});
  ASSERT_EQ(said.size(), 2u) << "once each, however often it was tried";
  EXPECT_THAT(said[0], HasSubstr("Trying again for"));
  EXPECT_THAT(said[1], HasSubstr("responds again"));
}

}  // namespace
}  // namespace fracture::bake
