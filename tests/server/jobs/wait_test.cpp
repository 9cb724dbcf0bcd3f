// Prefer: wait (RFC 7240): the client waits for a while, but no thread of the server does.
#include <gtest/gtest.h>

#include "server/http/prefer.hpp"
#include "tests/server/support/job_server.hpp"

namespace fracture::test {
namespace {

http::Preferences preferences(const std::string& field) {
  const auto head = http::parse_head("GET / HTTP/1.1\r\nHost: a\r\n" + field + "\r\n", {});
  EXPECT_TRUE(head);
  return http::preferences_of(*head);
}

TEST(Prefer, IsReadAsItsRfcSays) {
  using std::chrono::seconds;
  EXPECT_EQ(preferences("Prefer: respond-async, wait=10\r\n").wait, seconds(10));
  EXPECT_TRUE(preferences("Prefer: respond-async, wait=10\r\n").respond_async);
  EXPECT_TRUE(preferences("Prefer: wait=10\r\nPrefer: Respond-Async\r\n").respond_async) << "two fields";
  EXPECT_EQ(preferences("Prefer: WAIT = \"7\" ; x=y\r\n").wait, seconds(7)) << "a quoted value, a parameter";
  EXPECT_EQ(preferences("Prefer: wait=3, wait=9\r\n").wait, seconds(3)) << "the first counts";
  EXPECT_FALSE(preferences("Prefer: x=\"respond-async, wait=4\"\r\n").respond_async) << "within quotes";
  EXPECT_FALSE(preferences("Prefer: x=\"a\\\", wait=4\"\r\n").wait) << "an escaped quote";
  for (const char* wrong : {"wait", "wait=", "wait=-1", "wait=1.5", "wait=x", "wait=\"", "waiting=5"})
    EXPECT_FALSE(preferences(std::string("Prefer: ") + wrong + "\r\n").wait) << wrong;
  for (const char* long_one : {"wait=61", "wait=86400", "wait=99999999999999999999999"})
    EXPECT_EQ(preferences(std::string("Prefer: ") + long_one + "\r\n").wait, http::kLongestWait) << long_one;
}

TEST(JobsWait, AnAnswerThatIsThereInTimeIsAnsweredAtOnce) {
  TestServer server;
  const Reply waited = server.post("/fracture?sites=5", "mesh", kAsync + "Prefer: wait=60\r\n");
  ASSERT_EQ(waited.status, 200) << waited.body;
  EXPECT_EQ(waited.header("preference-applied"), "wait=60");
  const Reply same = server.post("/fracture?sites=5", "mesh");
  EXPECT_EQ(waited.body, same.body);
  EXPECT_EQ(waited.header("etag"), same.header("etag"));
  EXPECT_EQ(server.get("/jobs").json().at("jobs").size(), 0u) << "the client has all there is";
  const Reply figures =
      server.post("/fracture?sites=6", "mesh", kAsync + "Prefer: wait=60\r\nAccept: application/json\r\n");
  EXPECT_EQ(figures.header("content-type"), "application/json");
}

TEST(JobsWait, AFailureThatIsThereInTimeIsAnsweredAsItIs) {
  TestServer server;
  server.control->import = [](std::string_view) -> Expected<Mesh> {
    return fail(ErrorCode::kMalformedMesh, "broken at byte 7");
  };
  const Reply failed = server.post("/fracture", "mesh", kAsync + "Prefer: wait=60\r\n");
  EXPECT_EQ(failed.status, 422);
  EXPECT_EQ(failed.problem(), "malformed-mesh");
}

TEST(JobsWait, WhatIsNotThereInTimeIsAJob) {
  TestServer server;
  Gate gate;
  server.control->during_cut = gate.hook();
  const Reply accepted = server.post("/fracture", "mesh", kAsync + "Prefer: wait=1\r\n");
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  EXPECT_EQ(accepted.header("preference-applied"), "respond-async, wait=1");
  const std::string job = accepted.header("location");
  EXPECT_EQ(server.get(job).json().at("state"), "running");
  gate.open = true;
  wait_for_state(server, job, "done");
}

TEST(JobsWait, ALongPollEndsWithTheJobOrItsTime) {
  TestServer server;
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  wait_for_state(server, job, "running");
  const Reply early = server.get(job, "Prefer: wait=1\r\n");
  EXPECT_EQ(early.json().at("state"), "running");
  EXPECT_EQ(early.header("preference-applied"), "wait=1");
  RawClient poll(server.port());
  poll.send("GET " + job + " HTTP/1.1\r\nHost: a\r\nPrefer: wait=60\r\n\r\n");
  gate.open = true;
  const auto late = poll.receive();
  ASSERT_TRUE(late);
  EXPECT_EQ(late->json().at("state"), "done");
  EXPECT_EQ(server.get("/jobs/0123456789abcdef-0123456789abcdef", "Prefer: wait=60\r\n").status, 404);
}

TEST(JobsWait, AWaitHoldsNoThread) {
  TestServerOptions options;
  options.threads = 1;
  TestServer server(options);
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  wait_for_state(server, job, "running");
  std::vector<std::unique_ptr<RawClient>> polls;
  for (int k = 0; k < 40; ++k) {
    polls.push_back(std::make_unique<RawClient>(server.port()));
    polls.back()->send("GET " + job + " HTTP/1.1\r\nHost: a\r\nPrefer: wait=60\r\n\r\n");
  }
  EXPECT_EQ(server.get("/version").status, 200) << "the two io threads answer";
  EXPECT_EQ(server.pool.running(), 1u) << "the job alone";
  gate.open = true;
  for (const auto& poll : polls) {
    const auto reply = poll->receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->json().at("state"), "done");
  }
}

TEST(JobsWait, AServerThatStopsAnswersWhoWaits) {
  TestServer server;
  Gate gate;
  server.control->during_cut = gate.hook();
  RawClient starts(server.port()), polls(server.port());
  starts.send(
      "POST /fracture HTTP/1.1\r\nHost: a\r\nPrefer: respond-async, wait=60\r\nContent-Type: "
      "model/obj\r\nContent-Length: 4\r\n\r\nmesh");
  ASSERT_TRUE(eventually(kPatience, "the computation", [&] { return gate.arrived == 1; }));
  const std::string job = server.get("/jobs").json().at("jobs").at(0).at("links").at("self");
  const auto in_progress = [&](std::size_t requests) {
    return eventually(kPatience, "requests in progress",
                      [&] { return server.server.requests_in_progress() == requests; });
  };
  ASSERT_TRUE(in_progress(1));
  polls.send("GET " + job + " HTTP/1.1\r\nHost: a\r\nPrefer: wait=60\r\n\r\n");
  ASSERT_TRUE(in_progress(2));
  server.server.stop_accepting();
  server.server.cancel_jobs();
  for (RawClient* client : {&starts, &polls}) {
    const auto reply = client->receive();
    ASSERT_TRUE(reply);
    EXPECT_FALSE(client->timed_out());
  }
}

}  // namespace
}  // namespace fracture::test
