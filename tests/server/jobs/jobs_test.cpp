// Prefer: respond-async, and the life of the job.
#include <gtest/gtest.h>

#include "tests/server/support/job_server.hpp"

namespace fracture::test {
namespace {

TEST(Jobs, AJobIsStartedFollowedAndItsResultFetched) {
  TestServer server;
  Gate gate;
  server.control->during_cut = gate.hook();
  const Reply accepted = server.post("/fracture?sites=5", "mesh", kAsync);
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  EXPECT_EQ(accepted.header("preference-applied"), "respond-async");
  const std::string job = accepted.header("location");
  EXPECT_EQ(job.substr(0, 6 + 16), "/jobs/" + sha256("mesh").hex().substr(0, 16)) << "routable by the mesh";
  gate.wait_for(1);
  const auto running = wait_for_state(server, job, "running");
  EXPECT_EQ(running.at("stage"), "clip");
  EXPECT_LT(running.at("percent"), 100);
  EXPECT_FALSE(running.contains("result"));
  gate.open = true;
  const auto done = wait_for_state(server, job, "done");
  EXPECT_EQ(done.at("percent"), 100);
  const Reply result = server.get(done.at("result"));
  EXPECT_EQ(result.status, 200);
  EXPECT_EQ(result.body, server.post("/fracture?sites=5", "mesh").body);
  EXPECT_EQ(server.control->cuts, 1);
}

TEST(Jobs, TheResultIsKeptForTheJobWhenTheCacheForgetsIt) {
  TestServerOptions options;
  options.service.result_cache_bytes = 0;
  TestServer server(options);
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  const std::string result = wait_for_state(server, job, "done").at("result");
  EXPECT_EQ(server.get(result).header("cache-status"), "job; hit");
  EXPECT_EQ(ask(server.port(), "DELETE", job).status, 204);
  EXPECT_EQ(server.get(job).status, 404);
  EXPECT_EQ(server.get(result).status, 404);
}

TEST(Jobs, ACancelledJobStopsItsComputation) {
  TestServer server;
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  wait_for_state(server, job, "running");
  EXPECT_EQ(ask(server.port(), "DELETE", job).status, 204);
  const auto cancelled = wait_for_state(server, job, "cancelled");
  EXPECT_EQ(cancelled.at("error").at("type"), "/problems/cancelled");
  server.dispatcher.wait_idle();  // The gate is closed, so the computation would never end by itself.
  EXPECT_EQ(server.control->cancelled, 1);
}

TEST(Jobs, AJobThatFailsSaysWhy) {
  TestServer server;
  server.control->import = [](std::string_view) -> Expected<Mesh> {
    return fail(ErrorCode::kMalformedMesh, "broken at byte 7");
  };
  const auto failed =
      wait_for_state(server, server.post("/fracture", "mesh", kAsync).header("location"), "failed");
  EXPECT_EQ(failed.at("error").at("type"), "/problems/malformed-mesh");
  EXPECT_EQ(failed.at("error").at("detail"), "broken at byte 7");
}

TEST(Jobs, TheQueuePositionIsHowManyGoBefore) {
  TestServerOptions options;
  options.threads = 1;
  TestServer server(options);
  Gate gate;
  server.control->during_cut = gate.hook();
  std::vector<std::string> jobs;
  for (int seed = 0; seed < 3; ++seed)
    jobs.push_back(server.post("/fracture?seed=" + std::to_string(seed), "mesh", kAsync).header("location"));
  wait_for_state(server, jobs[0], "running");
  EXPECT_EQ(server.get(jobs[1]).json().at("queue_position"), 0);
  EXPECT_EQ(server.get(jobs[2]).json().at("queue_position"), 1);
  EXPECT_EQ(server.get(jobs[2]).json().at("state"), "queued");
  gate.open = true;
  for (const std::string& job : jobs) wait_for_state(server, job, "done");
}

TEST(Jobs, TheEventsTellEveryChangeOnceAndEndWithTheJob) {
  TestServer server;
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  RawClient client(server.port());
  client.send("GET " + job +
              "/events HTTP/1.0\r\nHost: test\r\n\r\n");  // without chunks: the body ends with the connection
  const auto head = client.receive();
  ASSERT_TRUE(head);
  EXPECT_EQ(head->header("content-type"), "text/event-stream");
  ASSERT_TRUE(client.receive_until("\n\n"));  // The first event must arrive before the job may end.
  require_eventually(kPatience, "a computation to come to the gate", [&] { return gate.arrived > 0; });
  gate.open = true;
  const std::string stream = client.receive_all();
  EXPECT_FALSE(client.timed_out());
  int percent = 0, events = 0;
  std::string last;
  for (std::size_t at = stream.find("data: "); at != std::string::npos; at = stream.find("data: ", at + 1)) {
    const auto data = nlohmann::json::parse(stream.substr(at + 6, stream.find('\n', at) - at - 6));
    EXPECT_GE(data.at("percent"), percent) << "never falls";
    percent = data.at("percent");
    last = data.at("state");
    ++events;
  }
  EXPECT_EQ(last, "done");
  EXPECT_EQ(percent, 100);
  EXPECT_GE(events, 2);
  EXPECT_NE(stream.find("event: done\n"), std::string::npos);
}

TEST(Jobs, AnEventStreamOnAKeptConnectionIsChunkedAndTheConnectionGoesOn) {
  TestServer server;
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  wait_for_state(server, job, "done");
  RawClient client(server.port());
  client.send("GET " + job +
              "/events HTTP/1.1\r\nHost: test\r\n\r\n"
              "GET /version HTTP/1.1\r\nHost: test\r\nConnection: close\r\n\r\n");
  const std::string all = client.receive_all();
  EXPECT_NE(all.find("Transfer-Encoding: chunked"), std::string::npos);
  EXPECT_NE(all.find("event: done\n"), std::string::npos);
  EXPECT_NE(all.find("\r\n0\r\n\r\nHTTP/1.1 200"), std::string::npos) << all;
}

TEST(Jobs, AServerThatStopsEndsItsStreamsAndItsJobs) {
  Gate gate;
  std::shared_ptr<FakeControl> control;
  std::string stream;
  {
    TestServer server;
    control = server.control;
    server.control->during_cut = gate.hook();
    const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
    RawClient client(server.port());
    client.send("GET " + job + "/events HTTP/1.1\r\nHost: test\r\n\r\n");
    ASSERT_TRUE(client.receive()) << "the header of the stream";
    require_eventually(kPatience, "a computation to come to the gate", [&] { return gate.arrived > 0; });
    server.server.stop_accepting();
    stream = client.receive_all();
    EXPECT_FALSE(client.timed_out());
  }  // The destructor waits for all work. It would hang if the job went on.
  EXPECT_EQ(control->cancelled, 1);
  EXPECT_NE(stream.find("\r\n0\r\n\r\n"), std::string::npos) << stream;
}

TEST(Jobs, FinishedJobsAreForgottenAfterTheirTimeAndGiveUpTheirBytesForOthers) {
  TestServerOptions options;
  options.jobs.ttl = std::chrono::milliseconds(100);
  TestServer server(options);
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  EXPECT_TRUE(
      eventually(kPatience, "the job to be forgotten", [&] { return server.get(job).status == 404; }));
  EXPECT_EQ(server.api.jobs().figures().expired, 1u);

  TestServerOptions narrow;
  narrow.jobs.max_result_bytes = 1;
  TestServer other(narrow);
  const std::string first = other.post("/fracture", "mesh", kAsync).header("location");
  other.dispatcher.wait_idle();
  const Reply done = other.get(first);
  EXPECT_EQ(done.status, 200) << "it is done all the same";
  EXPECT_EQ(done.json().value("state", ""), "done");
  EXPECT_EQ(other.api.jobs().figures().results_evicted, 1u);
  EXPECT_EQ(other.api.jobs().figures().evicted, 0u);
  EXPECT_EQ(other.api.jobs().figures().result_bytes, 0u);
}

/// The deadlines of requests pass before the computation may go on.
TEST(Jobs, AJobHasADeadlineOfItsOwnWhateverTheRouteAndThePriority) {
  TestServerOptions options;
  options.limits.deadline = options.limits.realtime_deadline = std::chrono::milliseconds(20);
  TestServer server(options);
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string mesh = "/meshes/sha256:" + sha256("mesh").hex();
  // The mesh is prepared within 20 ms, or on another attempt.
  ASSERT_TRUE(
      eventually(kPatience, "the stored mesh", [&] { return server.put(mesh, "mesh").status / 100 == 2; }));
  const Reply stored = server.post_json(mesh + "/fracture", "{}", "Prefer: respond-async\r\n");
  const Reply urgent =
      server.post_json(mesh + "/fracture", R"({"seed": 2})", "Prefer: respond-async\r\nPriority: u=0\r\n");
  ASSERT_EQ(stored.status, 202) << stored.body;
  ASSERT_EQ(urgent.status, 202) << urgent.body;
  for (const Reply* reply : {&stored, &urgent}) wait_for_state(server, reply->header("location"), "running");
  // pause: the deadline of requests passes, and the jobs go on
  std::this_thread::sleep_for(5 * options.limits.deadline);
  gate.open = true;
  for (const Reply* reply : {&stored, &urgent}) wait_for_state(server, reply->header("location"), "done");
}

TEST(Jobs, AJobIsBackgroundWorkWhateverTheRouteAndThePriority) {
  TestServerOptions options;
  options.threads = 1;
  TestServer server(options);
  const std::string mesh = "/meshes/sha256:" + sha256("mesh").hex();
  ASSERT_EQ(server.put(mesh, "mesh").status, 201);
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string first =
      server.post_json(mesh + "/fracture", "{}", "Prefer: respond-async\r\n").header("location");
  wait_for_state(server, first, "running");
  const std::string job =
      server.post_json(mesh + "/fracture", R"({"seed": 2})", "Prefer: respond-async\r\nPriority: u=0\r\n")
          .header("location");
  RawClient urgent(server.port());
  urgent.send("POST " + mesh +
              "/fracture HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\nContent-Length: "
              "11\r\n\r\n{\"seed\": 3}");
  EXPECT_TRUE(eventually(kPatience, "the realtime request to begin while the first job stands still",
                         [&] { return gate.arrived == 2; }));
  EXPECT_EQ(server.get(job).json().at("state"), "queued");
  EXPECT_EQ(server.get(first).json().at("state"), "running");
  gate.open = true;
  ASSERT_TRUE(urgent.receive());
  wait_for_state(server, job, "done");
}

/// A job that others crowd out of memory once or twice does not fail. It begins again when there is room.
TEST(Jobs, AJobThatIsCrowdedOutOfMemoryBeginsAgain) {
  TestServer server;
  std::atomic<int> attempts{0};
  server.control->cut_error = [&]() -> std::optional<Error> {
    if (++attempts > 2) return std::nullopt;
    return Error{attempts == 1 ? ErrorCode::kOutOfMemory : ErrorCode::kOverShare,
                 "Others, or others of this client, hold too much.",
                 {},
                 Figures(nlohmann::json{{"bytes", 1000}})};
  };
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  wait_for_state(server, job, "done");
  EXPECT_EQ(attempts, 3);

  // If memory is truly exhausted, another attempt would not help.
  server.control->cut_error = [] { return Error{ErrorCode::kOutOfMemory, "Memory is exhausted."}; };
  const std::string failed = server.post("/fracture?seed=2", "mesh", kAsync).header("location");
  EXPECT_EQ(wait_for_state(server, failed, "failed").at("error").at("status"), 503);
}

TEST(Jobs, AJobThatIsCrowdedOutWaitsForTheMemoryAndCanBeCancelled) {
  TestServerOptions options;
  options.jobs.deadline = std::chrono::minutes(1);
  TestServer server(options);
  std::atomic<int> attempts{0};
  server.control->cut_error = [&]() -> std::optional<Error> {
    ++attempts;
    return Error{ErrorCode::kOutOfMemory,
                 "Others hold too much.",
                 {},
                 Figures(nlohmann::json{{"bytes", std::uint64_t{1} << 40}})};
  };
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string other = server.post("/fracture?seed=1", "mesh", kAsync).header("location");
  const std::string job = server.post("/fracture?seed=2", "mesh", kAsync).header("location");
  EXPECT_TRUE(eventually(kPatience, "both to run", [&] { return gate.arrived == 2; }));
  EXPECT_EQ(ask(server.port(), "DELETE", other).status, 204);
  EXPECT_EQ(ask(server.port(), "DELETE", job).status, 204);
  gate.open = true;
  wait_for_state(server, job, "cancelled");
  EXPECT_EQ(attempts, 0);
}

TEST(Jobs, ADeadlineThatPassesFailsTheJobInItsOwnWords) {
  TestServerOptions options;
  options.jobs.deadline = std::chrono::milliseconds(50);
  TestServer server(options);
  Gate gate;  // never opened
  server.control->during_cut = gate.hook();
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  const auto failed = wait_for_state(server, job, "failed");
  EXPECT_EQ(failed.at("error").at("type"), "/problems/deadline-exceeded");
  EXPECT_NE(failed.at("error").at("detail").get<std::string>().find("--job-deadline"), std::string::npos);

  TestServer patient;
  patient.control->during_cut = gate.hook();
  const std::string shorter =
      patient.post("/fracture", "mesh", kAsync + "Request-Timeout: 0.05\r\n").header("location");
  EXPECT_EQ(wait_for_state(patient, shorter, "failed").at("error").at("type"), "/problems/deadline-exceeded");
}

TEST(Jobs, ProgressMovesWithinTheLoopsOfOneStage) {
  TestServer server;
  std::atomic<int> allowed{0};
  server.control->during_cut = [&](const Execution& execution) {
    parallel_for(execution, 64, 1, [&](std::size_t begin, std::size_t) {
      require_eventually(kPatience, "the test to allow this block", [&] {
        execution.poll();
        return static_cast<int>(begin) < allowed;
      });
    });
  };
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  int percent = wait_for_state(server, job, "running").at("percent");
  int moves = 0;
  for (int k = 8; k <= 64; k += 8) {
    allowed = k;
    if (k == 64) break;
    const int before = percent;
    EXPECT_TRUE(eventually(kPatience, "the percent to move",
                           [&] {
                             percent = server.get(job).json().at("percent");
                             return percent > before;
                           }))
        << "stands at " << before;
    moves += percent > before;
  }
  EXPECT_GE(moves, 5);
  EXPECT_LT(percent, 90) << "the stage is not over";
  wait_for_state(server, job, "done");
}

TEST(Jobs, UnknownOnesAreNotFound) {
  TestServer server;
  for (const char* path : {"/jobs/0123456789abcdef-0123456789abcdef", "/jobs/x", "/jobs/x/events"})
    EXPECT_EQ(server.get(path).problem(), "not-found") << path;
  EXPECT_EQ(ask(server.port(), "DELETE", "/jobs/x").status, 404);
}

}  // namespace
}  // namespace fracture::test
