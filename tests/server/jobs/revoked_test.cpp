// A token is revoked, expires or loses its scope while a client still reads with it: nothing more is sent.
#include <gtest/gtest.h>

#include <chrono>
#include <future>

#include "server/http/job_document.hpp"
#include "tests/server/http/with_tenants.hpp"
#include "tests/server/support/job_server.hpp"

namespace fracture::test {
namespace {

struct Revoked : testing::Test {
  TestServer server{with_tenants({tenant("ana"), tenant("bob"), tenant("boss", {"read", "admin"})})};
  Gate gate;
  std::string job;

  void SetUp() override {
    server.control->during_cut = gate.hook();
    job = server.post("/fracture", "mesh", kAsync + by("ana")).header("location");
    gate.wait_for(1);
  }
  void TearDown() override { gate.open = true; }

  void in_force(const std::vector<nlohmann::json>& tenants) {
    server.server.replace_tokens(*tenants::TokenFile::parse(tenant_file(tenants)));
  }
  /// Returns whether the connection closed without an event for the end of the job and without an end of the
  /// answer.
  static bool is_cut_off(RawClient& stream) {
    const std::string all = stream.receive_all();
    return !stream.timed_out() && all.find("event: done") == std::string::npos &&
           !all.ends_with("\r\n0\r\n\r\n");
  }
  /// A stream of events for this name. It has already reported the state of the job.
  std::unique_ptr<RawClient> stream(const std::string& name) {
    auto client = std::make_unique<RawClient>(server.port());
    client->send("GET " + job + "/events HTTP/1.1\r\nHost: a\r\n" + by(name) + "\r\n");
    EXPECT_TRUE(client->receive_until("event: progress"));
    return client;
  }
};

TEST_F(Revoked, ItsStreamEndsAndTellsNothingMore) {
  const auto revoked = stream("ana"), other = stream("boss");
  in_force({tenant("bob"), tenant("boss", {"read", "admin"})});
  EXPECT_TRUE(is_cut_off(*revoked)) << "at once, though nothing happens";
  gate.open = true;
  EXPECT_TRUE(other->receive_until("event: done"));
}

TEST_F(Revoked, WithoutItsScopeItsStreamEndsToo) {
  const auto revoked = stream("ana"), other = stream("boss");
  in_force({tenant("ana", {"fracture", "bake"}), tenant("boss", {"read", "admin"})});
  EXPECT_TRUE(is_cut_off(*revoked));
  gate.open = true;
  EXPECT_TRUE(other->receive_until("event: done"));
}

TEST_F(Revoked, WhoIsNoAdministratorAnyMoreReadsNoOthersJob) {
  const auto former = stream("boss"), own = stream("ana");
  in_force({tenant("ana"), tenant("boss", {"read"})});
  gate.open = true;
  EXPECT_TRUE(former->receive_until("\r\n0\r\n\r\n")) << "the stream ends";
  EXPECT_FALSE(former->receive_until("event: done", std::chrono::seconds(0)));
  EXPECT_TRUE(own->receive_until("event: done"));
}

TEST_F(Revoked, AStreamEndsWhenItsTokenHasExpired) {
  const auto soon = std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now()) +
                    std::chrono::seconds(4);
  nlohmann::json ana = tenant("ana");
  ana["tokens"][0]["expires"] = http::time_text(soon).substr(0, 19) + "Z";
  in_force({ana, tenant("boss", {"read", "admin"})});
  const auto expired = stream("ana"), other = stream("boss");
  EXPECT_TRUE(eventually(kPatience, "the token to expire",
                         [&] { return server.get("/version", by("ana")).status == 401; }));
  gate.open = true;
  EXPECT_TRUE(is_cut_off(*expired));
  EXPECT_TRUE(other->receive_until("event: done"));
}

TEST_F(Revoked, AWaitForAJobEndsWithoutIt) {
  const auto wait = [&](const std::string& name) {
    return std::async(std::launch::async,
                      [&, name] { return server.get(job, "Prefer: wait=60\r\n" + by(name)); });
  };
  auto revoked = wait("ana"), former = wait("boss");
  EXPECT_TRUE(
      eventually(kPatience, "both to wait", [&] { return server.server.requests_in_progress() == 2; }));
  in_force({tenant("bob"), tenant("boss", {"read"})});
  gate.open = true;
  EXPECT_EQ(revoked.get().problem(), "unauthorized");
  EXPECT_EQ(former.get().problem(), "not-found");
}

TEST_F(Revoked, WhatWasAskedForBeforeIsAnswered) {
  auto answer = std::async(std::launch::async, [&] {
    return server.post("/fracture?seed=2", "mesh", "Content-Type: model/gltf-binary\r\n" + by("ana")).status;
  });
  gate.wait_for(2);
  in_force({tenant("bob")});
  gate.open = true;
  EXPECT_EQ(answer.get(), 200);
}

}  // namespace
}  // namespace fracture::test
