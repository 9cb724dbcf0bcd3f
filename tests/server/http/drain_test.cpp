// How a server stops: it reports that it is not ready, finishes the work in progress for a while, then
// cancels the rest with an answer.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/server/support/requests.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

using std::chrono::milliseconds;

TEST(Drain, NotReadyAtOnceThenBusyRequestsFinishAndIdleConnectionsClose) {
  TestServer server;
  std::atomic<bool> release{false};
  server.control->during_cut = [&](const Execution&) {
    require_eventually(kPatience, "the test to release the work", [&] { return release.load(); });
  };
  RawClient idle(server.port()), busy(server.port());
  idle.send("GET /version HTTP/1.1\r\nHost: a\r\n\r\n");
  ASSERT_TRUE(idle.receive());
  busy.send(kPostObj + "Content-Length: 4\r\n\r\nmesh");
  require_eventually(kPatience, "a cut to begin", [&] { return server.control->cuts > 0; });

  server.api.set_draining();
  const Reply ready = ask(server.server.admin_port(), "GET", "/readyz");
  EXPECT_EQ(ready.status, 503);
  EXPECT_EQ(ready.problem(), "draining");
  EXPECT_EQ(ask(server.server.admin_port(), "GET", "/livez").status, 200);
  EXPECT_EQ(server.get("/version").status, 200) << "requests are still taken during the drain delay";

  server.server.stop_accepting();
  EXPECT_EQ(idle.receive_all(), "");
  EXPECT_FALSE(idle.timed_out());
  release = true;
  const auto reply = busy.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 200);
  EXPECT_EQ(reply->header("connection"), "close");
  EXPECT_THROW(RawClient(server.port()), std::runtime_error);
}

TEST(Drain, AfterTheGraceWorkIsCancelledWithA503) {
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
  server.server.stop_accepting();
  server.server.cancel_jobs();
  const auto reply = client.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 503);
  EXPECT_EQ(reply->problem(), "cancelled");
  EXPECT_GE(std::atoi(reply->header("retry-after").c_str()), 1);
}

TEST(Drain, DestroyingABusyServerIsSafe) {
  std::vector<std::unique_ptr<RawClient>> clients;
  {
    TestServer server;
    server.control->during_cut = [](const Execution&) {
      // pause: work that takes a while and cannot be cancelled
      std::this_thread::sleep_for(milliseconds(30));
    };
    for (int i = 0; i < 20; ++i) {
      clients.push_back(std::make_unique<RawClient>(server.port()));
      clients.back()->send(
          "POST /fracture?seed=" + std::to_string(i) +
          " HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n\r\nmesh");
    }
    require_eventually(kPatience, "three cuts to begin", [&] { return server.control->cuts >= 3; });
  }
  for (const auto& client : clients) client->receive_all();
}

}  // namespace
}  // namespace fracture::test
