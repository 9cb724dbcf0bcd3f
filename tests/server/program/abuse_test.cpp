// The real program under attack while other clients work.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <thread>

#include "tests/server/support/child_process.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

Exposition metrics(ServeProcess& server) {
  return parse_exposition(ask(server.admin_port, "GET", "/metrics").body);
}

/// Returns whether the public listener soon has no connection left.
testing::AssertionResult all_closed(ServeProcess& server) {
  return eventually(kPatience, "all connections to close",
                    [&] { return metrics(server)["fracture_connections"] == 0; });
}

/// Clients that send one request after another until told to stop, each on a new connection.
class Foreground {
 public:
  Foreground(std::uint16_t port, int clients) {
    for (int c = 0; c < clients; ++c)
      threads_.emplace_back([this, port, c] {
        for (int i = 0; !stop_; ++i) {
          try {
            const Reply reply =
                ask(port, "POST", "/fracture?sites=4&seed=" + std::to_string(100'000 * c + i), kObj, kCube);
            ++(reply.status == 200 ? answered : failed);
          } catch (const std::runtime_error&) {
            ++failed;
          }
          // pause: a polite client leaves the others their turns
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
      });
  }
  ~Foreground() { join(); }
  void join() {
    stop_ = true;
    for (std::thread& thread : threads_)
      if (thread.joinable()) thread.join();
  }
  std::atomic<int> answered{0}, failed{0};

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

constexpr int kSlow = 500;

struct SlowMode {
  const char* name;
  std::vector<std::string> arguments;
};

struct SlowHttp : testing::TestWithParam<SlowMode> {};

TEST_P(SlowHttp, FiveHundredSlowClientsAreClosedAndTheOthersServed) {
  const auto program = find_program("slowhttptest");
  if (!program) GTEST_SKIP() << "slowhttptest is not installed";
  rlimit saved{};
  getrlimit(RLIMIT_NOFILE, &saved);
  if (saved.rlim_max < 2048) GTEST_SKIP() << "the limit of open files is " << saved.rlim_max;
  ServeProcess server({"--max-connections-per-address", "1000", "--header-timeout", "1", "--body-grace", "1",
                       "--write-stall", "1", "--idle", "1"});
  // A large answer for clients that read slowly.
  const Reply large = ask(server.port, "POST", "/fracture?sites=3000", kObj, kCube);
  ASSERT_EQ(large.status, 200);
  const std::string base = "http://127.0.0.1:" + std::to_string(server.port);
  std::vector<std::string> arguments = {*program, "-c", std::to_string(kSlow), "-r", "500", "-l", "6",
                                        "-v",     "1"};
  for (std::string argument : GetParam().arguments) {
    if (argument == "LARGE") argument = base + large.header("content-location");
    if (argument == "FRACTURE") argument = base + "/fracture?format=obj";
    arguments.push_back(argument);
  }
  const TemporaryFolder folder;

  Foreground foreground(server.port, 2);
  {
    ChildProcess slow(arguments, folder / "output");
    slow.wait();
  }
  foreground.join();
  EXPECT_EQ(foreground.failed, 0) << read_file(folder / "output");
  EXPECT_GE(foreground.answered, 20);
  EXPECT_TRUE(all_closed(server));
  const Exposition m = metrics(server);
  EXPECT_GE(m["fracture_connections_total"], kSlow) << read_file(folder / "output");
  const double refused = m.sum("fracture_requests_total", "status=\"408\""),
               untaken = m["fracture_answers_undelivered_total"];
  // Every slow client got a 408 or, if it did not read its answer, was cut off. slowhttptest itself gives up
  // on some clients when its time ends.
  EXPECT_GE(refused + untaken, 0.9 * kSlow) << refused << " times 408, " << untaken << " answers not taken\n"
                                            << read_file(folder / "output");
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    Modes, SlowHttp,
    testing::Values(SlowMode{"headers", {"-H", "-i", "1", "-u", "FRACTURE"}},
                    SlowMode{"body", {"-B", "-i", "1", "-s", "8192", "-u", "FRACTURE"}},
                    SlowMode{"read", {"-X", "-w", "10", "-y", "20", "-n", "2", "-z", "8", "-u", "LARGE"}}),
    [](const auto& instance) { return std::string(instance.param.name); });

// A server with few descriptors: open connections are served, and further ones wait or are refused.
TEST(FewDescriptors, OpenConnectionsAreServedAndNewOnesWhenThereIsRoom) {
  const auto prlimit = find_program("prlimit");
  if (!prlimit) GTEST_SKIP() << "prlimit (util-linux) is not installed";
  const TemporaryFolder folder;
  const std::uint16_t port = free_port(), admin_port = free_port();
  ChildProcess server(
      {*prlimit, "--nofile=256:256", FRACTURE_SERVER_PROGRAM, "serve", "--port", std::to_string(port),
       "--admin-port", std::to_string(admin_port), "--drain-delay", "0", "--max-connections", "1000",
       "--max-connections-per-address", "1000", "--allow-host", "*"},
      folder / "log");
  const auto ready = [&] {
    try {
      return ask(admin_port, "GET", "/readyz").status == 200;
    } catch (const std::runtime_error&) {
      return false;
    }
  };
  ASSERT_TRUE(eventually(kPatience, "the server to be ready", [&] { return ready() || !server.alive(); }));
  ASSERT_TRUE(server.alive()) << read_file(folder / "log");
  RawClient early(port);
  early.send("GET /version HTTP/1.1\r\nHost: a\r\n\r\n");
  ASSERT_TRUE(early.receive());
  std::vector<std::unique_ptr<RawClient>> crowd;
  for (int i = 0; i < 300; ++i) crowd.push_back(std::make_unique<RawClient>(port));
  for (int i = 0; i < 20; ++i) {
    early.send("POST /fracture?sites=4&seed=" + std::to_string(i) + " HTTP/1.1\r\nHost: a\r\n" + kObj +
               "Content-Length: " + std::to_string(kCube.size()) + "\r\n\r\n" + kCube);
    const auto reply = early.receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 200);
  }
  EXPECT_TRUE(ready()) << "the admin listener has descriptors of its own";
  crowd.clear();
  EXPECT_EQ(ask(port, "GET", "/version").status, 200);
  const Exposition m = parse_exposition(ask(admin_port, "GET", "/metrics").body);
  EXPECT_EQ(m["fracture_imports_total{outcome=\"imported\"}"], 1) << "one mesh, 20 seeds";
  EXPECT_EQ(m["process_max_fds"], 256);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << read_file(folder / "log");
}

}  // namespace
}  // namespace fracture::test
