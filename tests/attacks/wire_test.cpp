// Requests whose wording is an attack, sent directly to a server, through nginx, and through the farm, which
// is HAProxy with the repository's configuration in front of three servers.
#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/docker/farm.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/gzip.hpp"
#include "tests/server/support/proxies.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// The path to the servers, and the number of requests that reached them.
class Way {
 public:
  virtual ~Way() = default;
  virtual std::uint16_t port() const = 0;
  virtual double requests() const = 0;
  /// The largest peak of resident bytes among the servers.
  virtual std::uint64_t peak() const = 0;
  virtual bool alive() = 0;
};

class OneServer final : public Way {
 public:
  explicit OneServer(bool nginx) : peak_(server_.pid()) {
    if (nginx) proxy_ = std::make_unique<Proxy>(Proxy::Kind::kNginx, server_.port);
  }
  std::uint16_t port() const override { return proxy_ ? proxy_->port : server_.port; }
  double requests() const override {
    return parse_exposition(ask(server_.admin_port, "GET", "/metrics").body)
        .sum("fracture_requests_total", "public");
  }
  std::uint64_t peak() const override { return peak_.bytes(); }
  bool alive() override { return server_.alive(); }

 private:
  ServeProcess server_;
  ResidentPeak peak_;
  std::unique_ptr<Proxy> proxy_;
};

class WholeFarm final : public Way {
 public:
  WholeFarm() {
    for (int k = 0; k < kServers; ++k) peaks_[k] = std::make_unique<ResidentPeak>(farm_.server(k).pid());
  }
  std::uint16_t port() const override { return farm_.port; }
  double requests() const override { return farm_.sum("fracture_requests_total", "public"); }
  std::uint64_t peak() const override {
    std::uint64_t most = 0;
    for (const auto& peak : peaks_) most = std::max(most, peak->bytes());
    return most;
  }
  bool alive() override {
    for (int k = 0; k < kServers; ++k)
      if (!farm_.server(k).alive()) return false;
    return true;
  }

 private:
  Farm farm_{"0"};
  std::array<std::unique_ptr<ResidentPeak>, kServers> peaks_;
};

struct Words {
  const char* name;
  const char* before;
  std::string method, target, fields, body;
  int status;
  const char* problem;
};

std::string unknown_names(std::size_t bytes) {
  std::string query = "/fracture?a";
  while (query.size() < bytes) query += "&b";
  return query;
}

std::vector<Words> all_words() {
  const std::string escaped = "a slash that routes as /";
  return {
      {"RepeatedParameters", "1.2 to 2 GB a server, replayed by HAProxy on the next one", "POST", "/fracture",
       kForm + kGzip, gzip(repeated_parameters(80'000, 250'000)), 400, "bad-parameter"},
      {"UnknownNames", "0.5 to 1.8 MB", "POST", unknown_names(4'000), kObj, kCube, 400, "unknown-parameter"},
      {"FormOfAnotherSite", "200", "POST", "/fracture", kForm + "Origin: https://evil.example\r\n",
       form_of("{}"), 403, "foreign-origin"},
      {"EscapedSlash", "routes as /", "GET", "/jobs/0123456789abcdef0123456789abcdef%2Fevents", "", "", 400,
       "malformed-request"},
      {"EscapedSlashOfAMesh", "routes as /", "POST", "/meshes/sha256:" + std::string(64, 'a') + "%2ffracture",
       kJson, "{}", 400, "malformed-request"},
  };
}

struct WireAttack : testing::TestWithParam<std::string> {
  static std::unique_ptr<Way> make(const std::string& name) {
    if (name == "Farm") return std::make_unique<WholeFarm>();
    return std::make_unique<OneServer>(name == "Nginx");
  }
};

TEST_P(WireAttack, IsRefusedOnceInFewWords) {
  constexpr std::size_t kFewWords = 12'000;
  [[maybe_unused]] constexpr std::uint64_t kMuch = 300u << 20;
  if (GetParam() == "Farm" && !Farm::missing().empty()) GTEST_SKIP() << Farm::missing();
  if (GetParam() == "Nginx" && !Proxy::installed(Proxy::Kind::kNginx))
    GTEST_SKIP() << "nginx is not installed";
  const std::unique_ptr<Way> way = make(GetParam());
  for (const Words& words : all_words()) {
    const double before = way->requests();
    Reply reply;
    try {
      reply = ask(way->port(), words.method, words.target, words.fields, words.body);
    } catch (const std::runtime_error& e) {
      ADD_FAILURE() << words.name << ": " << e.what();
    }
    EXPECT_EQ(reply.status, words.status) << words.name << ": " << reply.body.substr(0, 500);
    EXPECT_EQ(reply.problem(), words.problem) << words.name;
    EXPECT_LE(reply.body.size(), kFewWords) << words.name;
    ASSERT_TRUE(way->alive()) << words.name;
    // The server counts a request after it has sent the answer. A proxy would repeat the request before it
    // answers.
    EXPECT_TRUE(eventually(kPatience, std::string(words.name) + " to be counted",
                           [&] { return way->requests() > before; }));
    const double times = way->requests() - before;
    EXPECT_EQ(times, 1) << words.name << " reached the servers so many times";
    report(std::string(words.name) + GetParam(),
           std::to_string(words.target.size() + words.fields.size() + words.body.size()) +
               " bytes: " + std::to_string(reply.status) + " " + reply.problem() + " of " +
               std::to_string(reply.body.size()) + " bytes, " + std::to_string(static_cast<int>(times)) +
               " request at the servers, " + std::to_string(way->peak() >> 20) + " MiB",
           words.before);
  }
#ifndef FRACTURE_SANITIZED
  EXPECT_LE(way->peak(), kMuch);
#endif
  EXPECT_EQ(ask(way->port(), "POST", "/fracture?sites=4", kObj, kCube).status, 200);
}

INSTANTIATE_TEST_SUITE_P(Ways, WireAttack, testing::Values("Direct", "Nginx", "Farm"),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace fracture::test
