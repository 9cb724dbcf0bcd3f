// The same attacks with a proxy in front of the server, and a rolling restart behind a proxy.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "tests/server/http/hostile_corpus.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/proxies.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

struct BehindProxy : testing::TestWithParam<Proxy::Kind> {
  void SetUp() override {
    if (!Proxy::installed(GetParam())) GTEST_SKIP() << Proxy::name(GetParam()) << " is not installed";
  }
};

// If the proxy and the server disagree about where a request ends, the server sees a request that the proxy
// never sent.
TEST_P(BehindProxy, EveryHopCountsTheSameRequests) {
  TestServer server;
  Proxy proxy(GetParam(), server.port());
  const auto served = [&server] {
    return static_cast<int>(parse_exposition(ask(server.server.admin_port(), "GET", "/metrics").body)
                                .sum("fracture_requests_total", "public"));
  };
  int answers = 0, passed = 0, refused = 0;
  Proxy::Counts before = proxy.counts();  // from the probe that waited for the proxy
  const int seen_before = before.seen;
  for (const HostileRequest& request : hostile_corpus()) {
    std::string all;
    {  // Close before comparing the counts: nginx logs a request when its connection is done.
      RawClient client(proxy.port);
      client.send(request.bytes + kSmuggled);
      all = client.receive_all();
      EXPECT_FALSE(client.timed_out()) << request.name;
    }
    const int got = static_cast<int>(count_answers(all)), marked = static_cast<int>(count(all, "smuggled"));
    answers += got;
    (marked > 0 ? passed : refused) += 1;
    EXPECT_LE(got, 2) << request.name;

    // Logs and counters are written after the answers.
    Proxy::Counts now = proxy.counts();
    EXPECT_TRUE(eventually(kPatience, "the counts of " + request.name, [&] {
      now = proxy.counts();
      return now.seen - before.seen >= std::max(got, 1) && now.sent_on == served();
    }));
    ASSERT_EQ(now.sent_on, served()) << request.name
                                     << ": the hops disagree about how many requests there were\n"
                                     << all.substr(0, 1000) << "\n"
                                     << proxy.log();
    EXPECT_GE(now.seen - before.seen, got) << request.name << ": more answers than requests";
    before = now;
  }
  EXPECT_GT(passed, 0) << "the controls";
  EXPECT_GT(refused, 100);
  EXPECT_GE(proxy.counts().seen - seen_before, answers);
  EXPECT_EQ(ask(proxy.port, "GET", "/version").status, 200) << "the same processes answer";
  EXPECT_TRUE(proxy.alive());
  std::printf("%s: %d answers, %d requests sent on, %d served\n", Proxy::name(GetParam()), answers,
              proxy.counts().sent_on, served());
}

INSTANTIATE_TEST_SUITE_P(Proxies, BehindProxy, testing::Values(Proxy::Kind::kHaproxy, Proxy::Kind::kNginx),
                         [](const auto& instance) { return std::string(Proxy::name(instance.param)); });

// Two servers behind HAProxy, which asks /readyz. One of them is told to stop while clients send requests
// without a pause. The drain delay is ten times the time that the proxy needs to notice.
TEST(RollingRestart, SigtermUnderLoadBehindHaproxyFailsNoRequest) {
  if (!Proxy::installed(Proxy::Kind::kHaproxy)) GTEST_SKIP() << "haproxy is not installed";
  ServeProcess first({"--drain-delay", "3"}), second({"--drain-delay", "3"});
  Proxy proxy(Proxy::Kind::kHaproxy, {{first.port, first.admin_port}, {second.port, second.admin_port}});
  std::atomic<int> answered{0}, failed{0};
  std::atomic<bool> stop{false};
  std::vector<std::thread> clients;
  for (int c = 0; c < 4; ++c)
    clients.emplace_back([&, c] {
      for (int i = 0; !stop; ++i) {
        try {
          const Reply reply =
              ask(proxy.port, "POST", "/fracture?sites=8&seed=" + std::to_string(1000 * c + i),
                  "Content-Type: model/obj\r\n", kCube);
          ++(reply.status == 200 ? answered : failed);
        } catch (const std::runtime_error&) {
          ++failed;
        }
      }
    });
  const auto answers = [&](int more) {
    const int end = answered + more;
    require_eventually(kPatience, "answers", [&] { return answered >= end || failed > 0; });
  };
  answers(50);
  first.signal(SIGTERM);
  EXPECT_EQ(first.wait(), 0);
  answers(50);
  stop = true;
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(failed, 0);
  EXPECT_GE(answered, 100);
  second.signal(SIGTERM);
  EXPECT_EQ(second.wait(), 0);
}

}  // namespace
}  // namespace fracture::test
