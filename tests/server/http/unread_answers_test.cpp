// Memory of answers that are not read yet: it is counted until the last byte is sent, and no client takes all
// of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/support/gate.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

constexpr std::size_t kMebibyte = 1u << 20, kLargeAnswer = 32 * kMebibyte;

/// A server whose answers are 16 times as large as the part that a client may hold of the memory for answers.
struct LargeAnswers : testing::Test {
  TestServerOptions options;
  std::unique_ptr<TestServer> server;
  std::unique_ptr<RawClient> deaf;  ///< does not read its answer, which is on its way

  void start() {
    options.limits.max_answers = 8 * kMebibyte;
    options.limits.max_answers_per_address = 0;  // a quarter: 2 MiB
    options.limits.write_stall = kPatience;
    options.service.result_cache_bytes = 0;
    server = std::make_unique<TestServer>(options);
    server->control->glb_padding = kLargeAnswer;
    deaf = std::make_unique<RawClient>(server->port());
    deaf->send(
        "POST /fracture?seed=1 HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\n"
        "Content-Length: 4\r\n\r\nmesh");
    require_eventually(kPatience, "the answer to be on its way",
                       [&] { return server->api.answers().used() > 0; });
  }
  Reply of_another() {
    return ask(server->port(), "POST", "/fracture?seed=2", "Content-Type: model/obj\r\n", "mesh",
               "127.0.0.2");
  }
  std::uint64_t working() { return server->dispatcher.working().used(); }
  void TearDown() override {
    if (!deaf) return;
    deaf->reset();
    EXPECT_TRUE(eventually(kPatience, "the memory to come back",
                           [&] { return server->api.answers().used() == 0 && working() == 0; }));
  }
};

TEST_F(LargeAnswers, CountAsWorkingMemoryBeyondTheirPartAndLeaveRoomForOthers) {
  start();
  EXPECT_LE(server->api.answers().used(), 2 * kMebibyte);
  EXPECT_GE(server->api.answers().used() + working(), kLargeAnswer) << "all of it is counted";
  EXPECT_EQ(of_another().status, 200);
  const Reply own = server->post("/fracture?seed=3");
  EXPECT_EQ(own.status, 429) << "the client's own answers wait until it reads";
  EXPECT_EQ(own.problem(), "over-share");
}

TEST_F(LargeAnswers, AreRefusedWhereNoWorkingMemoryIsLeft) {
  options.dispatcher.max_working_bytes = 64 * kMebibyte;  // 56 MiB of it for large reservations
  start();
  const Reply refused = of_another();  // needs 30 MiB, as the first one
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.problem(), "overloaded");
  EXPECT_NE(refused.header("retry-after"), "");
  EXPECT_EQ(server->get("/version").status, 200);
}

TEST(UnreadAnswers, AResultThatWaitsToBeCompressedIsCounted) {
  TestServerOptions options;
  options.threads = 1;
  options.limits.deadline = options.limits.realtime_deadline = kPatience;
  TestServer server(options);
  server.control->glb_padding = kMebibyte;
  const std::string location = server.post("/fracture?seed=1").header("content-location");
  ASSERT_TRUE(eventually(kPatience, "an idle server",
                         [&] { return server.pool.running() == 0 && server.api.answers().used() == 0; }));
  Gate gate;
  server.control->during_cut = gate.hook_without_polls();
  RawClient busy(server.port()), waits(server.port());
  busy.send(
      "POST /fracture?seed=2 HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n\r\nmesh");
  gate.wait_for(1);
  waits.send("GET " + location + " HTTP/1.1\r\nHost: a\r\nAccept-Encoding: gzip\r\n\r\n");
  ASSERT_TRUE(eventually(kPatience, "the compression to wait", [&] { return server.pool.queued() == 1; }));
  EXPECT_GE(server.api.answers().used(), kMebibyte);
  gate.open = true;
  const auto reply = waits.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->header("content-encoding"), "gzip");
  EXPECT_TRUE(busy.receive());
  EXPECT_TRUE(eventually(kPatience, "nothing held", [&] { return server.api.answers().used() == 0; }));
}

// The client that waits for the compression holds the result, so the compression must not wait for memory.
TEST(UnreadAnswers, AResultIsSentAsItIsIfThereIsNoMemoryToCompressIt) {
  TestServerOptions options;
  options.limits.deadline = options.limits.realtime_deadline = kPatience;
  options.dispatcher.max_working_bytes = 64 * kMebibyte;
  TestServer server(options);
  server.control->glb_padding = kMebibyte;
  const Reply made = server.post("/fracture?seed=1");
  MemoryBudget& working = server.dispatcher.working();
  ASSERT_TRUE(eventually(kPatience, "nothing in use", [&] { return working.used() == 0; }));
  MemoryBudget::Reservation large(working), small(working);  // all of it
  ASSERT_TRUE(large.grow_to(56 * kMebibyte) && small.grow_to(8 * kMebibyte));
  const Reply reply = server.get(made.header("content-location"), "Accept-Encoding: gzip\r\n");
  EXPECT_EQ(reply.status, 200);
  EXPECT_EQ(reply.header("content-encoding"), "");
  EXPECT_EQ(reply.body, made.body);
  EXPECT_EQ(server.dispatcher.figures().expired, 0u) << "it did not wait until the deadline";
}

// Reading takes 44 MiB and the answer 22 MiB, of 56 MiB.
TEST(UnreadAnswers, AResultFromTheDiskIsCountedOnceWhenItIsSent) {
  const TemporaryFolder folder;
  TestServerOptions options;
  options.service.tiers.folder = folder.path + "/cache";
  options.limits.max_answers = 8 * kMebibyte;
  options.limits.max_answers_per_address = 0;
  options.dispatcher.max_working_bytes = 64 * kMebibyte;
  const auto control = std::make_shared<FakeControl>();
  control->glb_padding = 22 * kMebibyte;
  options.control = control;
  Reply made;
  {
    TestServer server(options);
    made = server.post("/fracture?seed=1");
    ASSERT_EQ(made.status, 200) << made.body.substr(0, 300);
    server.service.tiers().flush();
  }
  TestServer server(options);
  const Reply reply = server.get(made.header("content-location"), "Accept-Encoding: gzip\r\n");
  EXPECT_EQ(reply.status, 200) << reply.body.substr(0, 300);
}

// Otherwise all results of a client would wait until its last computation is done.
TEST(UnreadAnswers, AResultIsCompressedBeforeTheNextOneIsComputed) {
  constexpr int kClients = 6;
  TestServerOptions options;
  options.threads = 1;
  options.limits.deadline = options.limits.realtime_deadline = kPatience;
  TestServer server(options);
  server.control->glb_padding = kMebibyte;
  Gate gate;
  std::atomic<std::uint64_t> most{0};
  server.control->during_cut = [&, hook = gate.hook_without_polls()](const Execution& execution) {
    most = std::max(most.load(), server.api.answers().used());
    hook(execution);
  };
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int k = 0; k < kClients; ++k) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send("POST /fracture?seed=" + std::to_string(k) +
                         " HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nAccept-Encoding: gzip\r\n"
                         "Content-Length: 4\r\n\r\nmesh");
  }
  gate.wait_for(1);
  ASSERT_TRUE(
      eventually(kPatience, "the others to wait", [&] { return server.pool.queued() == kClients - 1; }));
  gate.open = true;
  for (const auto& client : clients) {
    const auto reply = client->receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 200) << reply->body.substr(0, 300);
    EXPECT_EQ(reply->header("content-encoding"), "gzip");
  }
  EXPECT_EQ(most.load(), 0u) << "no result waited while another one was computed";
}

}  // namespace
}  // namespace fracture::test
