// How much of the shared connections, memory and time a single client may take.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/server/support/exposition.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::test {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kKiB = 1024, kMiB = 1024 * kKiB;

std::string announce(std::size_t bytes) {
  return kPostObj + "Content-Length: " + std::to_string(bytes) + "\r\n\r\n";
}

/// A client that has announced a body and sent a part of it, which the server holds.
std::unique_ptr<RawClient> uploading(TestServer& server, std::size_t announced, std::size_t sent) {
  const std::uint64_t before = server.api.bodies().whole().used();
  auto client = std::make_unique<RawClient>(server.port());
  client->send(announce(announced) + std::string(sent, 'x'));
  if (sent > http::kSmallBody)
    require_eventually(kPatience, "the body to arrive",
                       [&] { return server.api.bodies().whole().used() >= before + sent; });
  return client;
}

struct BodyMemory : testing::Test {
  TestServerOptions options;
  BodyMemory() {
    options.limits.max_bodies = 16 * kMiB;
    options.limits.max_bodies_per_address = 16 * kMiB;
  }
};

TEST_F(BodyMemory, WhatIsAnnouncedHoldsNothing) {
  TestServer server(options);
  std::vector<std::unique_ptr<RawClient>> slow;
  for (int i = 0; i < 8; ++i) slow.push_back(uploading(server, 8 * kMiB, 100 * kKiB));
  EXPECT_LT(server.api.bodies().whole().used(), 4 * kMiB);
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(server.post("/fracture?seed=" + std::to_string(i)).status, 200) << "a collision";
  EXPECT_EQ(server.post("/fracture", std::string(4 * kMiB, 'x')).status, 200) << "and another upload";
}

TEST_F(BodyMemory, SmallBodiesAreTakenWhenLargeOnesHoldAllThereIs) {
  options.limits.max_bodies = options.limits.max_bodies_per_address = 1 * kMiB;
  TestServer server(options);
  const auto holder = uploading(server, 1 * kMiB, 1 * kMiB - 1);
  const Reply large = server.post("/fracture", std::string(100 * kKiB, 'x'));
  EXPECT_EQ(large.status, 503);
  EXPECT_EQ(large.problem(), "overloaded");
  EXPECT_NE(large.header("retry-after"), "");
  EXPECT_EQ(server.post("/fracture", std::string(http::kSmallBody, 'x')).status, 200);
  holder->send("x");
  EXPECT_EQ(holder->receive()->status, 200);
  EXPECT_TRUE(eventually(kPatience, "the room to come back", [&] {
    return server.post("/fracture", std::string(100 * kKiB, 'x')).status == 200;
  }));
}

TEST_F(BodyMemory, AChunkedBodyIsSmallUntilItIsNot) {
  options.limits.max_bodies = options.limits.max_bodies_per_address = 1 * kMiB;
  TestServer server(options);
  const auto holder = uploading(server, 1 * kMiB, 1 * kMiB - 1);
  const auto chunked = [&](std::size_t size) {
    RawClient client(server.port());
    char length[32];
    std::snprintf(length, sizeof length, "%zx\r\n", size);
    client.send(kPostObj + "Transfer-Encoding: chunked\r\n\r\n" + length + std::string(size, 'x') +
                "\r\n0\r\n\r\n");
    return client.receive().value().status;
  };
  EXPECT_EQ(chunked(60 * kKiB), 200);
  EXPECT_EQ(chunked(100 * kKiB), 503);
}

// The data that a chunk adds to its bytes has its own limit; the limit for bodies does not apply.
TEST_F(BodyMemory, AChunkedBodyIsForTheMostPartBody) {
  TestServer server(options);
  constexpr std::size_t kEnough = 64 * kMiB;  // far more than the kernel buffers between the two
  const auto sent_until_answered = [&](const std::string& chunk, int& status) {
    std::string many;
    while (many.size() < 100 * kKiB) many += chunk;
    RawClient client(server.port());
    client.send(kPostObj + "Transfer-Encoding: chunked\r\n\r\n");
    std::size_t sent = 0;
    std::atomic<bool> answered{false};
    std::thread reader([&] {
      const auto reply = client.receive(false, kPatience);
      status = reply ? reply->status : 0;
      answered = true;
    });
    while (!answered && sent < kEnough && client.send(many)) sent += many.size();
    if (!answered) client.half_close();
    reader.join();
    return sent;
  };
  const std::string extension = "1;" + std::string(200, 'e') + "\r\nx\r\n";
  for (const std::string& chunk : {extension, std::string("1\r\nx\r\n")}) {
    int status = 0;
    EXPECT_LT(sent_until_answered(chunk, status), kEnough) << chunk;
    EXPECT_EQ(status, 431) << chunk;
  }
  int status = 0;
  sent_until_answered("3\r\nxxx\r\n", status);
  EXPECT_EQ(status, 413) << "of three bytes each they are taken until the body is too large";
}

TEST_F(BodyMemory, AnAddressHasAShareWhichItsOnlyBodyMayExceed) {
  options.limits.max_bodies_per_address = 0;  // a quarter: 4 MiB
  TestServer server(options);
  EXPECT_EQ(server.get("/limits").json().at("max_bodies_per_address_bytes"), 4 * kMiB);
  EXPECT_EQ(server.post("/fracture", std::string(6 * kMiB, 'x')).status, 200) << "alone";
  // The thread that passed the body on may hold it a moment longer than the answer takes.
  ASSERT_TRUE(
      eventually(kPatience, "an empty budget", [&] { return server.api.bodies().whole().used() == 0; }));
  const auto first = uploading(server, 4 * kMiB, 3 * kMiB);
  const Reply second = server.post("/fracture", std::string(2 * kMiB, 'x'));
  EXPECT_EQ(second.status, 429);
  EXPECT_EQ(second.problem(), "over-share");
  EXPECT_NE(second.header("retry-after"), "");
  EXPECT_EQ(server.post("/fracture?seed=2").status, 200) << "small ones have a share of their own";
}

TEST_F(BodyMemory, AllOfItComesBack) {
  TestServer server(options);
  { const auto gone = uploading(server, 4 * kMiB, 1 * kMiB); }
  server.post("/fracture", std::string(2 * kMiB, 'x'));
  server.post("/fracture", "small");
  EXPECT_TRUE(eventually(kPatience, "an empty budget", [&] {
    return server.api.bodies().whole().used() == 0 && server.api.bodies().whole().small_used() == 0;
  }));
}

TEST(BodyTime, ABodyHasATotalTimeHoweverSteadyItIs) {
  TestServerOptions options;
  options.limits.body_timeout = milliseconds(300);
  options.limits.body_rate = 1;
  TestServer server(options);
  EXPECT_EQ(server.get("/limits").json().at("body_timeout_ms"), 300);
  RawClient client(server.port());
  client.send(announce(1 * kMiB));
  std::thread steady([&] {
    for (int i = 0; i < 2000 && client.send(std::string(100, 'x')); ++i)
      std::this_thread::sleep_for(milliseconds(10));  // pause: a client that sends steadily and slowly
  });
  const auto reply = client.receive();
  client.half_close();
  steady.join();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->problem(), "request-timeout");
  EXPECT_NE(reply->body.find("within 300 ms"), std::string::npos) << reply->body;
}

struct Answers : testing::Test {
  TestServerOptions options;
  static constexpr std::size_t kSize = 32 * kMiB;
  Answers() { options.limits.max_answers = options.limits.max_answers_per_address = 48 * kMiB; }
  /// A client that does not read its answer. The answer is ready to be read.
  static std::unique_ptr<RawClient> not_reading(TestServer& server, int seed) {
    const std::uint64_t before = server.api.answers().used();
    auto client = std::make_unique<RawClient>(server.port());
    client->send("POST /fracture?seed=" + std::to_string(seed) +
                 " HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n\r\nmesh");
    require_eventually(kPatience, "the answer to be on its way",
                       [&] { return server.api.answers().used() > before; });
    return client;
  }
};

TEST_F(Answers, AClientThatReadsTooSlowlyIsCut) {
  options.limits.write_stall = milliseconds(300);
  options.limits.answer_rate = 1024 * kMiB;
  TestServer server(options);
  server.control->glb_padding = kSize;
  RawClient client(server.port());
  client.send(announce(4) + "mesh");
  std::size_t read = 0;
  for (int i = 0; i < 4000 && client.receive_some(8 * kKiB, read); ++i)
    std::this_thread::sleep_for(milliseconds(10));  // pause: steady reads, so that there is never a stall
  EXPECT_LT(read, kSize);
  EXPECT_TRUE(
      eventually(kPatience, "the end of the connection", [&] { return server.server.connections() == 0; }));
}

TEST_F(Answers, WhatIsNotReadIsBoundedAndSaysSo) {
  TestServer server(options);
  server.control->glb_padding = kSize;
  auto first = not_reading(server, 1);
  const Reply refused = server.post("/fracture?seed=2");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.problem(), "overloaded");
  EXPECT_NE(refused.header("retry-after"), "");
  EXPECT_EQ(server.get("/version").status, 200) << "small answers are not counted";
  EXPECT_EQ(server.post("/fracture?seed=1", "mesh", "Content-Type: model/obj\r\n").status, 200)
      << "the same bytes are held once";
  first->reset();
  EXPECT_TRUE(eventually(kPatience, "the room to come back",
                         [&] { return server.post("/fracture?seed=2").status == 200; }));
  EXPECT_TRUE(eventually(kPatience, "nothing held", [&] { return server.api.answers().used() == 0; }));
}

TEST_F(Answers, AnAddressHasAShare) {
  options.limits.max_answers = 200 * kMiB;
  options.limits.max_answers_per_address = 0;  // a quarter: 50 MiB
  TestServer server(options);
  server.control->glb_padding = kSize;
  const auto first = not_reading(server, 1);
  const Reply refused = server.post("/fracture?seed=2");
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(refused.problem(), "over-share");
}

TEST(AdminListener, IdleConnectionsGiveWay) {
  TestServer server;
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 100; ++i) {
    idle.push_back(std::make_unique<RawClient>(server.server.admin_port()));
    if (i % 2 == 1) idle.back()->send("GET /livez HT");  // Half a header is not a request either.
  }
  for (int i = 0; i < 20; ++i) EXPECT_EQ(ask(server.server.admin_port(), "GET", "/livez").status, 200);
}

TEST(AdminListener, WhoAsksAndDoesNotReadGivesWay) {
  TestServer server;
  std::string many;  // The answers to these are larger than the socket buffers.
  for (int k = 0; k < 1500; ++k) many += "GET /metrics HTTP/1.1\r\nHost: a\r\n\r\n";
  std::vector<std::unique_ptr<RawClient>> deaf;
  for (int i = 0; i < sized(20, 40); ++i) {
    deaf.push_back(std::make_unique<RawClient>(server.server.admin_port()));
    deaf.back()->send(many);
  }
  for (int i = 0; i < 20; ++i) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(ask(server.server.admin_port(), "GET", "/livez").status, 200);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10))
        << "before their time is up";
  }
}

TEST(Paths, AnEscapedSlashIsRefused) {
  TestServer server;
  for (const char* path : {"/meshes%2Fsha256:00", "/jobs/a%2fevents", "/%2Fversion", "/version%2F"}) {
    const Reply reply = server.get(path);
    EXPECT_EQ(reply.status, 400) << path;
    EXPECT_EQ(reply.problem(), "malformed-request") << path;
  }
  EXPECT_EQ(server.get("/%76ersion").status, 200) << "other escapes are as good as what they stand for";
  EXPECT_EQ(server.get("/version?a=%2F").problem(), "unknown-parameter") << "in a query it is a value";
}

TEST(Refusals, AreSmallHoweverMuchIsWrong) {
  constexpr std::size_t kSmall = 12 * kKiB;
  TestServer server;
  std::string query = "/fracture?a";
  while (query.size() < 4000) query += "&b";
  const Reply by_query = server.post(query);
  EXPECT_EQ(by_query.problem(), "unknown-parameter");
  EXPECT_LT(by_query.body.size(), kSmall);
  EXPECT_EQ(by_query.json().at("errors").size(), 16u);
  EXPECT_GT(by_query.json().at("more_errors"), 1900);

  std::string params = "{\"site\": 1";
  for (int i = 0; i < test::sized(5'000, 50'000); ++i) params += ", \"x" + std::to_string(i) + "\": 1";
  const std::string form =
      "--B\r\nContent-Disposition: form-data; name=mesh; filename=a.obj\r\n\r\nv\r\n"
      "--B\r\nContent-Disposition: form-data; name=params\r\n\r\n" +
      params + "}\r\n--B--\r\n";
  const Reply by_form = server.post("/fracture", form, "Content-Type: multipart/form-data; boundary=B\r\n");
  EXPECT_EQ(by_form.problem(), "unknown-parameter");
  EXPECT_LT(by_form.body.size(), kSmall);
}

TEST(Refusals, AnUnknownNameIsToldItsNearest) {
  TestServer server;
  const std::string detail = server.post("/fracture?site=1").json().at("detail");
  EXPECT_NE(detail.find("Did you mean 'sites'?"), std::string::npos) << detail;
  EXPECT_NE(detail.find("GET /limits"), std::string::npos) << detail;
  EXPECT_EQ(detail.find("spokes"), std::string::npos) << detail;
  EXPECT_EQ(detail.find("interior_metallic"), std::string::npos) << detail;
}

}  // namespace
}  // namespace fracture::test
