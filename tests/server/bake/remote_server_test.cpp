// The errors of a bake, before its first job, about a server that it cannot use.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "common/pipeline/algorithm_version.hpp"
#include "server/bake/failure.hpp"
#include "tests/server/bake/remote_bakers.hpp"
#include "tests/server/support/bake_farm.hpp"

namespace fracture::bake {
namespace {

using nlohmann::json;
using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;
using testing::HasSubstr;

TEST(RemoteBaker, SaysWhatIsWrongWithTheServerBeforeTheFirstJob) {
  const auto words = [](const FakeReply& reply, const std::string& token = "") {
    const FakeServer server([&](const FakeRequest&) { return reply; });
    const auto baker = baker_at(server.port(), short_pauses(), token);
    if (!token.empty()) {
      EXPECT_THAT(server.requests()[0].head, HasSubstr("Authorization: Bearer " + token + "\r\n"));
    }
    return baker ? "" : to_line(baker.error());
  };
  EXPECT_THAT(words(FakeReply::answer(200, "<html></html>")), HasSubstr("is not a fracture-server"));
  EXPECT_THAT(words(FakeReply::answer(404, "")), HasSubstr("status 404"));
  const json other{{"name", "fracture-server"}, {"algorithm", kAlgorithmVersion + 1}};
  EXPECT_THAT(words(FakeReply::answer(200, other.dump())),
              HasSubstr("has algorithm version " + std::to_string(kAlgorithmVersion + 1)));
  EXPECT_THAT(words(problem(401, "unauthorized"), "wrong"), HasSubstr("FRACTURE_TOKEN"));

  Patience none = short_pauses();
  none.total = std::chrono::milliseconds(0);
  const test::DeafPort deaf;
  const auto absent = baker_at(deaf.port, none);
  ASSERT_FALSE(absent);
  EXPECT_EQ(outcome_of(absent.error().code), Outcome::kUnavailable);
  EXPECT_THAT(to_line(absent.error()),
              HasSubstr("127.0.0.1:" + std::to_string(deaf.port) + " does not answer"));
}

TEST(RemoteBaker, SaysAnIpv6AddressInBrackets) {
  const FakeServer server([&](const FakeRequest&) { return problem(401, "unauthorized"); });
  protocol::ConnectionSettings settings;
  settings.host = "::ffff:127.0.0.1";
  settings.port = server.port();
  settings.connect_timeout = settings.answer_timeout = std::chrono::hours(1);
  Patience none = short_pauses();
  none.total = std::chrono::milliseconds(0);
  const auto refused = remote_baker({settings, none}, {}, [](const std::string&) {});
  ASSERT_FALSE(refused);
  const std::string said = to_line(refused.error()),
                    authority = "[::ffff:127.0.0.1]:" + std::to_string(server.port());
  if (said.find("not supported") != std::string::npos) GTEST_SKIP() << "there is no IPv6 here: " << said;
  EXPECT_THAT(said, testing::StartsWith(authority + " refuses the token"));
  EXPECT_THAT(server.requests()[0].head, HasSubstr("Host: " + authority + "\r\n"));
}

}  // namespace
}  // namespace fracture::bake
