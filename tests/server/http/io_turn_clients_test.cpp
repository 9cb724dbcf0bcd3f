// A server's I/O thread gives turns to clients and not to connections. The tests hold the thread while
// requests arrive, and count how many of a flood's requests it handles before another client's request.
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// Receives the log lines of requests on the thread that has handled them. A line that contains `held` keeps
/// its thread until the test opens the sink.
class Lines final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit Lines(std::string held) : held_(std::move(held)) {}
  std::atomic<bool> holds{false}, open{false};

  std::vector<std::string> take() {
    const std::lock_guard lock(lines_mutex_);
    return std::exchange(lines_, {});
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string line(message.payload.data(), message.payload.size());
    {
      const std::lock_guard lock(lines_mutex_);
      lines_.push_back(line);
    }
    if (line.find(held_) == std::string::npos) return;
    holds = true;
    require_eventually(kPatience, "the test to let the I/O thread go on", [&] { return open.load(); });
  }
  void flush_() override {}

 private:
  const std::string held_;
  std::mutex lines_mutex_;
  std::vector<std::string> lines_;
};

std::string request(const std::string& path, const std::string& id = "first") {
  return "GET " + path + " HTTP/1.1\r\nHost: a\r\nX-Request-Id: " + id + "\r\n\r\n";
}

struct IoTurnClients : testing::Test {
  static constexpr std::size_t kConnections = 60;
  static constexpr int kPipelined = 20;  // of pipelined requests on each connection

  static TestServerOptions one_thread() {
    TestServerOptions options;
    options.server.io_threads = 1;
    return options;
  }
  std::shared_ptr<spdlog::logger> before = spdlog::default_logger();
  std::shared_ptr<Lines> lines = std::make_shared<Lines>("path=/patterns");
  std::unique_ptr<TestServer> server = std::make_unique<TestServer>(one_thread());
  std::vector<std::unique_ptr<RawClient>> flood;
  std::unique_ptr<RawClient> other, holder;

  void SetUp() override {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("lines", lines));
    spdlog::set_level(spdlog::level::info);
    for (std::size_t k = 0; k < kConnections; ++k) flood.push_back(connected("127.0.0.2"));
    other = connected("127.0.0.3");
    holder = connected("127.0.0.4");
    require_eventually(kPatience, "all connections to be idle",
                       [&] { return server->server.requests_in_progress() == 0; });
    lines->take();
  }
  void TearDown() override {
    lines->open = true;
    server.reset();
    spdlog::set_default_logger(before);
    spdlog::set_level(spdlog::level::off);
  }
  std::unique_ptr<RawClient> connected(const std::string& address) {
    auto client = std::make_unique<RawClient>(server->port(), address);
    client->send(request("/version"));
    EXPECT_EQ(client->receive()->status, 200);
    return client;
  }
  /// While the I/O thread is held, all requests of the flood arrive, and then the other client's request.
  void send_all() {
    holder->send(request("/patterns"));
    require_eventually(kPatience, "the I/O thread to be held", [&] { return lines->holds.load(); });
    std::string pipelined;
    for (int k = 0; k < kPipelined; ++k) pipelined += request("/version", "request-" + std::to_string(k));
    for (const auto& client : flood) client->send(pipelined);
    other->send(request("/limits"));
  }
};

/// In the order of connections, 59 or 60 requests of the flood came before.
TEST_F(IoTurnClients, ManyConnectionsThatPipelineDelayAnotherClientByAtMostFourRequests) {
  send_all();
  lines->open = true;
  EXPECT_EQ(other->receive()->status, 200);
  std::vector<std::string> handled;
  require_eventually(kPatience, "the other client's request to be logged", [&] {
    for (std::string& line : lines->take()) handled.push_back(std::move(line));
    return std::any_of(handled.begin(), handled.end(), [](const std::string& line) {
      return line.find("path=/limits") != std::string::npos;
    });
  });
  std::size_t between = 0;
  for (const std::string& line : handled) {
    if (line.find("path=/limits") != std::string::npos) break;
    between += line.find("address=127.0.0.2") != std::string::npos;
  }
  EXPECT_LE(between, 4u);
  for (const auto& client : flood)
    for (int k = 0; k < kPipelined; ++k) {
      const auto reply = client->receive();
      ASSERT_TRUE(reply) << "every request is answered";
      EXPECT_EQ(reply->status, 200);
      EXPECT_EQ(reply->header("x-request-id"), "request-" + std::to_string(k))
          << "in the order of the requests of its connection";
    }
}

TEST_F(IoTurnClients, ClientsMayLeaveAndTheServerMayEndWhileRequestsWait) {
  send_all();
  for (std::size_t k = 0; k < kConnections; k += 2) flood[k]->reset();
  lines->open = true;
  EXPECT_EQ(other->receive()->status, 200);
  for (std::size_t k = 1; k < kConnections; k += 4) flood[k]->reset();
  server.reset();
}

}  // namespace
}  // namespace fracture::test
