// A bake server over HTTPS: which certificates the client accepts, and that the answers equal those over
// HTTP.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/digest/digest.hpp"
#include "server/bake/http_caller.hpp"
#include "server/bake/remote_baker.hpp"
#include "tests/client/fake_server.hpp"
#include "tests/server/support/authority.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/server/support/tls_front.hpp"

namespace fracture::bake {
namespace {

using test::Authority;
using test::TlsFront;
using testing::HasSubstr;
using Outcome = protocol::Exchange::Outcome;

struct Https : testing::Test {
  test::TemporaryFolder folder;
  void SetUp() override {
    if (!test::find_program("openssl")) GTEST_SKIP() << "there is no openssl here";
  }
  /// The limits are long because the machine may be slow. A test that expects a failure must not rely on
  /// them.
  static protocol::Exchange ask(const std::string& url, const std::string& ca_file,
                                const protocol::HttpRequest& request = {"GET", "/version"}) {
    Expected<protocol::ConnectionSettings> settings = parse_server_url(url, ca_file);
    if (!settings) throw std::runtime_error(settings.error().detail);
    settings->connect_timeout = settings->answer_timeout = std::chrono::hours(1);
    return HttpCaller(*settings).exchange(request, {});
  }
};

TEST_F(Https, OnlyACertificateOfThisNameByThisAuthorityIsBelieved) {
  const Authority ours(folder, "ours"), theirs(folder, "theirs");
  ours.sign("farm", "DNS:localhost");
  test::TestServer server;
  const TlsFront front(server.port(), ours.certificate("farm"), ours.key("farm"));
  const std::string port = ":" + std::to_string(front.port());
  const auto good = ask("https://localhost" + port, ours.certificate("ours"));
  ASSERT_EQ(good.outcome, Outcome::kAnswered) << good.detail;
  EXPECT_EQ(good.status, 200);
  EXPECT_THAT(good.body, HasSubstr("fracture-server"));

  const std::pair<std::string, std::string> wrong[] = {
      {"https://localhost" + port, theirs.certificate("theirs")},  // another authority
      {"https://localhost" + port, ""},                            // the authorities that this system trusts
      {"https://127.0.0.1" + port, ours.certificate("ours")}};     // another name
  for (const auto& [url, ca_file] : wrong) {
    const auto refused = ask(url, ca_file);
    EXPECT_EQ(refused.outcome, Outcome::kNoServer) << url << " " << ca_file;
    EXPECT_THAT(refused.detail, HasSubstr("was rejected")) << ca_file;
  }
  const auto plain = ask("https://127.0.0.1:" + std::to_string(server.port()), ours.certificate("ours"));
  EXPECT_EQ(plain.outcome, Outcome::kNoServer);
  EXPECT_THAT(plain.detail, HasSubstr("TLS"));
}

TEST_F(Https, LargeBodiesAndKeptConnectionsAreThoseOfHttp) {
  const Authority ours(folder, "ours");
  ours.sign("farm", "IP:127.0.0.1");
  test::TestServerOptions options;
  test::TestServer server(options);
  server.control->glb_padding = 3u << 20;
  const TlsFront front(server.port(), ours.certificate("farm"), ours.key("farm"));
  auto settings =
      parse_server_url("https://127.0.0.1:" + std::to_string(front.port()), ours.certificate("ours"));
  ASSERT_TRUE(settings);
  settings->connect_timeout = settings->answer_timeout = std::chrono::hours(1);
  settings->connections = 1;
  HttpCaller caller(*settings);
  for (int k = 0; k < 3; ++k) {
    const std::string mesh = std::string(1u << 20, 'm') + std::to_string(k);
    const auto answer = caller.exchange({"POST", "/fracture?format=obj&sites=3", "application/octet-stream",
                                         std::make_shared<const std::string>(mesh)},
                                        {});
    ASSERT_EQ(answer.outcome, Outcome::kAnswered) << answer.detail;
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, server.post("/fracture?format=obj&sites=3", mesh).body);
  }
}

TEST_F(Https, WhatIsWrongWithAServerIsSaidWithItsUrl) {
  const Authority ours(folder, "ours");
  ours.sign("farm", "IP:127.0.0.1");
  const test::FakeServer server(
      [](const test::FakeRequest&) { return test::FakeReply::answer(200, "<html></html>"); });
  const TlsFront front(server.port(), ours.certificate("farm"), ours.key("farm"));
  const std::string url = "https://127.0.0.1:" + std::to_string(front.port());
  auto settings = parse_server_url(url, ours.certificate("ours"));
  ASSERT_TRUE(settings);
  settings->connect_timeout = settings->answer_timeout = std::chrono::hours(1);
  const auto baker = remote_baker({*settings, {}}, {}, [](const std::string&) {});
  ASSERT_FALSE(baker);
  EXPECT_THAT(baker.error().detail, HasSubstr(url + " answers, but is not a fracture-server"));
}

TEST(HttpsUrl, NamesItsPortAndItsAuthority) {
  const auto settings = parse_server_url("https://farm");
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->port, 443);
  EXPECT_TRUE(settings->tls);
  EXPECT_FALSE(parse_server_url("http://farm")->tls);
  EXPECT_THAT(parse_server_url("http://farm", "ca.pem").error().detail, HasSubstr("--ca-file"));
  EXPECT_THAT(parse_server_url("https://farm", "/absent/ca.pem").error().detail, HasSubstr("/absent/ca.pem"));
}

}  // namespace
}  // namespace fracture::bake
