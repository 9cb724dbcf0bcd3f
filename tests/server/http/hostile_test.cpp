// The HTTP adapter under attack by rude, slow or confused clients. In every case there is exactly one answer
// or a closed connection, no second request is read out of the body of the first one, and the same process
// answers the next request.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <thread>
#include <vector>

#include "common/base/random.hpp"
#include "tests/server/http/hostile_corpus.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/peak_memory.hpp"

namespace fracture::test {
namespace {

using std::chrono::milliseconds;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

#define EXPECT_ALIVE(server) EXPECT_EQ((server).get("/version").status, 200)

// Trap 1: Beast throws std::length_error out of run() on a long trailer field if its buffer is unbounded.
TEST(Hostile, AGiantTrailerFieldIsAnsweredAndTheProcessLives) {
  TestServer server;
  RawClient client(server.port());
  client.send(kPostObj + "Transfer-Encoding: chunked\r\n\r\n4\r\nmesh\r\n0\r\nX: ");
  client.send(std::string(300'000, 'x'));
  const auto reply = client.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 431);
  EXPECT_ALIVE(server);
}

TEST(Hostile, AnEndlessChunkExtensionIsCutOffWithoutGrowingMemory) {
  TestServer server;
  const PeakMemory peak;
  RawClient client(server.port());
  client.send(kPostObj + "Transfer-Encoding: chunked\r\n\r\n4;x=");
  const std::string block(1 << 20, 'x');
  for (int i = 0; i < 64 && client.send(block); ++i) {
  }
  const auto reply = client.receive();
  if (reply) {
    EXPECT_EQ(reply->status, 431);
  }
  EXPECT_TRUE(peak.grew_by_less_than(32 << 20));
  EXPECT_ALIVE(server);
}

TEST(Hostile, ManyChunksWithLongExtensionsAreBoundedInTotal) {
  TestServerOptions options;
  options.limits.max_body = 1 << 16;
  TestServer server(options);
  RawClient client(server.port());
  client.send(kPostObj + "Transfer-Encoding: chunked\r\n\r\n");
  const std::string chunk = "1;" + std::string(30'000, 'x') + "\r\nm\r\n";
  for (int i = 0; i < 1000 && client.send(chunk); ++i) {
  }
  const auto reply = client.receive();
  if (reply) {
    EXPECT_EQ(reply->status, 431);
  }
  EXPECT_EQ(server.control->imports, 0);
  EXPECT_ALIVE(server);
}

// Trap 2: bytes that follow an ambiguous request on the connection must never be taken for a request.
TEST(Hostile, TheCorpusIsAnsweredOnceAndNothingIsSmuggled) {
  TestServer server;
  double expected = 0;
  for (const HostileRequest& request : hostile_corpus()) {
    RawClient client(server.port());
    client.send(request.bytes + kSmuggled);
    const std::string all = client.receive_all();
    const std::size_t answers = request.valid ? 2 : 1;
    expected += static_cast<double>(answers);
    EXPECT_FALSE(client.timed_out()) << request.name;
    EXPECT_EQ(count_answers(all), answers) << request.name << "\n---\n" << all.substr(0, 2000);
    EXPECT_EQ(all.substr(0, 12), "HTTP/1.1 " + std::to_string(request.status)) << request.name;
    EXPECT_EQ(count(all, "X-Request-Id: smuggled"), answers - 1) << request.name;
  }
  const Exposition metrics = parse_exposition(ask(server.server.admin_port(), "GET", "/metrics").body);
  EXPECT_EQ(metrics.sum("fracture_requests_total", "public"), expected);
  EXPECT_ALIVE(server);
}

// Trap 3: an expectation is answered before the body is sent, with 100 or with the refusal.
TEST(Hostile, ExpectationsAreAnsweredBeforeTheBody) {
  TestServer server;
  const std::string expect = "Expect: 100-continue\r\n";
  {
    RawClient client(server.port());
    client.send(kPostObj + expect + "Content-Length: 4\r\n\r\n");
    const auto interim = client.receive();
    ASSERT_TRUE(interim);
    EXPECT_EQ(interim->status, 100);
    client.send("mesh");
    EXPECT_EQ(client.receive()->status, 200);
  }
  const std::vector<std::pair<std::string, int>> refused = {
      {kPostObj + expect + "Content-Length: 99999999\r\n\r\n", 413},
      {"POST /fracture?sites=0 HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n" +
           expect + "\r\n",
       400},
      {"POST /nothing HTTP/1.1\r\nHost: a\r\nContent-Length: 4\r\n" + expect + "\r\n", 404},
      {kPostObj + "Expect: a-miracle\r\nContent-Length: 4\r\n\r\n", 417},
  };
  for (const auto& [request, status] : refused) {
    RawClient client(server.port());
    client.send(request);
    const auto reply = client.receive();
    ASSERT_TRUE(reply) << request;
    EXPECT_EQ(reply->status, status) << request;
    EXPECT_EQ(reply->header("connection"), "close");
  }
}

TEST(Hostile, ABodyOverTheLimitIsAnsweredWhileTheClientStillSends) {
  TestServer server;
  for (const bool chunked : {false, true}) {
    RawClient client(server.port());
    const std::string block(1 << 20, 'x');
    client.send(kPostObj +
                (chunked ? "Transfer-Encoding: chunked\r\n\r\n" : "Content-Length: 33554432\r\n\r\n"));
    // The client reads the answer only after it has sent everything. A server that closed at once would reset
    // the connection, and on many systems a reset discards the answer.
    for (int i = 0; i < 32; ++i)
      ASSERT_TRUE(client.send(chunked ? "100000\r\n" + block + "\r\n" : block)) << i;
    const auto reply = client.receive();
    ASSERT_TRUE(reply) << "chunked: " << chunked;
    EXPECT_EQ(reply->problem(), "body-too-large") << "chunked: " << chunked;
    EXPECT_NE(reply->body.find("(--max-body)"), std::string::npos) << reply->body;
  }
  EXPECT_EQ(server.control->imports, 0);
}

TEST(Hostile, ABodyOfExactlyTheLimitPasses) {
  TestServerOptions options;
  options.limits.max_body = 1000;
  TestServer server(options);
  EXPECT_EQ(server.post("/fracture", std::string(1000, 'x')).status, 200);
  EXPECT_EQ(server.post("/fracture", std::string(1001, 'x')).status, 413);
}

TEST(Hostile, SlowHeadersAndBodiesAre408AndIdleConnectionsJustClose) {
  TestServerOptions options;
  options.limits.header_timeout = options.limits.body_grace = options.limits.idle = milliseconds(200);
  TestServer server(options);
  {
    RawClient client(server.port());
    client.send("GET / HT");
    const auto reply = client.receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 408);
  }
  {
    RawClient client(server.port());  // A byte now and then does not extend the time.
    client.send("GET / HTTP/1.1\r\nX: ");
    std::thread drip([&] {
      // pause: a client that sends a byte now and then
      for (int i = 0; i < 100 && client.send("x"); ++i) {
        std::this_thread::sleep_for(milliseconds(50));  // pause: see above
      }
    });
    const auto reply = client.receive();
    EXPECT_TRUE(reply && reply->status == 408);
    client.half_close();
    drip.join();
  }
  {
    RawClient client(server.port());
    client.send(kPostObj + "Content-Length: 100\r\n\r\nabc");
    const auto reply = client.receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->problem(), "request-timeout");
  }
  {
    RawClient client(server.port());
    EXPECT_EQ(client.receive_all(), "");
    EXPECT_FALSE(client.timed_out());
  }
}

TEST(Hostile, AClientThatNeverReadsIsDroppedWhenItsWindowIsFull) {
  TestServerOptions options;
  options.limits.write_stall = milliseconds(200);
  TestServer server(options);
  server.control->glb_padding = 64u << 20;
  RawClient client(server.port());
  client.send(kPostObj + "Content-Length: 4\r\n\r\nmesh");
  require_eventually(kPatience, "a cut to begin", [&] { return server.control->cuts > 0; });
  EXPECT_TRUE(
      eventually(kPatience, "the end of the connection", [&] { return server.server.connections() == 0; }));
}

TEST(Hostile, AHalfCloseInsideTheBodyIsAnswered) {
  TestServer server;
  RawClient client(server.port());
  client.send(kPostObj + "Content-Length: 100\r\n\r\nabc");
  client.half_close();
  const auto reply = client.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 400);
}

TEST(Hostile, AResetCancelsTheWork) {
  TestServer server;
  server.control->during_cut = [](const Execution& execution) {
    require_eventually(kPatience, "the cancellation", [&] {
      execution.poll();
      return false;
    });
  };
  RawClient client(server.port());
  client.send(kPostObj + "Content-Length: 4\r\n\r\nmesh");
  require_eventually(kPatience, "a cut to begin", [&] { return server.control->cuts > 0; });
  client.reset();
  server.pool.wait_idle();
  EXPECT_EQ(server.control->cancelled, 1);
  server.control->during_cut = nullptr;
  EXPECT_ALIVE(server);
}

TEST(Hostile, AHundredResetsAfterTheUploadLeaveNoWorkBehind) {
  constexpr int kClients = 100;
  TestServerOptions options;
  options.max_queue = 2 * kClients;
  TestServer server(options);
  server.control->during_cut = [](const Execution& execution) {
    require_eventually(kPatience, "the cancellation", [&] {
      execution.poll();
      return false;
    });
  };
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send("POST /fracture?seed=" + std::to_string(i) +
                         " HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n\r\nmesh");
  }
  const auto metrics = [&server] {
    return parse_exposition(ask(server.server.admin_port(), "GET", "/metrics").body);
  };
  require_eventually(kPatience, "all computations to begin",
                     [&] { return metrics()["fracture_flights"] >= kClients; });
  for (const auto& client : clients) client->reset();
  require_eventually(kPatience, "all resets to be seen",
                     [&] { return metrics()["fracture_work_abandoned_total"] >= kClients; });
  server.dispatcher.wait_idle();  // Without the cancellation this would take forever.
  const Exposition after = metrics();
  EXPECT_EQ(after["fracture_work_abandoned_total"], kClients);
  EXPECT_EQ(after["fracture_results_computed_total"], 0);
  EXPECT_EQ(server.control->cancelled, server.control->cuts) << "what had begun was stopped";
  EXPECT_EQ(after["fracture_flights"], 0);
  server.control->during_cut = nullptr;
  EXPECT_ALIVE(server);
}

// Trap 4: at the limit of open files, an accept loop without a pause uses a whole processor.
TEST(Hostile, AtTheLimitOfOpenFilesTheServerNeitherSpinsNorDies) {
#ifdef FRACTURE_SANITIZED
  GTEST_SKIP()
      << "UBSan probes memory through a pipe of its own, and takes the lack of descriptors for a bad pointer";
#endif
  TestServer server;
  EXPECT_ALIVE(server);
  rlimit saved{};
  getrlimit(RLIMIT_NOFILE, &saved);
  std::vector<std::unique_ptr<RawClient>> clients;
  rlimit low = saved;
  low.rlim_cur = 96;
  setrlimit(RLIMIT_NOFILE, &low);
  try {  // Both ends of a connection are descriptors of this process.
    for (int i = 0; i < 200; ++i) clients.push_back(std::make_unique<RawClient>(server.port()));
  } catch (const std::runtime_error&) {
  }
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  std::this_thread::sleep_for(milliseconds(1000));  // pause: a second that should use no processor time
  getrusage(RUSAGE_SELF, &after);
  const double cpu = static_cast<double>(after.ru_utime.tv_sec - before.ru_utime.tv_sec +
                                         after.ru_stime.tv_sec - before.ru_stime.tv_sec) +
                     1e-6 * static_cast<double>(after.ru_utime.tv_usec - before.ru_utime.tv_usec +
                                                after.ru_stime.tv_usec - before.ru_stime.tv_usec);
  EXPECT_LT(cpu, 0.5) << "CPU seconds used in one second of being full";
  clients.clear();
  setrlimit(RLIMIT_NOFILE, &saved);
  EXPECT_ALIVE(server);
}

TEST(Hostile, BrokenAndRandomBytesAreAnsweredOrClosed) {
  TestServer server;
  Random random(20260101);
  const std::string seed_text = kPostObj + "Transfer-Encoding: chunked\r\n\r\n4\r\nmesh\r\n0\r\n\r\n";
  for (int i = 0; i < 300; ++i) {
    std::string bytes = seed_text;
    const int edits = 1 + static_cast<int>(random.below(4));
    for (int e = 0; e < edits; ++e) bytes[random.below(bytes.size())] = static_cast<char>(random.below(256));
    RawClient client(server.port());
    client.send(bytes);
    client.half_close();
    client.receive_all();
    EXPECT_FALSE(client.timed_out()) << "mutation " << i;
  }
  EXPECT_ALIVE(server);
}

}  // namespace
}  // namespace fracture::test
