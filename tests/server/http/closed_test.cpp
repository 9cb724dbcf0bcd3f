// A closed connection cancels its request: what stops, which shared work goes on, and what is released
// afterwards.
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/server/http/with_tenants.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

using std::chrono::milliseconds;

const std::string kGlb = "Content-Type: model/gltf-binary\r\n", kStillReads = "Half-Close: yes\r\n";

std::string post(const std::string& target, const std::string& fields = "",
                 const std::string& body = "mesh") {
  return "POST " + target + " HTTP/1.1\r\nHost: t\r\n" + kGlb + fields +
         "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

/// A server whose computations stay at a gate, where they can be interrupted.
struct Closed : testing::Test {
  explicit Closed(TestServerOptions options = {}) : server(options) {
    server.control->during_cut = gate.hook();
  }
  ~Closed() override { gate.open = reading.open = true; }

  RawClient& connect(const std::string& bytes) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send(bytes);
    return *clients.back();
  }
  Exposition metrics() const {
    return parse_exposition(ask(server.server.admin_port(), "GET", "/metrics").body);
  }
  /// Expects that nothing is computed, queued or reserved any more. The gate is closed.
  void expect_nothing_held() {
    EXPECT_TRUE(eventually(kPatience, "everything to be given back", [&] {
      return server.pool.running() == 0 && server.pool.queued() == 0 &&
             server.dispatcher.figures().flights == 0 && server.dispatcher.working().used() == 0;
    }));
  }
  void wait_until_done(const std::string& job) {
    EXPECT_TRUE(eventually(kPatience, job + " to be done",
                           [&] { return server.get(job).json().value("state", "") == "done"; }));
  }
  void wait_for_connections(std::size_t count) {
    require_eventually(kPatience, "connections to close",
                       [&] { return server.server.connections() == count; });
  }

  Gate gate, reading;  // reading: for tests that hold the mesh reader
  TestServer server;
  std::vector<std::unique_ptr<RawClient>> clients;
};

TEST_F(Closed, AnOrderlyCloseStopsTheComputation) {
  RawClient& client = connect(post("/fracture"));
  gate.wait_for(1);
  client.half_close();
  const auto reply = client.receive();
  ASSERT_TRUE(reply) << "a client that half-closes by mistake is told what to do";
  EXPECT_EQ(reply->status, 499);
  EXPECT_EQ(reply->problem(), "client-closed-request");
  EXPECT_NE(reply->body.find("Half-Close: yes"), std::string::npos) << reply->body;
  EXPECT_EQ(reply->header("connection"), "close");
  expect_nothing_held();
  wait_for_connections(0);
  EXPECT_EQ(server.control->cancelled, 1);
  const Exposition after = metrics();
  EXPECT_EQ(after["fracture_work_abandoned_total"], 1);
  EXPECT_EQ(after.sum("fracture_requests_total", "status=\"499\""), 1);
  EXPECT_EQ(after["fracture_results_computed_total"], 0);
}

TEST_F(Closed, ACloseOfBothSidesStopsTheComputationToo) {
  connect(post("/fracture"));
  gate.wait_for(1);
  clients.clear();
  expect_nothing_held();
  wait_for_connections(0);
  EXPECT_EQ(server.control->cancelled, 1);
}

TEST_F(Closed, TheComputationStopsSoonAfterTheClose) {
  const auto done = std::make_shared<std::atomic<int>>(0);
  server.control->during_cut = [done](const Execution& execution) {
    for (int k = 0; k < 60'000; ++k) {
      std::this_thread::sleep_for(milliseconds(1));  // pause: work that takes a minute
      ++*done;
      execution.poll();
    }
  };
  RawClient& client = connect(post("/fracture"));
  require_eventually(kPatience, "the work to begin", [&] { return *done > 0; });
  client.half_close();
  const int before = *done;
  EXPECT_EQ(client.receive()->status, 499);
  expect_nothing_held();
  EXPECT_EQ(server.control->cancelled, 1);
  EXPECT_LT(*done - before, 500) << "polls between the close and the end of the computation";
}

TEST_F(Closed, AClientThatSaysThatItStillReadsGetsItsAnswer) {
  server.control->during_cut = [](const Execution& execution) {
    for (int i = 0; i < 100; ++i) {
      std::this_thread::sleep_for(milliseconds(1));  // pause: work that takes a tenth of a second
      execution.poll();
    }
  };
  for (const char* fields : {"Half-Close: yes\r\n", "half-close:  YES \r\n"}) {
    RawClient& client = connect(post("/fracture?seed=" + std::to_string(clients.size()), fields));
    client.half_close();
    const auto reply = client.receive();
    ASSERT_TRUE(reply) << fields;
    EXPECT_EQ(reply->status, 200) << fields;
  }
  RawClient& old =
      connect("POST /fracture?seed=7 HTTP/1.0\r\n" + kGlb + kStillReads + "Content-Length: 4\r\n\r\nmesh");
  old.half_close();
  EXPECT_EQ(old.receive()->status, 200);
  EXPECT_EQ(server.control->cancelled, 0);
}

TEST_F(Closed, AResetTakesTheRequestOfSuchAClientBack) {
  RawClient& client = connect(post("/fracture", kStillReads));
  client.half_close();
  gate.wait_for(1);
  client.reset();
  expect_nothing_held();
  EXPECT_EQ(server.control->cancelled, 1);
}

TEST_F(Closed, AnotherValueOfTheHeaderIsRefused) {
  for (const char* value : {"no", "yes, yes", "1", "?1"})
    EXPECT_EQ(server.post("/fracture", "mesh", kGlb + "Half-Close: " + value + "\r\n").problem(),
              "malformed-request")
        << value;
}

TEST_F(Closed, AClientOfHttp10ThatHalfClosesWithoutTheHeaderIsToldOfIt) {
  RawClient& client = connect("POST /fracture HTTP/1.0\r\n" + kGlb + "Content-Length: 4\r\n\r\nmesh");
  client.half_close();
  const auto reply = client.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->problem(), "client-closed-request");
  expect_nothing_held();
}

TEST_F(Closed, WhatIsThereAtOnceIsAnsweredAllTheSame) {
  RawClient& client = connect("GET /version HTTP/1.0\r\n\r\n");
  client.half_close();
  EXPECT_EQ(client.receive()->status, 200);
}

TEST_F(Closed, OthersWhoWaitForTheSameGetIt) {
  RawClient& leader = connect(post("/fracture"));
  gate.wait_for(1);
  RawClient& other = connect(post("/fracture"));
  require_eventually(kPatience, "the second to join",
                     [&] { return server.dispatcher.figures().collapsed == 1; });
  leader.half_close();
  EXPECT_EQ(leader.receive()->status, 499);
  gate.open = true;
  EXPECT_EQ(other.receive()->status, 200);
  EXPECT_EQ(server.control->cancelled, 0);
  EXPECT_EQ(server.control->cuts, 1);
}

TEST_F(Closed, WhileItIsQueued) {
  for (int seed = 1; seed <= 2; ++seed) {
    connect(post("/fracture?seed=" + std::to_string(seed)));
    gate.wait_for(seed);  // At the end, as many run as there are threads.
  }
  const std::uint64_t before = server.dispatcher.working().used();
  RawClient& queued = connect(post("/fracture?seed=3"));
  require_eventually(kPatience, "the third to be queued", [&] { return server.pool.queued() == 1; });
  EXPECT_EQ(server.dispatcher.working().used(), before) << "queued work holds no memory";
  queued.half_close();
  EXPECT_EQ(queued.receive()->status, 499);
  EXPECT_TRUE(eventually(kPatience, "what it held to be free", [&] {
    return server.pool.queued() == 0 && server.dispatcher.figures().flights == 2 &&
           server.dispatcher.working().used() == before;
  }));
  gate.open = true;
  for (int k = 0; k < 2; ++k) EXPECT_EQ(clients[k]->receive()->status, 200);
  EXPECT_EQ(server.control->cuts, 2) << "what was queued never began";
}

TEST_F(Closed, WhileItsMeshIsRead) {
  server.control->during_import = reading.hook();
  RawClient& client = connect(post("/fracture"));
  reading.wait_for(1);
  client.half_close();
  EXPECT_EQ(client.receive()->status, 499);
  expect_nothing_held();
  EXPECT_EQ(server.control->prepares, 0);
}

TEST_F(Closed, WhileItsBodyWaitsForAThread) {
  for (int seed = 1; seed <= 2; ++seed) connect(post("/fracture?seed=" + std::to_string(seed)));
  gate.wait_for(2);
  RawClient& large = connect(post("/fracture?seed=3", "", std::string(1 << 20, 'm')));
  require_eventually(kPatience, "the body to be queued", [&] { return server.pool.queued() == 1; });
  large.half_close();
  EXPECT_EQ(large.receive()->status, 499);
  EXPECT_EQ(server.pool.queued(), 0u);
  EXPECT_TRUE(eventually(kPatience, "the memory of the body",
                         [&] { return server.api.bodies().whole().used() == 0; }));
}

TEST_F(Closed, TheEndIsSeenBehindPipelinedRequests) {
  RawClient& client =
      connect(post("/fracture") + "GET /version HTTP/1.1\r\nHost: t\r\n\r\n" + post("/fracture?seed=2"));
  gate.wait_for(1);
  client.half_close();
  const auto reply = client.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 499);
  EXPECT_EQ(client.receive_all(), "") << "what was sent behind it is taken back, too";
  expect_nothing_held();
  EXPECT_EQ(server.control->cuts, 1);
}

TEST_F(Closed, PipelinedRequestsAreKeptAndAnsweredInTheirOrder) {
  constexpr int kMore = 300;
  RawClient& client = connect(post("/fracture"));
  gate.wait_for(1);
  std::string more;
  for (int k = 0; k < kMore; ++k)
    more += "GET /version HTTP/1.1\r\nHost: t\r\nX-Request-Id: " + std::to_string(k) +
            "\r\nX: " + std::string(400, 'x') + "\r\n\r\n";
  ASSERT_GT(more.size(), 2 * http::kReadBuffer) << "more than is read ahead";
  std::thread sender([&] { client.send(more); });
  // Bytes that do not fit into the read buffer must not wake the server again and again.
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  std::this_thread::sleep_for(milliseconds(1000));  // pause: a second that should use no processor time
  getrusage(RUSAGE_SELF, &after);
  const auto seconds = [](const rusage& used) {
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
  };
  EXPECT_LT(seconds(after) - seconds(before), 0.5) << "CPU seconds used in one second of waiting";
  gate.open = true;
  EXPECT_EQ(client.receive()->status, 200);
  for (int k = 0; k < kMore; ++k) {
    const auto reply = client.receive();
    if (!reply) {
      ADD_FAILURE() << "no answer " << k;
      break;
    }
    EXPECT_EQ(reply->header("x-request-id"), std::to_string(k));
  }
  sender.join();
}

TEST_F(Closed, AResetIsSeenBehindMoreThanIsReadAhead) {
  RawClient& client = connect(post("/fracture"));
  gate.wait_for(1);
  client.send(std::string(2 * http::kReadBuffer, 'x'));
  client.reset();
  expect_nothing_held();
  EXPECT_EQ(server.control->cancelled, 1);
}

TEST_F(Closed, ACloseAfterAnAnswerOnTheSameConnection) {
  gate.open = true;
  RawClient& client = connect(post("/fracture?seed=1"));
  EXPECT_EQ(client.receive()->status, 200);
  gate.open = false;
  client.send(post("/fracture?seed=2"));
  gate.wait_for(2);
  client.half_close();
  EXPECT_EQ(client.receive()->status, 499);
  expect_nothing_held();
}

struct ClosedByName : Closed {
  ClosedByName() : Closed(with_tenants({tenant("small", {"read", "fracture"}, {{"computations", 1}})})) {}
};

// The name may have one computation at a time.
TEST_F(ClosedByName, TheShareOfANameIsFreeAgain) {
  const std::string fields = by("small");
  RawClient& client = connect(post("/fracture?seed=1", fields));
  gate.wait_for(1);
  const Reply refused = server.post("/fracture?seed=2", "mesh", kGlb + fields);
  EXPECT_EQ(refused.problem(), "over-share");
  client.half_close();
  EXPECT_EQ(client.receive()->status, 499);
  gate.open = true;
  EXPECT_EQ(server.post("/fracture?seed=2", "mesh", kGlb + fields).status, 200);
}

TEST_F(Closed, AJobGoesOn) {
  RawClient& client = connect(post("/fracture", kRespondAsync));
  const auto accepted = client.receive();
  ASSERT_TRUE(accepted);
  EXPECT_EQ(accepted->status, 202);
  clients.clear();
  wait_for_connections(0);
  gate.wait_for(1);
  gate.open = true;
  wait_until_done(accepted->header("location"));
}

TEST_F(Closed, AJobIsMadeThoughItsClientLeavesBeforeItIsAccepted) {
  server.control->during_cut = gate.hook_without_polls();
  for (int seed = 1; seed <= 2; ++seed) connect(post("/fracture?seed=" + std::to_string(seed)));
  gate.wait_for(2);
  RawClient& large = connect(post("/fracture?seed=3", kRespondAsync, std::string(1 << 20, 'm')));
  require_eventually(kPatience, "the body to be queued", [&] { return server.pool.queued() == 1; });
  large.half_close();
  gate.open = true;
  EXPECT_EQ(large.receive()->status, 202);
  EXPECT_TRUE(eventually(kPatience, "the job to be done",
                         [&] { return server.get("/jobs?state=done").json().at("jobs").size() == 1; }));
}

TEST_F(Closed, TheWaitForAJobEndsAndTheJobGoesOn) {
  RawClient& client = connect(post("/fracture", "Prefer: respond-async, wait=60\r\n"));
  gate.wait_for(1);
  const std::string job = "/jobs/" + server.get("/jobs").json().at("jobs").at(0).at("id").get<std::string>();
  RawClient& poll = connect("GET " + job + " HTTP/1.1\r\nHost: t\r\nPrefer: wait=60\r\n\r\n");
  client.half_close();
  const auto accepted = client.receive();
  ASSERT_TRUE(accepted);
  EXPECT_EQ(accepted->status, 202);
  EXPECT_EQ("/jobs/" + accepted->json().at("id").get<std::string>(), job);
  poll.half_close();
  EXPECT_EQ(poll.receive()->status, 499);
  wait_for_connections(0);
  EXPECT_EQ(server.control->cancelled, 0);
  gate.open = true;
  wait_until_done(job);
}

// A client that closes only its own side would get keep-alives for as long as the job runs.
TEST_F(Closed, AStreamOfEventsEnds) {
  const std::string job = server.post("/fracture", "mesh", kGlb + kRespondAsync).header("location");
  gate.wait_for(1);
  RawClient& events = connect("GET " + job + "/events HTTP/1.1\r\nHost: t\r\n\r\n");
  ASSERT_TRUE(events.receive_until("event: progress"));
  events.half_close();
  wait_for_connections(0);
  EXPECT_EQ(server.get(job).json().at("state"), "running");
  EXPECT_EQ(server.control->cancelled, 0);
}

TEST_F(Closed, AMeshIsStoredThoughItsClientLeaves) {
  server.control->during_import = reading.hook();
  RawClient& client =
      connect("POST /meshes HTTP/1.1\r\nHost: t\r\n" + kGlb + "Content-Length: 4\r\n\r\nmesh");
  reading.wait_for(1);
  client.half_close();
  EXPECT_EQ(server.get("/version").status, 200) << "what came first was looked at first, or will be";
  reading.open = true;
  const auto reply = client.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 201);
  EXPECT_EQ(server.get(reply->header("location")).status, 200);
}

TEST_F(Closed, WhatGoesOnAloneIsCancelledWhenTheServerStops) {
  server.control->during_import = reading.hook();
  RawClient& client =
      connect("POST /meshes HTTP/1.1\r\nHost: t\r\n" + kGlb + "Content-Length: 4\r\n\r\nmesh");
  reading.wait_for(1);
  client.half_close();
  server.server.stop_accepting();
  server.server.cancel_jobs();
  EXPECT_EQ(client.receive()->problem(), "cancelled");
  expect_nothing_held();
}

}  // namespace
}  // namespace fracture::test
